// Rebound height of the top ball under both models (cradle: velocity of the last ball); runs in a worker.
import { Model, type Core } from "./core";
import { measuredLike } from "../scenario/measured";
import { columnOf, copyOf, setOwn, hasOwn, type Scenario } from "../scenario/scenario";

// Results of both models for a column.
function riseOf(core: Core, column: Float64Array): [number, number] {
  const n = column[2];
  const cradle = column[3] === 0;
  core.setColumn(column);
  const rise = (model: Model): number => {
    const run = core.solve(model);
    if (!run || !Number.isFinite(run.last)) return NaN;
    return cradle ? core.finalVelocities(model)[n - 1] : core.reboundHeights(model)[n - 1];
  };
  return [rise(Model.newton), rise(Model.independent)];
}

// Both values for each column, in sequence.
export function risesOf(core: Core, columns: Float64Array[]): Float64Array {
  return Float64Array.from(columns.flatMap((column) => riseOf(core, column)));
}

// The balls that can be bought have a known mass, size and bounce; how stiff they are where they touch is not known.
// Newton's heights of the top ball with half and with twice the stiffness there; null: no such balls.
export function bandOf(core: Core, scenario: Scenario): [number, number] | null {
  const { balls, cradle, law } = scenario;
  if (cradle || law !== "linear" || balls.length !== 2 || !balls.every(measuredLike)) return null;
  const [soft, stiff] = [0.5, 2].map((factor) => {
    const s = copyOf(scenario);
    if (!hasOwn(s)) setOwn(s, true);
    s.own.stiffness = s.own.stiffness.map((k) => factor * k);
    return riseOf(core, columnOf(s))[0];
  });
  return Number.isFinite(soft) && Number.isFinite(stiff) ? [soft, stiff] : null;
}
