// Rebound height of the top ball under both models (cradle: velocity of the last ball); runs in a worker.
import { Model, type Core } from "./core";

// Results of both models for a column.
function riseOf(core: Core, column: Float64Array): [number, number] {
  const n = column[6];
  const cradle = column[7] === 0;
  core.setColumn(column);
  const one = (model: Model): number => {
    const run = core.solve(model);
    if (!run || !Number.isFinite(run.last)) return NaN;
    return cradle ? core.sample(model, [run.last])[0].velocity[n - 1] : core.reboundHeights(model)[n - 1];
  };
  return [one(Model.newton), one(Model.independent)];
}

// Both values for each of the columns, one after another.
export function risesOf(core: Core, columns: Float64Array[]): Float64Array {
  return Float64Array.from(columns.flatMap((column) => riseOf(core, column)));
}
