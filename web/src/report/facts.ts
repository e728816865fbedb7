// The values that sentences depend on.
import type { Comparison, Contact, Run } from "../core/core";
import type { Answered, Drop, Track } from "../core/drop";
import { aloneRise, nameOfBall } from "../scenario/measured";
import { releaseHeight } from "../scenario/scenario";
import { digits, lengths, withUnit } from "../support/format";
import type { Numbers } from "../support/sentence";
import type { Report } from "./report";

export const outcomes = { ok: 0, noContact: 1, atRest: 2, collapse: 4, unresolved: 5, tooDeep: 7 };

export const speed = (v: number): string => (Number.isFinite(v) ? withUnit(v, "m/s", 3, true) : "an unknown velocity");

// ---- the headline ------------------------------------------------------------------------------------------

export interface Facts {
  balls: number;
  cradle: boolean;
  newton: Track;
  icm: Track | null; // null: not computed yet
  tolerance: number;
}
export interface BothFacts extends Facts {
  icm: Track;
}

export const factsOf = ({ scenario, newton, icm }: Answered, tolerance: number): Facts => ({
  balls: scenario.balls.length,
  cradle: scenario.cradle,
  newton,
  icm,
  tolerance,
});

export const top = (t: Track): number => t.peaks[t.peaks.length - 1];
export const rises = (t: Track): boolean => Number.isFinite(top(t));
export const lastVelocity = (t: Track): number => t.leaves[t.leaves.length - 1];
export const heights = (f: Facts): [string, string] => lengths(top(f.newton), f.icm ? top(f.icm) : NaN);
export const ratioOf = (f: Facts): number => (f.icm ? top(f.icm) / top(f.newton) : NaN);

// ---- the verdict -------------------------------------------------------------------------------------------

export interface VerdictFacts extends Comparison {
  newtonRun: Run;
  icmRun: Run;
  floor: boolean;
}

// ---- the contacts ------------------------------------------------------------------------------------------

export interface RunFacts {
  balls: number;
  cradle: boolean;
  newton: Run;
  icm: Run | null; // null: not computed yet
}

interface Span {
  pair: number;
  begin: number;
  end: number; // infinite: never
}

export interface ContactFacts extends RunFacts {
  list: Span[]; // contacts of the sequence by Newton's equations
  between: Span[]; // those between balls
  floor: Span | undefined; // first contact with the floor
  first: number; // begin of the first contact between balls
  most: number; // largest number of contacts at the same time
  longest: number; // duration of the longest contact
  instant: number; // first collision of the two lowest balls in the collision model; NaN: none
}

// Contacts of the sequence; those that never end last until infinity.
const spans = (contacts: Contact[], last: number): Span[] =>
  contacts.filter((c) => c.begin <= last).map((c) => ({ ...c, end: Number.isFinite(c.end) ? c.end : Infinity }));

// Largest number of simultaneous contacts.
function mostAtOnce(list: Span[]): number {
  const edges = list.flatMap((c) => [
    { at: c.begin, by: 1 },
    { at: c.end, by: -1 },
  ]);
  edges.sort((a, b) => a.at - b.at || a.by - b.by); // a contact that ends as another begins does not overlap it
  let now = 0;
  let most = 0;
  for (const { by } of edges) {
    now += by;
    most = Math.max(most, now);
  }
  return most;
}

export function contactFacts(f: RunFacts): ContactFacts {
  const list = spans(f.newton.contacts, f.newton.last);
  const between = list.filter((c) => c.pair > 0);
  return {
    ...f,
    list,
    between,
    floor: list.find((c) => c.pair === 0),
    first: between.reduce((least, c) => Math.min(least, c.begin), Infinity),
    most: mostAtOnce(list),
    longest: list.reduce((most, c) => Math.max(most, c.end - c.begin), 0),
    instant: f.icm?.contacts.find((c) => c.pair === 1)?.begin ?? NaN,
  };
}

// ---- the story ---------------------------------------------------------------------------------------------

export type Fall = "before" | "falling" | "over";

// What the map says of the present ε.
export interface Trusted {
  gap: number; // as agreement_gaps() of the core has it [m]
  widest: number; // gap of the map [m]
}

export interface StoryFacts {
  drop: Drop;
  report: Pick<Report, "numbers" | "tolerance" | "why" | "newton" | "icm" | "verdict">;
  guess: number | null; // m
  fall: Fall; // of the balls beside the ruler
  // Newton's height at gap 0, the greatest height, and its gap; null: not known.
  gaps: { touching: number; best: number; at: number } | null;
  trusted: Trusted | null; // null: not computed
  lent: boolean; // the chapter has balls of its own
  back: boolean; // the chapter before had
}

export const cradle = (t: StoryFacts): boolean => t.drop.scenario.cradle;
export const count = (t: StoryFacts): number => t.drop.scenario.balls.length;
export const topName = (t: StoryFacts): string => nameOfBall(t.drop.scenario.balls[count(t) - 1], "top ball");
export const lowName = (t: StoryFacts): string => nameOfBall(t.drop.scenario.balls[0], "lowest ball");
export const release = (t: StoryFacts): number => releaseHeight(t.drop.scenario);

// Number of contacts of balls in Newton's sequence that overlap another contact in time.
export function overlapping({ drop: { newton } }: StoryFacts): number {
  const list = spans(newton.run.contacts, Infinity);
  const overlap = (a: Span): boolean => list.some((b) => a !== b && a.begin < b.end && b.begin < a.end);
  const sequence = list.filter((c) => c.pair > 0).slice(0, newton.run.nContacts);
  return sequence.filter(overlap).length;
}

// The rebound height of the top ball, on a cradle the velocity of the last one; NaN: there is none.
const value = (t: StoryFacts, model: "newton" | "icm"): number =>
  t.report.numbers[`${model}_${cradle(t) ? "velocity" : "rise"}_${count(t)}`] ?? NaN;
export const newton = (t: StoryFacts): number => value(t, "newton");
export const icm = (t: StoryFacts): number => value(t, "icm");
export const bothValues = (t: StoryFacts): Numbers => ({
  newton: newton(t),
  icm: icm(t),
  tolerance: t.report.tolerance,
});
export const agree = (t: StoryFacts): boolean => Math.abs(icm(t) / newton(t) - 1) <= t.report.tolerance;

// Whether a sequence has ended with balls that met; on a floor the top ball then rises.
const plain = ({ run }: Track, height: number): boolean =>
  run.outcome === outcomes.ok && run.nContacts > 0 && Number.isFinite(height);
export const bothPlain = (t: StoryFacts): boolean => plain(t.drop.newton, newton(t)) && plain(t.drop.icm, icm(t));
export const answered = (t: StoryFacts): boolean =>
  ![outcomes.tooDeep, outcomes.unresolved].includes(t.drop.newton.run.outcome);

export const alone = (t: StoryFacts): ReturnType<typeof aloneRise> =>
  aloneRise(t.drop.scenario.balls[count(t) - 1], release(t));

export function comparedWithRelease(t: StoryFacts): string {
  const ratio = newton(t) / release(t);
  if (ratio < 1) return "lower than where it was let go";
  return ratio < 1.05
    ? "hardly higher than where it was let go"
    : `${digits(ratio, 2)} times as high as where it was let go`;
}
