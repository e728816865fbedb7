// Why the two models differ or agree: one or two sentences from the contacts of this setting.
import type { Contact, Run } from "../core/core";
import type { Case, Numbers } from "./sentence";
import { allOf, chosen, type Sentence } from "./sentence";
import { duration, spell, times } from "./words";

export interface WhyFacts {
  balls: number;
  cradle: boolean;
  newton: Run;
  icm: Run | null; // null: not computed yet
}

const outcomes = { collapse: 4, unresolved: 5 };

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

// What the sentences are made of.
interface Facts extends WhyFacts {
  list: Span[]; // contacts of the sequence by Newton's equations
  between: Span[]; // those between balls
  floor: Span | undefined; // first contact with the floor
  first: number; // begin of the first contact between balls
  most: number; // largest number of contacts at the same time
  longest: number; // duration of the longest contact
  instant: number; // when the collision model lets the first two balls meet; NaN: never
}

function factsFrom(f: WhyFacts): Facts {
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

const pushes = (f: Facts): string => `The floor pushes for ${duration(f.floor!.end)}`;
const lasts = (f: Facts): string =>
  Number.isFinite(f.longest) ? `, ${f.list.length === 1 ? "for" : "for up to"} ${duration(f.longest)}` : "";
const floorEnd = (f: Facts): Numbers => ({ floorEnd: f.floor!.end });
const firstAndFloor = (f: Facts): Numbers => ({ floorEnd: f.floor!.end, first: f.first });
const contactsAndFirst = (f: Facts): Numbers => ({ ...firstAndFloor(f), contacts: f.between.length });

// The first row that holds.
const cradle: Case<Facts>[] = [
  { id: "cradle-none", when: (f) => f.list.length === 0, say: () => "No two balls meet." },
  {
    id: "cradle-once",
    when: (f) => f.list.length === 1,
    say: (f) =>
      `Two balls touch once${lasts(f)}, and no other pair does: a single collision, as the collision model has it.`,
    numbers: (f) => ({ longest: f.longest }),
  },
  {
    id: "cradle-in-turn",
    when: (f) => f.most < 2,
    say: (f) =>
      `The balls touch ${times(f.list.length)}${lasts(f)}, never two pairs at a time: one collision after the other, as the collision model has it.`,
    numbers: (f) => ({ contacts: f.list.length, longest: f.longest }),
  },
  {
    id: "cradle-together",
    when: () => true,
    say: (f) =>
      `The balls touch ${times(f.list.length)}${lasts(f)}, up to ${spell(f.most)} pairs at the same time; the collision model passes the impulse on one pair at a time.`,
    numbers: (f) => ({ contacts: f.list.length, longest: f.longest, most: f.most }),
  },
];

const special: Case<Facts>[] = [
  { id: "too-deep", when: (f) => f.newton.tooDeep >= 0, say: () => "The contacts need to be stiffer for an answer." },
  {
    id: "unresolved",
    when: (f) => f.newton.outcome === outcomes.unresolved,
    say: () => "Newton’s equations have more contacts here than can be followed.",
  },
];

const neverMeet = (f: Facts): boolean => f.between.length === 0 || f.newton.nContacts === 0;
const onFloor: Case<Facts>[] = [
  {
    id: "never-meet",
    when: neverMeet,
    say: (f) => {
      const begin = Number.isFinite(f.newton.tFloorEnd)
        ? `The floor pushes for ${duration(f.newton.tFloorEnd)}, and the`
        : "The";
      return `${begin} balls do not meet before the lowest one is back on the floor${f.icm === null ? "" : f.icm.nContacts > 0 ? "; in the collision model they do" : ", in neither model"}.`;
    },
    numbers: (f): Numbers => (Number.isFinite(f.newton.tFloorEnd) ? { floorEnd: f.newton.tFloorEnd } : {}),
  },
  {
    id: "floor-stays",
    when: (f) => !f.floor || f.floor.end === Infinity,
    say: () => "The floor never lets go: the lowest ball comes to rest on it, and the others land on a ball at rest.",
  },
  {
    id: "two-after-once",
    when: (f) => f.balls === 2 && f.first >= f.floor!.end && f.between.length === 1,
    say: (f) =>
      `${pushes(f)} and has let go when the balls meet after ${duration(f.first)}: one collision after the other, as the collision model has it.`,
    numbers: firstAndFloor,
  },
  {
    id: "two-after-often",
    when: (f) => f.balls === 2 && f.first >= f.floor!.end,
    say: (f) =>
      `${pushes(f)} and has let go when the balls meet after ${duration(f.first)}; even so they touch ${times(f.between.length)}${f.icm ? `, the collision model says ${times(f.icm.nContacts)}` : ""}.`,
    numbers: contactsAndFirst,
  },
  { id: "two-pending", when: (f) => f.balls === 2 && !f.icm, say: (f) => `${pushes(f)}.`, numbers: floorEnd },
  {
    id: "two-not-met",
    when: (f) => f.balls === 2 && !(f.instant >= 0),
    say: (f) => `${pushes(f)}; in the collision model the balls do not meet at all.`,
    numbers: floorEnd,
  },
  {
    id: "two-at-once",
    when: (f) => f.balls === 2 && f.instant === 0,
    say: (f) =>
      `${pushes(f)}; the collision model lets the balls meet at the very instant of the floor touch, the floor first.`,
    numbers: floorEnd,
  },
  {
    id: "two-meet",
    when: (f) => f.balls === 2,
    say: (f) =>
      `${pushes(f)}; the collision model lets the balls meet after ${duration(f.instant)}, ${f.instant < f.floor!.end ? "while the floor is still pushing" : "when it has let go"}.`,
    numbers: (f) => ({ floorEnd: f.floor!.end, instant: f.instant }),
  },
  {
    id: "many-together",
    when: (f) => f.most >= 2 && f.first < f.floor!.end,
    say: (f) =>
      `${pushes(f)}; the first two balls meet after ${duration(f.first)}, while it still does. Up to ${spell(f.most)} contacts press at the same time; the collision model takes them one after another.`,
    numbers: (f) => ({ ...firstAndFloor(f), most: f.most }),
  },
  {
    id: "many-together-later",
    when: (f) => f.most >= 2,
    say: (f) =>
      `${pushes(f)} and has let go when the first two balls meet after ${duration(f.first)}. Up to ${spell(f.most)} contacts press at the same time; the collision model takes them one after another.`,
    numbers: (f) => ({ ...firstAndFloor(f), most: f.most }),
  },
  {
    id: "many-in-turn",
    when: () => true,
    say: (f) =>
      `${pushes(f)} and has let go when the first two balls meet after ${duration(f.first)}; no two contacts overlap, as the collision model has it.`,
    numbers: firstAndFloor,
  },
];

// Two balls that meet while the floor pushes: how they touch.
const touches: Case<Facts>[] = [
  {
    id: "touch-often",
    when: (f) => f.between.length > 1,
    say: (f) =>
      `By Newton’s equations they touch ${times(f.between.length)}, between ${duration(f.first)} and ${duration(f.between[f.between.length - 1].end)}.`.replace(
        / and –\./,
        " and the time when they stay together.",
      ),
    numbers: (f) => ({ contacts: f.between.length, first: f.first, end: f.between[f.between.length - 1].end }),
  },
  {
    id: "touch-for-ever",
    when: (f) => f.between[0].end === Infinity,
    say: () => "By Newton’s equations the balls stay together.",
  },
  {
    id: "touch-beyond-floor",
    when: (f) => f.between[0].end > f.floor!.end,
    say: (f) =>
      `By Newton’s equations they touch once, for ${duration(f.between[0].end - f.first)}, until after the floor has let go.`,
    numbers: (f) => ({ lasts: f.between[0].end - f.first }),
  },
  {
    id: "touch-on-floor",
    when: () => true,
    say: (f) =>
      `By Newton’s equations they touch once, for ${duration(f.between[0].end - f.first)}, all of it while the floor pushes.`,
    numbers: (f) => ({ lasts: f.between[0].end - f.first }),
  },
];

// All rows that hold are added.
const breakdowns: Case<Facts>[] = [
  {
    id: "breaks-down",
    when: (f) => f.icm?.outcome === outcomes.collapse,
    say: () =>
      "The collision model breaks down: its collisions follow each other ever faster, infinitely many in a finite time, as the balls come to rest on each other.",
  },
  {
    id: "too-many",
    when: (f) => f.icm?.outcome === outcomes.unresolved,
    say: (f) =>
      `The collision model breaks down: the collisions of its ${spell(f.balls)} balls become too many to count.`,
  },
];

export function why(given: WhyFacts): Sentence[] {
  const f = factsFrom(given);
  const fails = chosen(special, f);
  if (fails) return [fails];
  const first = chosen(f.cradle ? cradle : onFloor, f)!;
  const how = first.id.startsWith("two-") && f.first < f.floor!.end ? [chosen(touches, f)!] : [];
  return [first, ...how, ...allOf(breakdowns, f)];
}
