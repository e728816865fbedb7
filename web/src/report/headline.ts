// The two sentences on top of the page: what happens by Newton's equations, and by independent collisions.
import type { Answered, Track } from "../core/drop";
import { capital, independent } from "../scenario/tables";
import { digits, lengths, withUnit } from "../support/format";
import type { Case, Numbers } from "./sentence";
import { inPercent } from "../scenario/tolerance";
import { bodiesOf, counted, duration, spell } from "./words";

// Compression over the smaller radius above which a contact law is questionable.
export const SHALLOW = 0.05;

export interface Facts {
  balls: number;
  cradle: boolean;
  newton: Track;
  icm: Track | null; // null: not computed yet
  tolerance: number;
}
interface Both extends Facts {
  icm: Track;
}

export const factsOf = (d: Answered, tolerance: number): Facts => ({
  balls: d.scenario.balls.length,
  cradle: d.scenario.cradle,
  newton: d.newton,
  icm: d.icm,
  tolerance,
});

const outcomes = { noContact: 1, atRest: 2, collapse: 4, unresolved: 5, tooDeep: 7 };
const ICM = capital(independent.label);

const top = (t: Track): number => t.peaks[t.peaks.length - 1];
const leaves = (t: Track): number => t.leaves[t.leaves.length - 1];
const heights = (f: Facts): [string, string] => lengths(top(f.newton), f.icm ? top(f.icm) : NaN);
const speed = (v: number): string => (Number.isFinite(v) ? withUnit(v, "m/s", 3, true) : "an unknown velocity");
const rises = (t: Track): boolean => Number.isFinite(top(t));

// The contacts of the sequence, and whether later ones count for the heights.
function contacts(t: Track): string {
  const n = t.run.nContacts;
  return t.run.meetsAgain && n > 0
    ? `${counted(n, "contact")} before the lowest ball is back on the floor, more after it`
    : counted(n, "contact");
}

const rise = (f: Facts): Numbers => ({ contacts: f.newton.run.nContacts, height: top(f.newton) });
export const newtonCases: Case<Facts>[] = [
  {
    id: "too-deep",
    when: (f) => f.newton.run.outcome === outcomes.tooDeep,
    say: ({ newton: { run } }) =>
      `No answer by Newton’s equations: after ${duration(run.last)} ${bodiesOf(run.tooDeep)} are compressed by half of the smaller radius, which no contact law describes.`,
    numbers: (f) => ({ time: f.newton.run.last, pair: f.newton.run.tooDeep }),
  },
  {
    id: "unresolved",
    when: (f) => f.newton.run.outcome === outcomes.unresolved,
    say: (f) =>
      `No answer by Newton’s equations: after two million steps and ${counted(f.newton.run.events, "contact")} there is no end in sight.`,
    numbers: (f) => ({ events: f.newton.run.events }),
  },
  { id: "cradle-no-contact", when: (f) => f.cradle && f.newton.run.nContacts === 0, say: () => "No two balls meet." },
  {
    id: "cradle",
    when: (f) => f.cradle,
    say: (f) =>
      `${capital(counted(f.newton.run.nContacts, "contact"))}; the last ball leaves with ${speed(leaves(f.newton))}.`,
    numbers: (f) => ({ contacts: f.newton.run.nContacts, velocity: leaves(f.newton) }),
  },
  {
    id: "at-rest",
    when: (f) => f.newton.run.outcome === outcomes.atRest && rises(f.newton),
    say: (f) =>
      `${capital(counted(f.newton.run.nContacts, "contact"))} between balls; one contact, of balls or with the floor, never ends because gravity holds it closed. After its first bounce the top ball reaches ${heights(f)[0]}.`,
    numbers: rise,
  },
  {
    id: "at-rest-flat",
    when: (f) => f.newton.run.outcome === outcomes.atRest,
    say: () => "A contact never ends because gravity holds it closed; the top ball does not bounce.",
  },
  {
    id: "no-contact-rises",
    when: (f) => f.newton.run.nContacts === 0 && rises(f.newton),
    say: (f) =>
      `The balls do not meet before the lowest one is back on the floor; the top ball reaches ${heights(f)[0]} after a later bounce.`,
    numbers: rise,
  },
  {
    id: "no-contact",
    when: (f) => f.newton.run.nContacts === 0,
    say: () => "The balls do not meet before the lowest one is back on the floor.",
  },
  {
    id: "no-bounce",
    when: (f) => !rises(f.newton),
    say: (f) => `${capital(contacts(f.newton))}; the top ball does not bounce before the floor is met again.`,
    numbers: (f) => ({ contacts: f.newton.run.nContacts }),
  },
  {
    id: "rises",
    when: () => true,
    say: (f) => `${capital(contacts(f.newton))}, and the top ball rises to ${heights(f)[0]}.`,
    numbers: rise,
  },
];

// Added to the sentence above.
export const warnings: Case<Facts>[] = [
  {
    id: "compressed",
    when: (f) => f.newton.run.largestCompression >= SHALLOW && f.newton.run.outcome !== outcomes.tooDeep,
    say: (f) =>
      `A contact is compressed by ${digits(100 * f.newton.run.largestCompression, 2)} % of the smaller radius; contact laws are meant for less than ${inPercent(SHALLOW)}.`,
    numbers: (f) => ({ compression: f.newton.run.largestCompression }),
  },
];

// How a height by independent collisions compares with Newton's.
export const comparisons: Case<{ ratio: number; tolerance: number }>[] = [
  { id: "alone", when: (f) => !(f.ratio > 0 && f.ratio < Infinity), say: () => "" },
  {
    id: "same",
    when: (f) => Math.abs(f.ratio - 1) <= f.tolerance,
    say: (f) => `, the same to ${inPercent(f.tolerance)}`,
  },
  { id: "times", when: (f) => f.ratio >= 1.995, say: (f) => `, ${digits(f.ratio, 2)} times as high` },
  { id: "higher", when: (f) => f.ratio > 1, say: (f) => `, ${digits(100 * (f.ratio - 1), 2)} % higher` },
  { id: "lower", when: () => true, say: (f) => `, ${digits(100 * (1 - f.ratio), 2)} % lower` },
];
export const ratioOf = (f: Facts): number => (f.icm ? top(f.icm) / top(f.newton) : NaN);
const compared = (f: Facts): string =>
  comparisons
    .find((c) => c.when({ ratio: ratioOf(f), tolerance: f.tolerance }))!
    .say({ ratio: ratioOf(f), tolerance: f.tolerance });
const icmRise = (f: Both): Numbers => ({ contacts: f.icm.run.nContacts, height: top(f.icm), ratio: ratioOf(f) });

export const icmCases: Case<Both>[] = [
  {
    id: "unresolved",
    when: (f) => f.icm.run.outcome === outcomes.unresolved,
    say: (f) => `${ICM}: ${f.icm.run.events} were followed, and there is no end in sight.`,
    numbers: (f) => ({ events: f.icm.run.events }),
  },
  {
    id: "cradle-no-contact",
    when: (f) => f.cradle && f.icm.run.nContacts === 0,
    say: () => `${ICM}: no two balls meet.`,
  },
  {
    id: "cradle-collapse",
    when: (f) => f.cradle && f.icm.run.outcome === outcomes.collapse,
    say: (f) =>
      `${ICM}: infinitely many in a finite time, an inelastic collapse; the last ball then has ${speed(leaves(f.icm))}.`,
    numbers: (f) => ({ velocity: leaves(f.icm) }),
  },
  {
    id: "cradle",
    when: (f) => f.cradle,
    say: (f) => `${ICM}: ${spell(f.icm.run.nContacts)}, and ${speed(leaves(f.icm))}.`,
    numbers: (f) => ({ contacts: f.icm.run.nContacts, velocity: leaves(f.icm) }),
  },
  {
    id: "collapse",
    when: (f) => f.icm.run.outcome === outcomes.collapse && rises(f.icm),
    say: (f) =>
      `${ICM}: infinitely many in a finite time, an inelastic collapse; the top ball has reached ${heights(f)[1]}${compared(f)}.`,
    numbers: (f) => ({ height: top(f.icm), ratio: ratioOf(f) }),
  },
  {
    id: "collapse-flat",
    when: (f) => f.icm.run.outcome === outcomes.collapse,
    say: () => `${ICM}: infinitely many in a finite time, an inelastic collapse.`,
  },
  {
    id: "at-rest",
    when: (f) => f.icm.run.outcome === outcomes.atRest && rises(f.icm),
    say: (f) =>
      `${ICM}: infinitely many in a finite time, and the balls come to rest; the top ball has reached ${heights(f)[1]}${compared(f)}.`,
    numbers: (f) => ({ height: top(f.icm), ratio: ratioOf(f) }),
  },
  {
    id: "at-rest-flat",
    when: (f) => f.icm.run.outcome === outcomes.atRest,
    say: () => `${ICM}: infinitely many in a finite time, and the balls come to rest.`,
  },
  {
    id: "no-contact-rises",
    when: (f) => f.icm.run.nContacts === 0 && rises(f.icm),
    say: (f) =>
      `${ICM}: none before the lowest ball is back on the floor; up to ${heights(f)[1]} after a later bounce${compared(f)}.`,
    numbers: icmRise,
  },
  { id: "no-contact", when: (f) => f.icm.run.nContacts === 0, say: () => `${ICM}: the top ball is not met.` },
  {
    id: "no-bounce",
    when: (f) => !rises(f.icm),
    say: (f) => `${ICM}: ${contacts(f.icm)}, and the top ball does not bounce.`,
    numbers: (f) => ({ contacts: f.icm.run.nContacts }),
  },
  {
    id: "rises-later",
    when: (f) => f.icm.run.meetsAgain,
    say: (f) => `${ICM}: ${contacts(f.icm)}; up to ${heights(f)[1]}${compared(f)}.`,
    numbers: icmRise,
  },
  {
    id: "rises",
    when: () => true,
    say: (f) => `${ICM}: ${spell(f.icm.run.nContacts)}, and up to ${heights(f)[1]}${compared(f)}.`,
    numbers: icmRise,
  },
];
