// Explains in one or two sentences, from the numbers of this setting, why the two models differ or agree.
import type { Contact, Run } from "../core/core";
import { withUnit } from "../support/format";

// Input of the sentence; a Drop provides it.
export interface Facts {
  balls: number;
  cradle: boolean;
  newton: Run;
  icm: Run;
}

const outcomes = { noContact: 1, atRest: 2, collapse: 4, unresolved: 5 };

const numerals = ["no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve"];
export const spell = (n: number): string => numerals[n] ?? String(n);
export const times = (n: number): string => (n === 1 ? "once" : n === 2 ? "twice" : `${spell(n)} times`);
const duration = (t: number): string => withUnit(Math.max(t, 0), "s");

interface Span {
  pair: number;
  begin: number;
  end: number; // infinity: never
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

// Compression over the smaller radius above which a contact law is questionable.
export const SHALLOW = 0.05;

export function why(facts: Facts): string {
  if (facts.newton.tooDeep >= 0) return tooDeep(facts.newton);
  const said = facts.cradle ? cradle(facts) : onFloor(facts);
  const broken = collapsed(facts);
  return broken ? `${said} ${broken}` : said;
}

function tooDeep({ tooDeep: pair, last }: Run): string {
  const bodies = pair === 0 ? "the floor and the lowest ball" : `ball ${spell(pair)} and ball ${spell(pair + 1)}`;
  return `After ${duration(last)} ${bodies} are compressed by half of the smaller radius. No contact law describes that: the contacts need to be stiffer.`;
}

function collapsed({ icm, balls }: Facts): string {
  if (icm.outcome === outcomes.collapse)
    return "The collision model breaks down: its collisions follow each other ever faster, infinitely many in a finite time, as the balls come to rest on each other.";
  if (icm.outcome === outcomes.unresolved)
    return `The collision model breaks down: the collisions of its ${spell(balls)} balls become too many to count.`;
  return "";
}

function onFloor(f: Facts): string {
  const list = spans(f.newton.contacts, f.newton.last);
  const between = list.filter((c) => c.pair > 0);
  if (f.newton.outcome === outcomes.unresolved) return "Newton’s equations have more contacts here than can be followed.";
  if (between.length === 0 || f.newton.nContacts === 0) return neverMeet(f);
  const floor = list.find((c) => c.pair === 0);
  if (!floor || floor.end === Infinity) return "The floor never lets go: the lowest ball comes to rest on it, and the others land on a ball at rest.";
  return f.balls === 2 ? twoBalls(f, floor, between) : manyBalls(floor, list, between);
}

function neverMeet(f: Facts): string {
  const floor = f.newton.tFloorEnd;
  const pushes = Number.isFinite(floor) ? `The floor pushes for ${duration(floor)}, and the` : "The";
  return `${pushes} balls do not meet before the lowest one is back on the floor${f.icm.nContacts > 0 ? "; in the collision model they do" : ", in neither model"}.`;
}

function twoBalls(f: Facts, floor: Span, between: Span[]): string {
  const n = between.length;
  const first = between[0];
  const pushes = `The floor pushes for ${duration(floor.end)}`;
  const instant = f.icm.contacts.find((c) => c.pair === 1)?.begin ?? NaN;
  if (first.begin >= floor.end) {
    const after = `${pushes} and has let go when the balls meet after ${duration(first.begin)}`;
    return n === 1 ? `${after}: one collision after the other, as the collision model has it.` : `${after}; even so they touch ${times(n)}, the collision model says ${icmTimes(f)}.`;
  }
  const touches =
    n > 1 ? `By Newton’s equations they touch ${times(n)}, between ${duration(first.begin)} and ${duration(between[n - 1].end)}.`
    : first.end === Infinity ? "By Newton’s equations the balls stay together."
    : `By Newton’s equations they touch once, for ${duration(first.end - first.begin)}, ${first.end > floor.end ? "until after the floor has let go" : "all of it while the floor pushes"}.`;
  const meets =
    !(instant >= 0) ? "in the collision model the balls do not meet at all"
    : instant === 0 ? "the collision model lets the balls meet at the very instant of the floor touch, the floor first"
    : `the collision model lets the balls meet after ${duration(instant)}, ${instant < floor.end ? "while the floor is still pushing" : "when it has let go"}`;
  return `${pushes}; ${meets}. ${touches}`;
}

const icmTimes = (f: Facts): string => (f.icm.nContacts === 0 ? "not at all" : times(f.icm.nContacts));

function manyBalls(floor: Span, list: Span[], between: Span[]): string {
  const first = Math.min(...between.map((c) => c.begin));
  const most = mostAtOnce(list);
  const pushes = `The floor pushes for ${duration(floor.end)}`;
  const one = "the collision model takes them one after another";
  if (most >= 2) {
    const meet = first < floor.end ? `the first two balls meet after ${duration(first)}, while it still does` : `has let go when the first two balls meet after ${duration(first)}`;
    return `${pushes}${first < floor.end ? "; " : " and "}${meet}. Up to ${spell(most)} contacts press at the same time; ${one}.`;
  }
  return `${pushes} and has let go when the first two balls meet after ${duration(first)}; no two contacts overlap, as the collision model has it.`;
}

function cradle(f: Facts): string {
  const list = spans(f.newton.contacts, f.newton.last);
  if (list.length === 0) return "No two balls meet.";
  const most = mostAtOnce(list);
  const long = Math.max(...list.map((c) => c.end - c.begin));
  const lasts = Number.isFinite(long) ? `, ${list.length === 1 ? "for" : "for up to"} ${duration(long)}` : "";
  if (list.length === 1) return `Two balls touch once${lasts}, and no other pair does: a single collision, as the collision model has it.`;
  if (most < 2) return `The balls touch ${times(list.length)}${lasts}, never two pairs at a time: one collision after the other, as the collision model has it.`;
  return `The balls touch ${times(list.length)}${lasts}, up to ${spell(most)} pairs at the same time; the collision model passes the impulse on one pair at a time.`;
}
