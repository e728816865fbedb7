// The sentences of the gas: a table for each topic.
import { digits, minus, trim } from "../support/format";
import { always, chosen, type Numbers, type Row, type Sentence as Plain } from "../support/sentence";
import { divergenceOf } from "./divergence";
import { measureOf, type Facts } from "./facts";
import { TOLERANCE } from "./simulation";
import { INTERVALS } from "./starts";
import {
  at,
  differenceAt,
  failures,
  FEWEST,
  predictedAt,
  spread,
  student,
  surplusAt,
  type Estimate,
  type Measure,
  type Spread,
} from "./statistics";

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
// How the numbers of sentences are shown; the others are shares, in per cent.
const format: Record<string, (x: number) => string> = Object.fromEntries(
  (
    [
      ["until time", milliseconds],
      ["hard newton predicted", energy],
      ["starts failed overlapped collided touched contacts events", String],
      ["epsilon low high", (x) => trim(String(x))],
      ["theta other tcNu trusted limit phi rate near far", (x) => digits(x, 2)],
      ["collisions from to", (x) => x.toFixed(1)],
    ] as [string, (x: number) => string][]
  ).flatMap(([names, show]) => names.split(" ").map((name) => [name, show])),
);

// --- the starts ---

// The last sample that all starts have; 0: none.
const last = ({ starts }: Facts, measure: Measure): number => {
  for (let k = INTERVALS; k > 0; k--) if (differenceAt(starts, measure, k)) return k;
  return 0;
};
const measured = (f: Facts): Estimate | null => differenceAt(f.starts, measureOf(f), last(f, measureOf(f)));
const estimates = (f: Facts): Numbers => {
  const m = measured(f);
  return {
    starts: f.starts.length,
    until: f.start.until,
    tolerance: TOLERANCE,
    ...(m && { size: Math.abs(m.value), bar: m.error }),
  };
};
const words: Record<Measure, [verb: string, more: string, less: string]> = {
  cooling: ["cools", "too fast", "too slowly"],
  loss: ["loses energy", "too fast", "too slowly"],
  contacts: ["has", "too many contacts", "too few contacts"],
};
const ruleName = ({ start: { setting } }: Facts): string =>
  ({
    constant: "the event-driven world",
    tc: "the event-driven world with the rule TC",
    soft: "the event-driven world with the rule soft",
  })[setting.rule];
// "the event-driven world cools 5 % too fast (± 0.8 %, standard error of 16 starts until 12 ms)"
function comparison(f: Facts, { size, bar, starts, until }: Record<string, string>): string {
  const [verb, more, less] = words[measureOf(f)];
  const way = measured(f)!.value > 0 ? more : less;
  return `${ruleName(f)} ${verb} ${size} ${way} (±\u00a0${bar}, standard error of ${starts} starts until ${until})`;
}
const enough = (f: Facts): boolean => f.starts.length >= FEWEST && measured(f) !== null;
const differs = ({ value, half }: Estimate): boolean => Math.abs(value) - half > TOLERANCE;
const agrees = ({ value, half }: Estimate): boolean => Math.abs(value) + half <= TOLERANCE;
const elastic = (f: Facts): boolean => measureOf(f) === "contacts";
// Share of Newton's contacts that overlap in time, and the half-width of its 99 % interval.
const overlap = ({ starts }: Facts): Spread & { half: number } => {
  const of = spread(starts.map(({ share }) => (Number.isFinite(share) ? share : 0)));
  return { ...of, half: (student(starts.length - 1) * of.scatter) / Math.sqrt(starts.length) };
};
const overlaps = (f: Facts): Numbers => ({ ...estimates(f), share: overlap(f).mean });
const neither = ({ share }: Record<string, string>): string =>
  `at ε = 1 neither world cools; ${share} of Newton’s contacts overlap in time with another one`;
const tooFew = (f: Facts): string => {
  const n = f.starts.length;
  return n === 0
    ? "Cannot be said yet: the first start is running."
    : `Cannot be said yet, after ${n} ${n === 1 ? "start" : "starts"} of ${FEWEST}.`;
};
const noForces = ({ start: { setting } }: Facts): boolean => !setting.walls && setting.gravity === 0;

// --- the law of the error ---

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
const lawText = (what: string, f: Facts, { error, bar, tcNu, trusted, tolerance }: Record<string, string>): string =>
  `By the law of the error ${ruleName(f)} cools ${error} ${cools(f)} at the start (±\u00a0${bar}, t_c ν = ${tcNu}), ` +
  `${what} ${tolerance}; it is right to ${tolerance} up to t_c ν = ${trusted}.`;
// What the law gives for the measured difference: value and standard error.
const forecast = (f: Facts): { value: number; bar: number } | null => {
  const by = predictedAt(f.starts, last(f, "cooling"));
  if (!by || !f.start.known || !noForces(f) || elastic(f) || !enough(f)) return null;
  const [value, low, high] = by.cooling;
  return { value, bar: Math.abs(high - low) / 2 };
};
const contradicts = (f: Facts): boolean => {
  const [m, by] = [measured(f)!, forecast(f)!];
  return Math.abs(m.value - by.value) > Math.hypot(m.half, 2.6 * by.bar);
};
const forecasts = (f: Facts): Numbers => {
  const { value, bar } = forecast(f)!;
  return { until: f.start.until, size: Math.abs(value), bar };
};
const forecastText = (f: Facts, { until, size, bar }: Record<string, string>): string =>
  `Until ${until}, while the gas cools, it predicts ${size} ${forecast(f)!.value > 0 ? "too fast" : "too slowly"} ` +
  `(±\u00a0${bar})`;

// --- the film ---

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

const outsidePacking = ({ start: { setting, measured } }: Facts): boolean =>
  setting.phi < measured.thinnest || setting.phi > measured.densest;
const measuredWithFriction: Record<string, string> = {
  μ: "at μ up to 1",
  ρ: "at tangential stiffnesses from 0.33 to 1.17 of the normal one",
  ε: "at ε from 0.7 to 0.99",
};

const collapse = 4; // outcome

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
      "newton-stopped",
      (f) => f.newton.outcome !== 0 || failures(f.starts, 1) > 0,
      (_, { failed, starts }) =>
        `Cannot be said: Newton’s world could not go on ${Number(failed) > 0 ? `in ${failed} of ${starts} starts` : "in the film"}.`,
      (f) => ({ failed: failures(f.starts, 1), starts: f.starts.length }),
    ],
    [
      "unfinished",
      (f) => [f.hard.outcome, ...f.starts.map(({ outcomes }) => outcomes[0])].some((x) => x !== 0 && x !== collapse),
      () => "Cannot be said: an event-driven run could not go on, and not by a collapse.",
    ],
    [
      "stopped",
      (f) => f.hard.outcome !== 0 || failures(f.starts, 0) > 0,
      (_, { failed, starts }) =>
        `No: the event-driven run could not go on ${Number(failed) > 0 ? `in ${failed} of ${starts} starts` : "in the film"}.`,
      (f) => ({ failed: failures(f.starts, 0), starts: f.starts.length }),
    ],
    ["waiting", (f) => !enough(f), tooFew, ({ starts }) => ({ starts: starts.length })],
    [
      "elastic-differs",
      (f) => elastic(f) && (overlap(f).mean - overlap(f).half > TOLERANCE || differs(measured(f)!)),
      (f, n) => `No: ${neither(n)}, and ${comparison(f, n)}.`,
      overlaps,
    ],
    [
      "elastic-agrees",
      (f) => elastic(f) && overlap(f).mean + overlap(f).half <= TOLERANCE && agrees(measured(f)!),
      (f, n) => `Yes, to ${n.tolerance}: ${neither(n)}, and ${comparison(f, n)}.`,
      overlaps,
    ],
    [
      "elastic-open",
      elastic,
      (f, n) =>
        `Cannot be said yet, after ${n.starts} starts: ${neither(n)}, and ${comparison(f, n)}; ` +
        `${n.tolerance} is within the scatter.`,
      overlaps,
    ],
    ["differs", (f) => differs(measured(f)!), (f, n) => `No: ${comparison(f, n)}.`, estimates],
    [
      "rests",
      (f) => f.start.setting.gravity > 0,
      (f, n) =>
        "Cannot be said: disks come to rest under gravity, and collisions that take no time cannot bear weight. " +
        `So far ${comparison(f, n)}.`,
      estimates,
    ],
    ["agrees", (f) => agrees(measured(f)!), (f, n) => `Yes, to ${n.tolerance}: ${comparison(f, n)}.`, estimates],
    [
      "open",
      always,
      (f, n) =>
        `Cannot be said yet, after ${n.starts} starts: ${comparison(f, n)}, and ${n.tolerance} is within the scatter.`,
      estimates,
    ],
  ],
  law: [
    ["elastic", elastic, () => "The law of the error is about cooling and says nothing here."],
    ["elsewhere", (f) => !noForces(f), () => "The law of the error holds without walls and gravity."],
    [
      "rule",
      ({ start: { known, setting } }) => !known && setting.rule !== "constant",
      () => "With friction the law of the error is known for the rule constant ε only.",
    ],
    [
      "unknown",
      ({ start }) => !start.known,
      (_, { epsilon }) => `With friction the law of the error is not known at ε = ${epsilon}.`,
      ({ start }) => ({ epsilon: start.setting.restitution }),
    ],
    ["differs", beyond, (f, n) => lawText("more than", f, n), law],
    ["agrees", within, (f, n) => lawText("less than", f, n), law],
    ["open", always, (f, n) => lawText("and its error bar leaves open whether that is more than", f, n), law],
  ],
  range: [
    [
      "packing",
      (f) => f.start.known && !elastic(f) && outsidePacking(f),
      (_, { phi, low, high }) => `The law was measured at φ from ${low} to ${high}; at ${phi} it is a guess.`,
      ({ start: { setting, measured } }) => ({ phi: setting.phi, low: measured.thinnest, high: measured.densest }),
    ],
    [
      "restitution",
      ({ start: { setting, measured, known, outside } }) =>
        known && setting.restitution < measured.restitution && !outside.includes("ε"),
      (_, { phi, low }) => `The law was measured at ε from ${low} on; at ${phi} it is a guess.`,
      ({ start: { setting, measured } }) => ({ phi: setting.restitution, low: measured.restitution }),
    ],
    [
      "friction",
      ({ start: { outside } }) => outside.length > 0,
      ({ start: { outside } }) =>
        `With friction it was measured elsewhere: ${outside.map((name) => measuredWithFriction[name]).join(" and ")}.`,
    ],
  ],
  forecast: [
    [
      "contradicts",
      (f) => forecast(f) !== null && contradicts(f),
      (f, n) => `${forecastText(f, n)}, which contradicts the starts.`,
      forecasts,
    ],
    ["predicts", (f) => forecast(f) !== null, (f, n) => `${forecastText(f, n)}.`, forecasts],
  ],
  hard: [
    [
      "collapse",
      ({ hard }) => hard.outcome === collapse,
      (_, { time }) =>
        `In the film the event-driven world stopped at ${time}: an inelastic collapse, infinitely many collisions in a finite ` +
        `time. ` +
        "Newton’s equations go on.",
      ({ hard }) => ({ time: hard.time }),
    ],
    [
      "stopped",
      ({ hard }) => hard.outcome !== 0,
      ({ hard, messages }, { time }) =>
        `In the film the event-driven world stopped at ${time}: ${messages[hard.outcome]}.`,
      ({ hard }) => ({ time: hard.time }),
    ],
  ],
  newton: [
    [
      "stopped",
      ({ newton }) => newton.outcome !== 0,
      ({ newton, messages }, { time }) => `In the film Newton’s world stopped at ${time}: ${messages[newton.outcome]}.`,
      ({ newton }) => ({ time: newton.time }),
    ],
  ],
  measured: [
    [
      "predicted",
      (f) => f.start.setting.restitution < 1 && running(f) && Number.isFinite(f.sample.predicted[0]),
      (_, { collisions, hard, newton, predicted }) =>
        `Energy left in the film after ${collisions} collisions of each disk: event-driven ${hard}, Newton ${newton}; ` +
        `the law predicts ${predicted} for Newton.`,
      (f) => ({ ...energies(f), predicted: f.sample.predicted[0] }),
    ],
    [
      "energies",
      running,
      (_, { collisions, hard, newton }) =>
        `Energy left in the film after ${collisions} collisions of each disk: event-driven ${hard}, Newton ${newton}.`,
      energies,
    ],
  ],
  mean: [
    [
      "surplus",
      (f) => !elastic(f) && f.starts.length > 1 && last(f, measureOf(f)) === INTERVALS,
      (f, { until, starts, hard, newton, surplus, bar }) =>
        `Energy left at ${until}, mean of ${starts} starts: event-driven ${hard}, Newton ${newton}, ` +
        `which is ${surplus} ${surplusAt(f.starts, INTERVALS)!.value > 0 ? "more" : "less"} (±\u00a0${bar}).`,
      (f) => {
        const { value, error } = surplusAt(f.starts, INTERVALS)!;
        const [hard, newton] = [0, 1].map((world) => spread(at(f.starts, (s) => s.energy[world], INTERVALS)).mean);
        const { length } = f.starts;
        return { until: f.start.until, starts: length, hard, newton, surplus: Math.abs(value), bar: error };
      },
    ],
  ],
  spins: [
    [
      "ratio",
      (f) => f.start.setting.friction > 0 && f.starts.length > 1 && last(f, measureOf(f)) === INTERVALS,
      (_, { until, theta, other }) =>
        `The temperature of the rotation over that of the translation was 1 at the start; at ${until} it is ${theta} ` +
        `in the event-driven worlds and ${other} in Newton’s.`,
      (f) => {
        const [theta, other] = [0, 1].map((world) => spread(at(f.starts, (s) => s.ratio[world], INTERVALS)).mean);
        return { until: f.start.until, theta, other };
      },
    ],
  ],
  contacts: [
    [
      "overlapping",
      ({ newton }) => newton.ended > 0,
      (_, { share, overlapped, contacts }) =>
        `In the film ${share} of Newton’s contacts overlapped in time with another one (${overlapped} of ${contacts}).`,
      ({ newton: { overlapped, ended } }) => ({ share: overlapped / ended, overlapped, contacts: ended }),
    ],
    ["none", always, () => "No contact has ended in the film yet."],
  ],
  distance: [
    [
      "grows",
      ({ samples }) => divergenceOf(samples) !== null,
      (_, { rate, from, to, near, far }) =>
        `The distance of its worlds grows by ${rate} e-folds per collision of each disk ` +
        `(straight line from ${from} to ${to} collisions, ${near} to ${far} diameters).`,
      divergence,
    ],
    [
      "unknown",
      ({ sample }) => sample.time > 0,
      () => "How fast its worlds part cannot be said: their distance has no straight part on the logarithmic axis.",
    ],
  ],
  end: [
    ["rest", ({ atRest }) => atRest, () => "The disks of the film have come to rest in Newton’s world. It ends here."],
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
