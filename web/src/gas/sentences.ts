// The sentences of the gas: a table for each topic.
import { digits, minus, trim } from "../support/format";
import { always, chosen, type Numbers, type Row, type Sentence as Plain } from "../support/sentence";
import { divergenceOf } from "./divergence";
import type { Facts } from "./facts";
import { TOLERANCE } from "./simulation";

export interface Sentence extends Plain {
  topic: string;
}

export const percent = (x: number): string => {
  const size = Math.abs(100 * x);
  if (size > 0 && size < 0.005) return "less than 0.01\u00a0%";
  return `${minus(trim((100 * x).toFixed(size >= 9.95 ? 0 : size >= 0.095 || size === 0 ? 1 : 2)))}\u00a0%`;
};
export const milliseconds = (x: number): string =>
  `${trim((1e3 * x).toPrecision(3).includes("e") ? String(Math.round(1e3 * x)) : (1e3 * x).toPrecision(3))}\u00a0ms`;
const energy = (x: number): string => `${digits(100 * x, 3)}\u00a0%`;
const format: Record<string, (x: number) => string> = {
  tcNu: (x) => digits(x, 2),
  trusted: (x) => digits(x, 2),
  limit: (x) => digits(x, 2),
  time: milliseconds,
  overlapped: String,
  collided: String,
  touched: String,
  contacts: String,
  events: String,
  phi: (x) => digits(x, 2),
  low: (x) => trim(String(x)),
  high: (x) => trim(String(x)),
  collisions: (x) => x.toFixed(1),
  rate: (x) => digits(x, 2),
  from: (x) => x.toFixed(1),
  to: (x) => x.toFixed(1),
  near: (x) => digits(x, 2),
  far: (x) => digits(x, 2),
  hard: energy,
  newton: energy,
  predicted: energy,
};

const law = ({ start: { setting, error, errorBar, trusted } }: Facts): Numbers => ({
  error: Math.abs(error),
  bar: errorBar,
  tcNu: setting.tcNu,
  trusted,
  tolerance: TOLERANCE,
});
const cools = ({ start: { error } }: Facts): string => (error > 0 ? "too fast" : "too slowly");
const beyond = ({ start: { error, errorBar } }: Facts): boolean => Math.abs(error) - errorBar > TOLERANCE;
const within = ({ start: { error, errorBar } }: Facts): boolean => Math.abs(error) + errorBar <= TOLERANCE;
const ruleName = ({ start: { setting } }: Facts): string =>
  ({ constant: "event-driven", tc: "event-driven with the rule TC", soft: "event-driven with the rule soft" })[
    setting.rule
  ];
const elastic = ({ start: { setting } }: Facts): boolean => setting.restitution === 1;
const elasticContacts = ({ hard, newton }: Facts): Numbers => ({
  share: newton.overlapped / newton.ended,
  collided: hard.contacts,
  touched: newton.contacts,
});
const neitherCools = ({ share, collided, touched }: Record<string, string>): string =>
  `at ε = 1 neither world cools; ${share} of Newton’s contacts overlapped in time with another one ` +
  `(${touched} contacts; ${collided} event-driven collisions)`;
const noForces = ({ start: { setting } }: Facts): boolean => !setting.walls && setting.gravity === 0;

// Error of the cooling by the law, with its error bar.
const byLaw = (f: Facts, { error, bar }: Record<string, string>): string => `${error} ${cools(f)} (±\u00a0${bar})`;
const lawAnswer = (answer: string, f: Facts, n: Record<string, string>): string =>
  `${answer}: ${ruleName(f)} cools ${byLaw(f, n)} by the law of the error; ` +
  `it is right to ${n.tolerance} up to t_c ν = ${n.trusted}.`;
const divergence = ({ samples }: Facts): Numbers => {
  const { rate, from, to, low, high } = divergenceOf(samples)!;
  return { rate, from, to, near: low, far: high };
};
const energies = ({ sample }: Facts): Numbers => ({
  collisions: sample.collisions,
  hard: sample.energy[0],
  newton: sample.energy[1],
});
const running = ({ sample }: Facts): boolean => sample.time > 0 && sample.energy.every(Number.isFinite);

const tables: Record<string, Row<Facts>[]> = {
  verdict: [
    [
      "too-soft",
      ({ start }) => start.tooSoft > 0,
      (_, { compression, limit }) =>
        `These disks are too soft: at the mean speed an impact compresses them by ${compression} of their radius, ` +
        `and contact laws hold below 50 %. Choose t_c ν below ${limit}.`,
      ({ start }) => ({ compression: start.compression, limit: start.tooSoft }),
    ],
    [
      "stopped",
      (f) => noForces(f) && f.hard.outcome !== 0,
      (f, n) => `No: the event-driven run could not go on. Until then it cools ${byLaw(f, n)} by the law of the error.`,
      law,
    ],
    ["newton-stopped", (f) => f.newton.outcome !== 0, () => "Cannot be said: Newton’s world could not go on."],
    [
      "elastic-begins",
      (f) => elastic(f) && f.newton.ended === 0,
      () => "Cannot be said yet: at ε = 1 neither world cools, and no contact has ended.",
    ],
    [
      "elastic-differs",
      (f) => elastic(f) && f.newton.overlapped > TOLERANCE * f.newton.ended,
      (_, n) => `No: ${neitherCools(n)}, and event-driven collisions come one after another.`,
      elasticContacts,
    ],
    ["elastic-agrees", elastic, (_, n) => `Yes, so far: ${neitherCools(n)}.`, elasticContacts],
    [
      "elsewhere",
      (f) => !noForces(f),
      (f, n) =>
        "Cannot be said: the law of the error holds without walls and gravity. " +
        `In such a gas, ${ruleName(f)} would cool ${byLaw(f, n)}.`,
      law,
    ],
    ["differs", beyond, (f, n) => lawAnswer("No", f, n), law],
    ["agrees", within, (f, n) => lawAnswer("Yes", f, n), law],
    [
      "open",
      always,
      (f, n) =>
        `Cannot be said: ${ruleName(f)} cools ${byLaw(f, n)} by the law of the error, ` +
        `and ${n.tolerance} is within the error bar.`,
      law,
    ],
  ],
  range: [
    [
      "packing",
      ({ start: { setting, measured } }) =>
        setting.restitution < 1 && (setting.phi < measured.thinnest || setting.phi > measured.densest),
      (_, { phi, low, high }) => `The law was measured at φ from ${low} to ${high}; at ${phi} it is a guess.`,
      ({ start: { setting, measured } }) => ({ phi: setting.phi, low: measured.thinnest, high: measured.densest }),
    ],
    [
      "restitution",
      ({ start: { setting, measured } }) => setting.restitution < measured.restitution,
      (_, { phi, low }) => `The law was measured at ε from ${low} on; at ${phi} it is a guess.`,
      ({ start: { setting, measured } }) => ({ phi: setting.restitution, low: measured.restitution }),
    ],
  ],
  hard: [
    [
      "collapse",
      ({ hard }) => hard.outcome === 4,
      (_, { time }) =>
        `The event-driven world stopped at ${time}: an inelastic collapse, infinitely many collisions in a finite ` +
        `time. ` +
        "Newton’s equations go on.",
      ({ hard }) => ({ time: hard.time }),
    ],
    [
      "stopped",
      ({ hard }) => hard.outcome !== 0,
      ({ hard, messages }, { time }) => `The event-driven world stopped at ${time}: ${messages[hard.outcome]}.`,
      ({ hard }) => ({ time: hard.time }),
    ],
  ],
  newton: [
    [
      "stopped",
      ({ newton }) => newton.outcome !== 0,
      ({ newton, messages }, { time }) => `Newton’s world stopped at ${time}: ${messages[newton.outcome]}.`,
      ({ newton }) => ({ time: newton.time }),
    ],
  ],
  measured: [
    [
      "predicted",
      (f) => f.start.setting.restitution < 1 && running(f) && Number.isFinite(f.sample.predicted[0]),
      (_, { collisions, hard, newton, predicted }) =>
        `Energy left after ${collisions} collisions of each disk: event-driven ${hard}, Newton ${newton}; ` +
        `the law predicts ${predicted} for Newton.`,
      (f) => ({ ...energies(f), predicted: f.sample.predicted[0] }),
    ],
    [
      "energies",
      running,
      (_, { collisions, hard, newton }) =>
        `Energy left after ${collisions} collisions of each disk: event-driven ${hard}, Newton ${newton}.`,
      energies,
    ],
  ],
  contacts: [
    [
      "overlapping",
      ({ newton }) => newton.ended > 0,
      (_, { share, overlapped, contacts }) =>
        `${share} of Newton’s contacts overlapped in time with another one (${overlapped} of ${contacts}).`,
      ({ newton: { overlapped, ended } }) => ({ share: overlapped / ended, overlapped, contacts: ended }),
    ],
    ["none", always, () => "No contact has ended yet."],
  ],
  distance: [
    [
      "grows",
      ({ samples }) => divergenceOf(samples) !== null,
      (_, { rate, from, to, near, far }) =>
        `The distance of the worlds grows by ${rate} e-folds per collision of each disk ` +
        `(straight line from ${from} to ${to} collisions, ${near} to ${far} diameters).`,
      divergence,
    ],
    [
      "unknown",
      ({ sample }) => sample.time > 0,
      () => "How fast the worlds part cannot be said: their distance has no straight part on the logarithmic axis.",
    ],
  ],
  end: [
    ["rest", ({ atRest }) => atRest, () => "The disks have come to rest in Newton’s world. The film ends here."],
    ["end", ({ done }) => done, () => "The film ends here; start again or change a value."],
  ],
};

// Disks that are too soft get the verdict only.
export const sentences = (facts: Facts): Sentence[] =>
  Object.entries(tables).flatMap(([topic, rows]) => {
    const sentence =
      facts.start.tooSoft > 0 && topic !== "verdict"
        ? null
        : chosen(rows, facts, (name, x) => (format[name] ?? percent)(x));
    return sentence ? [{ topic, ...sentence }] : [];
  });
