// The means over the starts, and every start, as a CSV file.
import { csvText } from "../support/csv";
import { measureOf, type Facts } from "./facts";
import { pythonOf } from "./python";
import { INTERVALS, type OneStart } from "./starts";
import { at, differenceAt, predictedAt, spread, surplusAt } from "./statistics";
import { toQuery } from "./setting";

// Rows are times. Unknown values are nan.
export function csvOf(f: Facts): string {
  const { starts } = f;
  const { setting, until, known } = f.start;
  const measure = measureOf(f);
  const columns: [name: string, value: (k: number) => number][] = [["time", (k) => (k / INTERVALS) * until]];
  const means = (name: string, of: (s: OneStart) => readonly number[]): void => {
    columns.push([`${name}_mean`, (k) => spread(at(starts, of, k)).mean]);
    columns.push([`${name}_scatter`, (k) => spread(at(starts, of, k)).scatter]);
  };
  (["event_driven", "newton"] as const).forEach((name, world) => {
    means(`${name}_energy`, (s) => s.energy[world]);
    means(`${name}_contacts`, (s) => s.contacts[world]);
    if (setting.friction > 0) means(`${name}_temperature_ratio`, (s) => s.ratio[world]);
  });
  for (const [name, of] of [
    [`${measure}_difference`, (k: number) => differenceAt(starts, measure, k)],
    ["newton_surplus", (k: number) => surplusAt(starts, k)],
  ] as const) {
    columns.push([name, (k) => of(k)?.value ?? NaN], [`${name}_standard_error`, (k) => of(k)?.error ?? NaN]);
  }
  if (known && measure === "cooling")
    columns.push(["cooling_difference_by_law", (k) => predictedAt(starts, k)?.cooling[0] ?? NaN]);
  for (const start of starts)
    (["event_driven", "newton"] as const).forEach((name, world) =>
      columns.push([`${name}_energy_of_seed_${start.seed}`, (k) => start.energy[world][k]]),
    );
  const comments = [
    `${starts.length} starts; gas.html?${toQuery(setting)}`,
    `time: s; energies over those at the start; differences: event-driven over Newton's − 1; scatter: standard deviation`,
    pythonOf(f),
  ];
  const rows = Array.from({ length: INTERVALS + 1 }, (_, k) => columns.map(([, value]) => value(k)));
  return csvText(
    comments,
    columns.map(([name]) => name),
    rows,
  );
}
