// All statements of the page on a setting, as data. The page shows them, and tests compare them with Python.
import type { Comparison } from "../core/core";
import type { Answered } from "../core/drop";
import { exactNumbers } from "../core/exact_numbers";
import { toToml, type Scenario } from "../scenario/scenario";
import { allOf, chosen, type Sentence } from "../support/sentence";
import { factsOf } from "./facts";
import { icmRows, newtonRows, verdictRows, warningRows, why } from "./sentences";
import { sharesOf, tenths, type Shares } from "./shares";
import { rowsOf, type Row } from "./table";

export interface ShareRow {
  name: string;
  color: string; // name of a colour in the style sheet
  percent: [string, string | null]; // of Newton's equations and of independent collisions
}

export interface Report {
  setting: Scenario;
  toml: string;
  tolerance: number;
  newton: Sentence[]; // the headline
  icm: Sentence[]; // empty: not computed yet
  why: Sentence[];
  verdict: (Sentence & { answer: Comparison["answer"] }) | null; // null: not computed yet
  table: Row[];
  shares: { newton: Shares; icm: Shares | null; rows: ShareRow[] };
  numbers: Record<string, number | null>; // in full precision
}

// n = 0: a cradle, which has neither top nor bottom.
export const ballName = (i: number, n: number): string =>
  n > 0 && i === n - 1 ? "top ball" : n > 0 && i === 0 ? "lowest ball" : `ball ${i + 1}`;

const percent = (tenth: number, share: number): string =>
  tenth === 0 && share > 0 ? "<0.1 %" : `${(tenth / 10).toFixed(1)} %`;

function shareRows(newton: Shares, icm: Shares | null, s: Scenario): ShareRow[] {
  const n = s.balls.length;
  const names = [
    ...s.balls.map((_, i) => ballName(i, s.cradle ? 0 : n)).reverse(),
    "stored in contacts",
    "lost in contacts",
  ];
  const colors = [...s.balls.map((_, i) => `ball${n - i}`), "muted", "lost"];
  const list = (x: Shares): number[] => [...x.balls].reverse().concat(x.stored, x.lost);
  const [a, b] = [list(newton), icm && list(icm)];
  const [ta, tb] = [tenths(a), b && tenths(b)];
  const rows = names.map((name, i): ShareRow => ({
    name,
    color: colors[i],
    percent: [percent(ta[i], a[i]), b && percent(tb![i], b[i])],
  }));
  return rows.filter((_, i) => i !== n || a[i] > 0 || (b?.[i] ?? 0) > 0);
}

function verdictOf(d: Answered): Report["verdict"] {
  if (!d.icm || !d.comparison) return null;
  const sentence = chosen(verdictRows, {
    ...d.comparison,
    newtonRun: d.newton.run,
    icmRun: d.icm.run,
    floor: !d.scenario.cradle,
  })!;
  return { ...sentence, answer: d.comparison.answer };
}

export function reportOf(d: Answered, tolerance: number): Report {
  const facts = factsOf(d, tolerance);
  const { icm } = d;
  const shares = { newton: sharesOf(d.newton, d.scenario), icm: icm && sharesOf(icm, d.scenario) };
  return {
    setting: d.scenario,
    toml: toToml(d.scenario),
    tolerance,
    newton: [chosen(newtonRows, facts)!, ...allOf(warningRows, facts)],
    icm: icm ? [chosen(icmRows, { ...facts, icm })!] : [],
    why: why({ balls: facts.balls, cradle: facts.cradle, newton: d.newton.run, icm: icm && icm.run }),
    verdict: verdictOf(d),
    table: rowsOf(d),
    shares: { ...shares, rows: shareRows(shares.newton, shares.icm, d.scenario) },
    numbers: exactNumbers(d),
  };
}
