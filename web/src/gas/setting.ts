// The setting of a gas: ranges, examples, encoding in a link.
import { choiceOf } from "../support/choice";
export const RADIUS = 1e-3; // of the disks [m]
export const MASS = 1e-5; // [kg]
export const INERTIA = 0.5; // q of the moment of inertia q m R²
export const RMS_SPEED = 0.5; // at the start [m/s]

export const rules = ["constant", "tc", "soft"] as const;
export type Rule = (typeof rules)[number];

export interface Setting {
  number: number;
  phi: number; // packing fraction
  restitution: number;
  tcNu: number; // contact duration times Enskog's collision rate at the start
  rule: Rule;
  walls: boolean;
  gravity: number; // downwards [m/s²]
  seed: number;
  friction: number; // μ
  stiffnessRatio: number; // k_t/k_n
}

export interface Range {
  low: number;
  high: number;
  step: number; // in the value, or in its decimal logarithm
  log: boolean;
}
export const ranges: Record<Exclude<keyof Setting, "rule" | "walls">, Range> = {
  number: { low: 100, high: 1000, step: 50, log: false },
  phi: { low: 0.02, high: 0.7, step: 0.01, log: false },
  restitution: { low: 0.1, high: 1, step: 0.01, log: false },
  tcNu: { low: 1e-4, high: 0.3, step: 0.01998, log: true }, // 174 steps to 0.300
  gravity: { low: 0, high: 20, step: 0.5, log: false },
  seed: { low: 1, high: 1e6, step: 1, log: false },
  friction: { low: 0, high: 1, step: 0.01, log: false },
  stiffnessRatio: { low: 0.2, high: 1.2, step: 0.002, log: false },
};
export type Quantity = keyof typeof ranges;
const whole: Quantity[] = ["number", "seed"];

export interface Example {
  id: string;
  setting: Partial<Setting>;
}
export const usual: Setting = {
  number: 800,
  phi: 0.5,
  restitution: 0.85,
  tcNu: 0.1,
  rule: "constant",
  walls: false,
  gravity: 0,
  seed: 1,
  friction: 0,
  stiffnessRatio: 0.286, // 2/7, LAMMPS' default
};
// The buttons of gas.html say what they are about.
export const examples: Example[] = [
  { id: "thin", setting: { phi: 0.15, restitution: 0.9, tcNu: 0.003 } },
  { id: "dense", setting: { phi: 0.6, tcNu: 0.2, restitution: 0.8 } },
  { id: "collapse", setting: { number: 400, phi: 0.3, restitution: 0.2, tcNu: 0.01 } },
  {
    id: "settling",
    setting: { number: 200, phi: 0.25, restitution: 0.6, tcNu: 0.03, rule: "tc", walls: true, gravity: 9.8 },
  },
  { id: "rough", setting: { number: 500, phi: 0.4, restitution: 0.9, tcNu: 0.1, friction: 0.5 } },
];

const names: { [K in keyof Setting]: string } = {
  number: "n",
  phi: "phi",
  restitution: "e",
  tcNu: "tcnu",
  rule: "rule",
  walls: "walls",
  gravity: "g",
  seed: "seed",
  friction: "mu",
  stiffnessRatio: "kt",
};
export const labels: { [K in Quantity]: string } = {
  number: "disks",
  phi: "packing fraction φ",
  restitution: "restitution ε",
  tcNu: "t_c ν",
  gravity: "gravity",
  seed: "seed of the start",
  friction: "friction μ",
  stiffnessRatio: "k_t/k_n",
};

export const toQuery = (setting: Setting): URLSearchParams => {
  const q = new URLSearchParams();
  for (const key of Object.keys(names) as (keyof Setting)[])
    q.set(names[key], key === "walls" ? (setting.walls ? "1" : "0") : String(setting[key]));
  return q;
};

// The film of a link: its speed, and the time [s] at which it stands still; null: none.
export function filmFromQuery(q: URLSearchParams, notes: string[]): { speed: string; time: number | null } {
  const speed = choiceOf(q, notes, "speed", ["0.25", "1", "4"], "1");
  const text = q.get("t");
  if (text === null) return { speed, time: null };
  const time = text.trim() === "" ? NaN : Number(text);
  if (time >= 0 && time < Infinity) return { speed, time };
  notes.push(`t: “${text}” is no time in seconds; the film begins at the start.`);
  return { speed, time: null };
}

// The setting of a link. Adds a note for each value that was changed because it is out of range.
export function fromQuery(q: URLSearchParams, notes: string[]): Setting {
  const example = examples.find(({ id }) => id === q.get("example"));
  if (q.has("example") && !example) notes.push(`There is no example “${q.get("example")}”.`);
  const setting = { ...usual, ...example?.setting };
  for (const key of Object.keys(ranges) as Quantity[]) {
    const text = q.get(names[key]);
    if (text === null) continue;
    const number = Number(text);
    const { low, high } = ranges[key];
    const near = whole.includes(key) ? Math.round(number) : number;
    const value = Math.min(Math.max(near, low), high);
    if (text.trim() === "" || Number.isNaN(number))
      notes.push(`${labels[key]}: “${text}” is no number; it is ${setting[key]}.`);
    else {
      if (value !== number)
        notes.push(
          `${labels[key]}: ${text} is ${value === near ? "not whole" : `outside ${low} to ${high}`}; it is ${value}.`,
        );
      setting[key] = value;
    }
  }
  setting.rule = choiceOf(q, notes, names.rule, rules, setting.rule);
  setting.walls = choiceOf(q, notes, names.walls, ["0", "1"], setting.walls ? "1" : "0") === "1";
  if (setting.gravity > 0 && !setting.walls) {
    setting.walls = true;
    notes.push("Gravity needs a floor: the box has walls.");
  }
  return setting;
}
