// Points of a map: what both models give for a setting moved along two axes. Runs in a worker.
import { placed, type MapAxis } from "../scenario/axes";
import type { Scenario } from "../scenario/scenario";
import { answers, Model, failures, SCAN_VALUES, type Core } from "./core";

export interface MapTask {
  scenario: Scenario;
  axes: [x: MapAxis, y: MapAxis];
  tolerance: number | null; // of the verdict; null: the verdict is not asked for
  points: Float64Array; // (x, y) each
}

// Of a point: contacts, ε_eff/ε at t_f and at separation; index of the answer to whether both models agree, and the
// relative difference of their velocities. Contacts NaN: the balls cannot fall, or Newton's equations have no answer.
export const MAP_VALUES = 5;

const isOutside = (outcome: number): boolean => outcome === failures.invalid || outcome === failures.neverLands;
const isUnclear = (outcome: number): boolean => outcome === failures.unresolved || outcome === failures.tooDeep;

export function mapPoints(core: Core, { scenario, axes: [x, y], tolerance, points }: MapTask): Float64Array {
  const out = new Float64Array((MAP_VALUES * points.length) / 2).fill(NaN);
  const settings = Array.from({ length: points.length / 2 }, (_, i) =>
    placed(scenario, [
      [x, points[2 * i]],
      [y, points[2 * i + 1]],
    ]),
  );
  const put = (i: number, values: ArrayLike<number>): void => out.set(values, MAP_VALUES * i);
  if (tolerance !== null) settings.forEach((s, i) => s && put(i, judged(core, s, tolerance)));
  else if (x === "e" && (y === "gap" || y === "ratio")) {
    core.set(scenario);
    const values = core.scan(y === "gap" ? 0 : 1, points);
    settings.forEach((s, i) => s && put(i, known(core, s, values.subarray(SCAN_VALUES * i, SCAN_VALUES * (i + 1)))));
  } else settings.forEach((s, i) => s && put(i, known(core, s, scanned(core, s))));
  return out;
}

// The fast solver of maps, for one setting: at its own ε and R₁/R₂.
function scanned(core: Core, s: Scenario): Float64Array {
  core.set(s);
  return core.scan(1, Float64Array.of(s.restitution, s.balls[0].radius / s.balls[1].radius));
}

// The fast solver counts contacts also where Newton's equations stop before the end. There ε_eff is unknown.
function known(core: Core, s: Scenario, values: Float64Array): Float64Array {
  if (s.cradle || s.balls.length !== 2 || !Number.isNaN(values[1]) || Number.isNaN(values[0])) return values;
  core.set(s);
  const outcome = core.solve(Model.newton)?.outcome ?? failures.invalid;
  return isOutside(outcome) || isUnclear(outcome) ? Float64Array.of(NaN) : values;
}

// The verdict of the page.
function judged(core: Core, s: Scenario, tolerance: number): number[] {
  core.set(s);
  const newton = core.solve(Model.newton);
  if (!newton || isOutside(newton.outcome) || !core.solve(Model.independent)) return [NaN];
  const { answer, error } = core.compare(tolerance);
  const { nContacts, effective, effectiveSeparation } = newton;
  return [nContacts, effective / s.restitution, effectiveSeparation / s.restitution, answers.indexOf(answer), error];
}
