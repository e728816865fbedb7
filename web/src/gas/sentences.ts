// What the page says of a gas: one table of cases. In each topic the first case that holds is said.
import { digits, minus, trim } from "../support/format";
import { divergenceOf } from "./divergence";
import type { Facts } from "./facts";
import { TOLERANCE } from "./simulation";

export interface Sentence {
  topic: string;
  id: string; // of the case
  text: string;
  numbers: { [name: string]: number };
}
interface Case {
  topic: "verdict" | "range" | "hard" | "newton" | "measured" | "contacts" | "distance" | "end";
  id: string;
  when: (f: Facts) => boolean;
  numbers: (f: Facts) => { [name: string]: number };
  text: (n: { [name: string]: string }, f: Facts) => string;
}

export const percent = (x: number): string => {
  const size = Math.abs(100 * x);
  if (size > 0 && size < 0.005) return "less than 0.01\u00a0%";
  return `${minus(trim((100 * x).toFixed(size >= 9.95 ? 0 : size >= 0.095 || size === 0 ? 1 : 2)))}\u00a0%`;
};
export const milliseconds = (x: number): string =>
  `${trim((1e3 * x).toPrecision(3).includes("e") ? String(Math.round(1e3 * x)) : (1e3 * x).toPrecision(3))}\u00a0ms`;
const energy = (x: number): string => `${digits(100 * x, 3)}\u00a0%`;
const format: { [name: string]: (x: number) => string } = {
  tcNu: (x) => digits(x, 2),
  trusted: (x) => digits(x, 2),
  limit: (x) => digits(x, 2),
  time: milliseconds,
  overlapped: String,
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

const law = ({ start: { setting, error, errorBar, trusted } }: Facts): { [name: string]: number } => ({
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
const holds = ({ start: { setting } }: Facts): boolean => !setting.walls && setting.gravity === 0;

const cases: Case[] = [
  {
    topic: "verdict",
    id: "too-soft",
    when: ({ start }) => start.tooSoft > 0,
    numbers: ({ start }) => ({ compression: start.compression, limit: start.tooSoft }),
    text: ({ compression, limit }) =>
      `These disks are too soft: at the mean speed an impact compresses them by ${compression} of their radius, and contact laws hold below 50 %. Choose t_c ν below ${limit}.`,
  },
  {
    topic: "verdict",
    id: "stopped",
    when: (f) => holds(f) && f.hard.outcome !== 0,
    numbers: law,
    text: ({ error, bar }, f) =>
      `No: the event-driven run could not go on. Until then it cools ${error} ${cools(f)} (±\u00a0${bar}) by the law of the error.`,
  },
  {
    topic: "verdict",
    id: "elastic",
    when: ({ start }) => start.setting.restitution === 1,
    numbers: law,
    text: () => "Yes: at ε = 1 no collision loses energy, so that neither world cools.",
  },
  {
    topic: "verdict",
    id: "elsewhere",
    when: (f) => !holds(f),
    numbers: law,
    text: ({ error, bar }, f) =>
      `Cannot be said: the law of the error holds without walls and gravity. In such a gas, ${ruleName(f)} would cool ${error} ${cools(f)} (±\u00a0${bar}).`,
  },
  {
    topic: "verdict",
    id: "differs",
    when: beyond,
    numbers: law,
    text: ({ error, bar, trusted, tolerance }, f) =>
      `No: ${ruleName(f)} cools ${error} ${cools(f)} (±\u00a0${bar}) by the law of the error; it is right to ${tolerance} up to t_c ν = ${trusted}.`,
  },
  {
    topic: "verdict",
    id: "agrees",
    when: within,
    numbers: law,
    text: ({ error, bar, trusted, tolerance }, f) =>
      `Yes: ${ruleName(f)} cools ${error} ${cools(f)} (±\u00a0${bar}) by the law of the error; it is right to ${tolerance} up to t_c ν = ${trusted}.`,
  },
  {
    topic: "verdict",
    id: "open",
    when: () => true,
    numbers: law,
    text: ({ error, bar, tolerance }, f) =>
      `Cannot be said: ${ruleName(f)} cools ${error} ${cools(f)} (±\u00a0${bar}) by the law of the error, and ${tolerance} is within the error bar.`,
  },
  {
    topic: "range",
    id: "packing",
    when: ({ start: { setting, measured } }) =>
      setting.restitution < 1 && (setting.phi < measured.thinnest || setting.phi > measured.densest),
    numbers: ({ start: { setting, measured } }) => ({
      phi: setting.phi,
      low: measured.thinnest,
      high: measured.densest,
    }),
    text: ({ phi, low, high }) => `The law was measured at φ from ${low} to ${high}; at ${phi} it is a guess.`,
  },
  {
    topic: "range",
    id: "restitution",
    when: ({ start: { setting, measured } }) => setting.restitution < measured.restitution,
    numbers: ({ start: { setting, measured } }) => ({ phi: setting.restitution, low: measured.restitution }),
    text: ({ phi, low }) => `The law was measured at ε from ${low} on; at ${phi} it is a guess.`,
  },
  {
    topic: "hard",
    id: "collapse",
    when: ({ hard }) => hard.outcome === 4,
    numbers: ({ hard }) => ({ time: hard.time }),
    text: ({ time }) =>
      `The event-driven world stopped at ${time}: an inelastic collapse, infinitely many collisions in a finite time. Newton’s equations go on.`,
  },
  {
    topic: "hard",
    id: "stopped",
    when: ({ hard }) => hard.outcome !== 0,
    numbers: ({ hard }) => ({ time: hard.time }),
    text: ({ time }, { hard, messages }) => `The event-driven world stopped at ${time}: ${messages[hard.outcome]}.`,
  },
  {
    topic: "newton",
    id: "stopped",
    when: ({ newton }) => newton.outcome !== 0,
    numbers: ({ newton }) => ({ time: newton.time }),
    text: ({ time }, { newton, messages }) => `Newton’s world stopped at ${time}: ${messages[newton.outcome]}.`,
  },
  {
    topic: "measured",
    id: "predicted",
    when: (f) =>
      f.start.setting.restitution < 1 &&
      f.sample.time > 0 &&
      f.sample.energy.every(Number.isFinite) &&
      Number.isFinite(f.sample.predicted[0]),
    numbers: (f) => ({
      collisions: f.sample.collisions,
      hard: f.sample.energy[0],
      newton: f.sample.energy[1],
      predicted: f.sample.predicted[0],
    }),
    text: ({ collisions, hard, newton, predicted }) =>
      `Energy left after ${collisions} collisions of each disk: event-driven ${hard}, Newton ${newton}; the law predicts ${predicted} for Newton.`,
  },
  {
    topic: "measured",
    id: "energies",
    when: ({ sample }) => sample.energy.every(Number.isFinite) && sample.time > 0,
    numbers: ({ sample }) => ({ collisions: sample.collisions, hard: sample.energy[0], newton: sample.energy[1] }),
    text: ({ collisions, hard, newton }) =>
      `Energy left after ${collisions} collisions of each disk: event-driven ${hard}, Newton ${newton}.`,
  },
  {
    topic: "contacts",
    id: "overlapping",
    when: ({ newton }) => newton.ended > 0,
    numbers: ({ newton }) => ({
      share: newton.overlapped / newton.ended,
      overlapped: newton.overlapped,
      contacts: newton.ended,
    }),
    text: ({ share, overlapped, contacts }) =>
      `${share} of Newton’s contacts overlapped in time with another one (${overlapped} of ${contacts}).`,
  },
  {
    topic: "contacts",
    id: "none",
    when: () => true,
    numbers: () => ({}),
    text: () => "No contact has ended yet.",
  },
  {
    topic: "distance",
    id: "grows",
    when: ({ samples }) => divergenceOf(samples) !== null,
    numbers: ({ samples }) => {
      const { rate, from, to, low, high } = divergenceOf(samples)!;
      return { rate, from, to, near: low, far: high };
    },
    text: ({ rate, from, to, near, far }) =>
      `The distance of the worlds grows by ${rate} e-folds per collision of each disk (straight line from ${from} to ${to} collisions, ${near} to ${far} diameters).`,
  },
  {
    topic: "distance",
    id: "unknown",
    when: ({ sample }) => sample.time > 0,
    numbers: () => ({}),
    text: () => "How fast the worlds part cannot be said: their distance has no straight part on the logarithmic axis.",
  },
  {
    topic: "end",
    id: "rest",
    when: ({ atRest }) => atRest,
    numbers: () => ({}),
    text: () => "The disks have come to rest in Newton’s world. The film ends here.",
  },
  {
    topic: "end",
    id: "end",
    when: ({ done }) => done,
    numbers: () => ({}),
    text: () => "The film ends here; start again or change a value.",
  },
];

export function sentences(facts: Facts): Sentence[] {
  const said: Sentence[] = [];
  for (const { topic, id, when, numbers, text } of cases) {
    if (said.some((s) => s.topic === topic) || !when(facts)) continue;
    if (facts.start.tooSoft > 0 && topic !== "verdict") continue;
    const found = numbers(facts);
    const shown = Object.fromEntries(Object.entries(found).map(([name, x]) => [name, (format[name] ?? percent)(x)]));
    said.push({ topic, id, text: text(shown, facts), numbers: found });
  }
  return said;
}
