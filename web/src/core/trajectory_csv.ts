// The trajectories of both models as a CSV file.
import { Clock } from "./clock";
import { Model, type Core } from "./core";
import { solve, type Solved } from "./drop";
import { exactNumbers } from "./exact_numbers";
import { csvText } from "../support/csv";
import { settingLines, type Scenario } from "../scenario/scenario";

// Rows are equidistant in the time of the film, and therefore dense in contacts. Unknown values are nan. Null: no data.
export function trajectoryCsv(core: Core, scenario: Scenario): string | null {
  const d = solve(core, scenario);
  if ("reason" in d) return null;
  const times = timesOf(d);
  const n = scenario.balls.length;
  const numbers = [times.map((t) => [t])];
  for (const [model, t] of [
    [Model.newton, d.newton],
    [Model.independent, d.icm],
  ] as const) {
    const rows = core.sample(model, times).map((s) => {
      const contacts = Array.from({ length: model === Model.newton ? n : 0 }, (_, j) => [s.gap[j], s.force[j]]);
      return [...s.position, ...s.velocity, ...contacts.flat(), s.dissipated];
    });
    numbers.push(rows.map((row, k) => (times[k] <= t.known ? row : row.map(() => NaN))));
  }
  return csvText(
    preamble(d),
    columns(n),
    times.map((_, k) => numbers.flatMap((part) => part[k])),
  );
}

function timesOf(d: Solved): number[] {
  const clock = new Clock(d.start, d.stop, d.windows);
  const times = new Set<number>(d.times);
  for (let i = 0; i <= 600; i++) times.add(clock.toPhysical((i / 600) * clock.length));
  for (const t of [d.newton, d.icm])
    for (const c of t.shown.slice(0, 5000)) for (const time of [c.begin, c.end]) times.add(time);
  return [...times].filter((t) => t >= d.start && t <= d.stop).sort((a, b) => a - b);
}

function preamble(d: Solved): string[] {
  const lines = settingLines(d.scenario);
  lines.push(
    `time: s after ${d.scenario.cradle ? "release" : "the first floor touch"}; lengths m, velocities m/s, forces ` +
      `N, energies J`,
  );
  for (const [key, value] of Object.entries(exactNumbers(d))) lines.push(`${key} = ${value ?? "nan"}`);
  return lines;
}

function columns(n: number): string[] {
  const head = ["time"];
  for (const name of ["newton", "icm"]) {
    for (const quantity of ["position", "velocity"]) for (let i = 1; i <= n; i++) head.push(`${name}_${quantity}_${i}`);
    if (name === "newton")
      for (let j = 0; j < n; j++) head.push(`newton_gap_${j}${j + 1}`, `newton_force_${j}${j + 1}`);
    head.push(`${name}_dissipated`);
  }
  return head;
}
