// The sentences of the story, from the report of the present setting. One table for each chapter.
import type { Drop } from "../core/drop";
import { capital } from "../scenario/tables";
import type { Report } from "../report/report";
import { chosen, type Case, type Numbers, type Sentence } from "../report/sentence";
import { inPercent } from "../scenario/tolerance";
import { counted, spell, times } from "../report/words";
import { aloneRise, measuredLike } from "../scenario/measured";
import type { Ball } from "../scenario/scenario";
import { digits, metres, withUnit } from "../support/format";
import type { Step } from "../scenario/lecture_view";

export type Fall = "before" | "falling" | "over";

export interface Told {
  drop: Drop;
  report: Report;
  guess: number | null; // m
  fall: Fall; // of the balls beside the ruler
  gaps: { touching: number; best: number; at: number } | null; // Newton's heights at gap 0 and the highest, with its gap
  trusted: number | null; // gap above which both models agree [m]; infinite: nowhere in the map; null: not known
}

const titles: Record<Step, string> = {
  watch: "One bounce, two models",
  predict: "How high will it fly?",
  slow: "Slowly, through the contact",
  count: "Count the contacts",
  gap: "Change the gap",
  map: "Where event-driven simulation may be trusted",
};

const onCradle: Partial<Record<Step, string>> = { predict: "How fast will the last one leave?" };
export const titleOf = (step: Step, cradle: boolean): string => (cradle && onCradle[step]) || titles[step];

// "basketball" where radius and mass are those of one, else what the place in the column says.
export const nameOfBall = (b: Ball, place: string): string => measuredLike(b)?.short ?? place;

// Height of the top ball's centre at release [m].
export function releaseHeight(d: Drop): number {
  const { height, balls, gaps } = d.scenario;
  return balls.slice(1).reduce((z, b, i) => z + balls[i].radius + gaps[i] + b.radius, height);
}

// ---- what the tables use ---------------------------------------------------------------------------------

const count = (t: Told): number => t.drop.scenario.balls.length;
const topName = (t: Told): string => nameOfBall(t.drop.scenario.balls[count(t) - 1], "top ball");
const lowName = (t: Told): string => nameOfBall(t.drop.scenario.balls[0], "lowest ball");
const value = (t: Told, model: "newton" | "icm"): number =>
  t.report.numbers[`${model}_${t.drop.scenario.cradle ? "velocity" : "rise"}_${count(t)}`] ?? NaN;
const newton = (t: Told): number => value(t, "newton");
const icm = (t: Told): number => value(t, "icm");
const speed = (x: number): string => (Number.isFinite(x) ? withUnit(x, "m/s", 3, true) : "an unknown velocity");
const both = (t: Told): Numbers => ({ newton: newton(t), icm: icm(t), tolerance: t.report.tolerance });
const agree = (t: Told): boolean => Math.abs(icm(t) / newton(t) - 1) <= t.report.tolerance;
const cradle = (t: Told): boolean => t.drop.scenario.cradle;

function compared(t: Told): string {
  const ratio = newton(t) / releaseHeight(t.drop);
  return ratio < 1
    ? "lower than where it was let go"
    : ratio < 1.05
      ? "hardly higher than where it was let go"
      : `${digits(ratio, 2)} times as high as where it was let go`;
}
const guessed = (t: Told): string =>
  t.guess === null
    ? ""
    : ` You said ${withUnit(t.guess, "m", 2)}${Math.abs(t.guess / newton(t) - 1) < 0.1 ? ": well guessed!" : "."}`;
const column = (t: Told): string =>
  count(t) === 2 && topName(t) !== "top ball" && lowName(t) !== "lowest ball"
    ? `A ${topName(t)} above a ${lowName(t)}: both`
    : `${capital(spell(count(t)))} balls, one above the other,`;

const fixed = (id: string, text: string): Case<Told> => ({ id, when: () => true, say: () => text });

// ---- the tables ------------------------------------------------------------------------------------------

const watch: Case<Told>[] = [
  {
    id: "watch-cradle",
    when: (t) => cradle(t) && Number.isFinite(newton(t)) && Number.isFinite(icm(t)),
    say: (t) =>
      `By Newton’s equations the last ball leaves with ${speed(newton(t))}, by one collision after the other with ${speed(icm(t))}.`,
    numbers: both,
  },
  {
    id: "watch-newton-only",
    when: (t) => Number.isFinite(newton(t)) && !Number.isFinite(icm(t)),
    say: (t) =>
      cradle(t)
        ? `By Newton’s equations the last ball leaves with ${speed(newton(t))}; one collision after the other gives no answer.`
        : `By Newton’s equations the ${topName(t)} rises to ${metres(newton(t))}; one collision after the other gives no height.`,
    numbers: (t) => ({ newton: newton(t) }),
  },
  {
    id: "watch-agree",
    when: (t) => Number.isFinite(newton(t)) && agree(t),
    say: (t) =>
      `The ${topName(t)} rises to ${metres(newton(t))}, and one collision after the other says the same to ${inPercent(t.report.tolerance)}.`,
    numbers: both,
  },
  {
    id: "watch-differ",
    when: (t) => Number.isFinite(newton(t)),
    say: (t) =>
      `By Newton’s equations the ${topName(t)} rises to ${metres(newton(t))}; the textbook, one collision after the other, promises ${metres(icm(t))}.`,
    numbers: both,
  },
  {
    id: "watch-textbook-only",
    when: (t) => Number.isFinite(icm(t)),
    say: (t) =>
      cradle(t)
        ? `One collision after the other says ${speed(icm(t))} for the last ball; Newton’s equations give no velocity.`
        : `The textbook, one collision after the other, promises ${metres(icm(t))} for the ${topName(t)}; Newton’s equations give no height.`,
    numbers: (t) => ({ icm: icm(t) }),
  },
  { id: "watch-none", when: () => true, say: (t) => `The ${cradle(t) ? "last ball" : topName(t)} does not bounce.` },
];

const before = (t: Told): boolean => t.fall === "before";
const predict: Case<Told>[] = [
  {
    id: "predict-cradle",
    when: (t) => before(t) && cradle(t),
    say: (t) =>
      `${capital(spell(count(t)))} balls in a line, and no floor. The first arrives: with what speed will the last one leave?`,
  },
  {
    id: "predict",
    when: before,
    say: (t) =>
      `${column(t)} are let go together, the ${topName(t)} ${metres(releaseHeight(t.drop))} above the floor. How high will the ${topName(t)} rise after the bounce? Drag the line there, then let them drop.`,
    numbers: (t) => ({ release: releaseHeight(t.drop) }),
  },
  { id: "drop-wait-cradle", when: (t) => cradle(t) && t.fall === "falling", say: () => "Watch the last ball …" },
  {
    id: "drop-cradle",
    when: cradle,
    say: (t) =>
      `The last ball leaves with ${speed(newton(t))}; the textbook, one collision after the other, says ${speed(icm(t))}.`,
    numbers: both,
  },
  { id: "drop-wait", when: (t) => t.fall === "falling", say: () => "Watch the ruler …" },
  { id: "drop-none", when: (t) => !Number.isFinite(newton(t)), say: (t) => `The ${topName(t)} does not bounce.` },
  {
    id: "drop-newton-only",
    when: (t) => !Number.isFinite(icm(t)),
    say: (t) => `The ${topName(t)} rises to ${metres(newton(t))}, ${compared(t)}.${guessed(t)}`,
    numbers: (t) => ({ newton: newton(t) }),
  },
  {
    id: "drop-agree",
    when: agree,
    say: (t) =>
      `The ${topName(t)} rises to ${metres(newton(t))}, ${compared(t)}.${guessed(t)} The textbook, one collision after the other, agrees to ${inPercent(t.report.tolerance)}: ${metres(icm(t))}.`,
    numbers: both,
  },
  {
    id: "drop-differ",
    when: () => true,
    say: (t) =>
      `The ${topName(t)} rises to ${metres(newton(t))}, ${compared(t)}.${guessed(t)} The textbook, one collision after the other, promises ${metres(icm(t))}.`,
    numbers: both,
  },
];

const touch = (t: Told): string =>
  `At ε = ${Number(t.drop.scenario.restitution.toPrecision(3))} ${count(t) === 2 ? "the balls" : "neighbouring balls"} touch ${times(t.drop.newton.run.nContacts)}`;
const counts = (t: Told): Numbers => ({ newton: t.drop.newton.run.nContacts, icm: t.drop.icm.run.nContacts });
const more = "The bands show when they touch, for every ε: drag the line to another ε, and count again.";
const counting: Case<Told>[] = [
  {
    id: "count-without-end",
    when: (t) => [4, 5].includes(t.drop.icm.run.outcome),
    say: (t) => `${touch(t)}; the collision model counts without end. ${more}`,
    numbers: counts,
  },
  {
    id: "count-differs",
    when: (t) => t.drop.newton.run.nContacts !== t.drop.icm.run.nContacts,
    say: (t) => `${touch(t)}; the collision model counts ${counted(t.drop.icm.run.nContacts, "collision")}. ${more}`,
    numbers: counts,
  },
  {
    id: "count-overlaps",
    when: (t) => t.drop.comparison.overlapping > 0,
    say: (t) =>
      `${touch(t)}, as often as in the collision model; but here ${t.drop.newton.run.nContacts === 1 ? "the contact overlaps" : `${spell(t.drop.comparison.overlapping)} of the contacts overlap${t.drop.comparison.overlapping === 1 ? "s" : ""}`} another one in time. ${more}`,
    numbers: (t) => ({ ...counts(t), overlapping: t.drop.comparison.overlapping }),
  },
  {
    id: "count-same",
    when: () => true,
    say: (t) => `${touch(t)}, as often as in the collision model. ${more}`,
    numbers: counts,
  },
];

const measured =
  "Drag in the plot to change the gap. That balls dropped closer together rebound lower was measured in Bristol in 2015.";
const gap: Case<Told>[] = [
  fixed(
    "gap-cradle",
    "Drag in the plot to change the gaps between the balls: the wider they are, the more they collide one after the other.",
  ),
  {
    id: "gap-unknown",
    when: (t) => !t.gaps || !Number.isFinite(t.gaps.touching) || !Number.isFinite(t.gaps.best),
    say: () => measured,
  },
  {
    id: "gap-none-better",
    when: (t) => !(t.gaps!.at > 0),
    say: (t) =>
      `Let go touching, the ${topName(t)} reaches ${metres(t.gaps!.touching)}; no gap brings it higher. ${measured}`,
    numbers: (t) => ({ touching: t.gaps!.touching }),
  },
  {
    id: "gap-better",
    when: () => true,
    say: (t) =>
      `Let go touching, the ${topName(t)} reaches ${metres(t.gaps!.touching)}; ${withUnit(t.gaps!.at, "m", 2)} apart, ${metres(t.gaps!.best)}. ${measured}`,
    numbers: (t) => ({ ...t.gaps! }),
  },
];
gap[0].when = cradle;

const alone = (t: Told): ReturnType<typeof aloneRise> =>
  aloneRise(t.drop.scenario.balls[count(t) - 1], releaseHeight(t.drop));
const experiment: Case<Told>[] = [
  {
    id: "alone",
    when: (t) => !cradle(t) && alone(t) !== null,
    say: (t) =>
      `Of these balls together we know no published heights as numbers; your own can be loaded. Alone, the ${topName(t)} would come back to ${metres(alone(t)!.low)} to ${metres(alone(t)!.high)}, by the bounce that the rules of the ${alone(t)!.by} ask of it.`,
    numbers: (t) => ({ low: alone(t)!.low, high: alone(t)!.high }),
  },
  {
    id: "no-experiment",
    when: (t) => !cradle(t),
    say: () => "Of these balls together we know no published heights as numbers; your own can be loaded.",
  },
];

const line = (t: Told): string => `Above the line both models agree to ${inPercent(t.report.tolerance)}`;
const map: Case<Told>[] = [
  {
    id: "map-cradle",
    when: cradle,
    say: () => "The map counts contacts. Event-driven simulation is right where no two of them overlap.",
  },
  {
    id: "map-many",
    when: (t) => count(t) > 2,
    say: (t) =>
      `Event-driven simulation takes contacts one after another. Where the map counts more than ${spell(count(t) - 1)}, one for each pair of neighbours, it leaves some out; where it counts as many, they may still overlap.`,
  },
  {
    id: "map-pending",
    when: (t) => t.trusted === null,
    say: (t) => `The line will show from which gap on both models agree to ${inPercent(t.report.tolerance)}.`,
    numbers: (t) => ({ tolerance: t.report.tolerance }),
  },
  {
    id: "map-nowhere",
    when: (t) => t.trusted === Infinity,
    say: (t) =>
      `At the present ε the models agree to ${inPercent(t.report.tolerance)} at no gap of this map: even where no contacts overlap, gravity acts while they last. Choose another tolerance, or stiffer balls.`,
    numbers: (t) => ({ tolerance: t.report.tolerance }),
  },
  {
    id: "map",
    when: () => true,
    say: (t) =>
      `${line(t)}; at the present ε that takes a gap above ${withUnit(t.trusted!, "m", 2)}. Just below the line they differ by more.`,
    numbers: (t) => ({ tolerance: t.report.tolerance, gap: t.trusted! }),
  },
];

const tables: Record<Exclude<Step, "slow">, Case<Told>[]> = { watch, predict, count: counting, gap, map };

// The chapter on the contact says why; its sentences are those of the report.
export function story(step: Step, t: Told): Sentence[] {
  if (step === "slow") return t.report.why;
  const measured = step === "gap" ? chosen(experiment, t) : null;
  return [chosen(tables[step], t)!, ...(measured ? [measured] : [])];
}
