// Rebound height of the top ball under both models (cradle: velocity of the last ball); runs in a worker.
import { Model, type Core } from "./core";

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
