// The lowest ball alone on the floor: what one contact is, before a second ball arrives.
import { Model, type Core } from "./core";
import { copyOf, type Scenario } from "../scenario/scenario";

export interface LoneBall {
  arrives: number; // speed at the floor [m/s]
  leaves: number; // speed as the contact ends [m/s]
  end: number; // of the contact [s]
  times: Float64Array; // from 0 to `end` [s]
  force: Float64Array; // of the floor [N]
  compression: Float64Array; // [m]
}

const points = 121;
const far = 1e3; // gap [m] of the second ball, which arrives long after the contact

// null: a cradle, or the ball stays on the floor.
export function loneBall(core: Core, scenario: Scenario): LoneBall | null {
  if (scenario.cradle) return null;
  const s = copyOf(scenario);
  s.balls = [s.balls[0], s.balls[0]];
  s.gaps = [far];
  s.velocities = [0, 0];
  s.own = {};
  core.set(s);
  const run = core.solve(Model.newton);
  const arrival = run?.contacts.find((c) => c.pair === 1)?.begin ?? Infinity;
  if (!run || !(run.tFloorEnd > 0 && run.tFloorEnd < arrival)) return null;
  const end = run.tFloorEnd;
  const times = Float64Array.from({ length: points }, (_, i) => (end * i) / (points - 1));
  const states = core.sample(Model.newton, times);
  const velocity = states[points - 1].velocity[0];
  return {
    arrives: run.impactSpeed,
    leaves: velocity,
    end,
    times,
    force: Float64Array.from(states, ({ force: [f] }) => (Number.isFinite(f) ? Math.max(f, 0) : 0)),
    compression: Float64Array.from(states, ({ gap: [gap] }) => Math.max(-gap, 0)),
  };
}
