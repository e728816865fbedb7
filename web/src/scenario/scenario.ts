// The scenario: parameters, ranges, their encoding in a link and in a TOML file. SI units.
import { choiceOf } from "../support/choice";
import { labelOf, laws, parameterOfColumn, symbolOf, unitOf, type Law, type Quantity } from "./tables";

export interface Ball {
  radius: number;
  density: number; // of a solid sphere of the same mass; it is kept when the radius changes
}

export interface Scenario {
  law: string;
  restitution: number;
  constants: Record<string, number>; // of the laws, by name of the parameter; those of other laws are kept
  // Constants of the ball–ball contacts, bottom first, if they differ from those of the floor in `constants`.
  own: Record<string, number[]>;
  cradle: boolean; // no floor, no gravity
  height: number; // of the lowest ball's centre
  balls: Ball[]; // bottom first
  gaps: number[]; // gaps[i] between balls i and i + 1
  velocities: number[]; // upwards at release
}

export const GRAVITY = 9.81;
export const MOST_BALLS = 6;

export interface Range {
  low: number;
  high: number;
  log: boolean;
  unit: string;
  step?: number; // of a linear slider
  zero?: boolean; // 0 is allowed below `low`
}

// Ranges of the sliders, within those of the core.
const rangeOf = (name: string, slider: Omit<Range, "unit">): Range => ({
  ...slider,
  unit: unitOf(parameterOfColumn(name)),
});

export const ranges = {
  restitution: { low: 0.02, high: 1, log: false, unit: "" },
  height: rangeOf("height", { low: 0.01, high: 10, log: true }),
  radius: rangeOf("radius", { low: 1e-3, high: 0.5, log: true }),
  mass: rangeOf("mass", { low: 1e-6, high: 1e3, log: true }),
  gap: rangeOf("gap", { low: 1e-8, high: 1, log: true, zero: true }),
  velocity: rangeOf("velocity", { low: -5, high: 5, log: false, step: 0.01 }),
  density: rangeOf("density", { low: 1e-6, high: 1e12, log: true }), // wide enough for every radius and mass
} satisfies Record<string, Range>;

// A constant of a law on the page: key in a link, label, symbol, slider and the value to start from.
export interface Constant {
  key: string;
  label: string;
  symbol: string;
  range: Range;
  start: number;
}

// Page settings of a parameter: key in a link, slider and initial value.
const known: Record<string, { key: string; slider: Omit<Range, "unit">; start: number }> = {
  stiffness: { key: "k", slider: { low: 1e3, high: 1e9, log: true }, start: 5e7 },
  youngs_modulus: { key: "Y", slider: { low: 1e5, high: 1e12, log: true }, start: 5e7 },
  poisson_ratio: { key: "nu", slider: { low: 0, high: 0.5, log: false }, start: 0.45 },
  impact_speed: { key: "v", slider: { low: 0.01, high: 100, log: true }, start: 3 },
  elastic_prefactor: { key: "K", slider: { low: 1e4, high: 1e12, log: true }, start: 1e9 },
};

// A parameter without page settings gets a slider from the law's record.
function constantOf(p: Quantity): Constant {
  const bounded = p.highest !== null;
  const high = p.highest ?? 1e12;
  const low = bounded ? (p.lowest ?? -1e12) : Math.max(p.lowest ?? 0, 1e-3);
  const { key, slider, start } = known[p.name] ?? {
    key: p.name,
    slider: { low, high, log: !bounded },
    start: bounded ? 0.5 * (low + high) : Math.sqrt(low * high),
  };
  return { key, label: labelOf(p), symbol: symbolOf(p) || key, range: { ...slider, unit: unitOf(p) }, start };
}

export { laws };
export const constants: Record<string, Constant> = Object.fromEntries(
  laws.flatMap((law) => law.parameters.filter((p) => p.name !== "restitution").map((p) => [p.name, constantOf(p)])),
);

export const lawOf = (s: Scenario): Law => laws.find((law) => law.name === s.law) ?? laws[0];
export const restitutionOf = (s: Scenario): Quantity => lawOf(s).parameters.find((p) => p.name === "restitution")!;
export const constantsOf = (s: Scenario): string[] =>
  lawOf(s)
    .parameters.map((p) => p.name)
    .filter((name) => name !== "restitution");

export const clampTo = (r: Range, x: number): number =>
  r.zero && x < r.low ? (x > 0.5 * r.low ? r.low : 0) : Math.min(Math.max(x, r.low), r.high);

// The nearest value in the range; a change is noted.
export function within(r: Range, name: string, x: number, notes: string[]): number {
  const kept = clampTo(r, x);
  if (kept !== x) notes.push(`${name} = ${x} is outside ${r.zero ? "0 and " : ""}${r.low} … ${r.high}: ${kept} used`);
  return kept;
}

// Parameter of the law of a contact; contact 0 is that with the floor.
export const constantAt = (s: Scenario, name: string, contact: number): number =>
  (contact > 0 && !s.cradle ? s.own[name]?.[contact - 1] : undefined) ?? s.constants[name];
// Whether some parameter of the present law differs between the contacts.
export const hasOwn = (s: Scenario): boolean => !s.cradle && constantsOf(s).some((name) => s.own[name] !== undefined);

// Adds parameters of each ball–ball contact, initially those of the floor, or removes them.
export function setOwn(s: Scenario, own: boolean): void {
  s.own = own ? Object.fromEntries(constantsOf(s).map((name) => [name, s.gaps.map(() => s.constants[name])])) : {};
}

// Same order of operations as ball_mass in the core, for the same bits; a long sequence of collisions is chaotic.
export const massOf = ({ radius, density }: Ball): number => (4 / 3) * Math.PI * (density * (radius * radius * radius));
export const densityFor = (mass: number, radius: number): number => mass / massOf({ radius, density: 1 });

export const paper = (): Scenario => ({
  law: "linear",
  restitution: 0.7,
  constants: Object.fromEntries(Object.entries(constants).map(([name, c]) => [name, c.start])),
  own: {},
  cradle: false,
  height: 0.6,
  balls: [
    { radius: 0.1, density: 840 },
    { radius: 0.01, density: 840 },
  ],
  gaps: [1e-4],
  velocities: [0, 0],
});

export const copyOf = (s: Scenario): Scenario => ({
  ...s,
  constants: { ...s.constants },
  own: Object.fromEntries(Object.entries(s.own).map(([name, values]) => [name, [...values]])),
  balls: s.balls.map((b) => ({ ...b })),
  gaps: [...s.gaps],
  velocities: [...s.velocities],
});

// The first gap of a cradle only delays the first collision, so maps vary the others.
export const firstGap = (s: Scenario): number => (s.cradle && s.gaps.length > 1 ? 1 : 0);

// Height of the top ball's centre at release [m].
export const releaseHeight = ({ height, balls, gaps }: Scenario): number =>
  balls.slice(1).reduce((z, b, i) => z + balls[i].radius + gaps[i] + b.radius, height);

// The lowest ball must start above the floor.
export const lowestHeight = (s: Scenario): number => s.balls[0].radius * 1.001 + 1e-4;

export function setBallCount(s: Scenario, n: number): void {
  while (s.balls.length > n) {
    s.balls.pop();
    s.gaps.pop();
    s.velocities.pop();
    for (const values of Object.values(s.own)) values.pop();
  }
  while (s.balls.length < n) {
    const top = s.balls[s.balls.length - 1];
    const radius = s.cradle ? top.radius : clampTo(ranges.radius, 0.6 * top.radius);
    s.balls.push({ radius, density: top.density });
    s.gaps.push(s.cradle ? 0 : s.gaps[s.gaps.length - 1]);
    s.velocities.push(0);
    for (const values of Object.values(s.own)) values.push(values[values.length - 1]);
  }
}

const MOST_PARAMETERS = 4;

// The core's column; layout in bindings/wasm.cpp.
export function columnOf(s: Scenario): Float64Array {
  const law = lawOf(s);
  const column = [laws.indexOf(law), law.alternative, s.balls.length, s.cradle ? 0 : 1, s.cradle ? 0 : GRAVITY];
  s.balls.forEach((b, i) => {
    const gap = i > 0 ? s.gaps[i - 1] : s.cradle ? 0 : s.height - b.radius;
    const parameters = law.parameters.map((p) => (p.name === "restitution" ? s.restitution : constantAt(s, p.name, i)));
    while (parameters.length < MOST_PARAMETERS) parameters.push(0);
    column.push(massOf(b), b.radius, gap, s.velocities[i], ...parameters);
  });
  return Float64Array.from(column);
}

// ---- a link ----------------------------------------------------------------------------------------------

const scalars: [string, "restitution" | "height"][] = [
  ["e", "restitution"],
  ["h", "height"],
];

export function toQuery(s: Scenario, q: URLSearchParams): void {
  const base = paper();
  if (s.law !== base.law) q.set("law", s.law);
  if (s.cradle) q.set("setup", "cradle");
  for (const [key, name] of scalars) if (s[name] !== base[name]) q.set(key, String(s[name]));
  for (const [name, c] of Object.entries(constants)) {
    const own = s.own[name] ?? [];
    if (s.constants[name] !== c.start || own.length > 0) q.set(c.key, [s.constants[name], ...own].join());
  }
  const lists: [string, number[], number[]][] = [
    ["r", s.balls.map((b) => b.radius), base.balls.map((b) => b.radius)],
    ["rho", s.balls.map((b) => b.density), base.balls.map((b) => b.density)],
    ["gap", s.gaps, base.gaps],
    ["u", s.velocities, s.velocities.map(() => 0)],
  ];
  for (const [key, now, before] of lists) if (now.join() !== before.join()) q.set(key, now.join());
}

// Overrides `s` with the valid parts of the link; invalid parts are reported in `notes`.
export function fromQuery(s: Scenario, q: URLSearchParams, notes: string[]): void {
  const number = (key: string, text: string, r: Range, fallback: number): number => {
    // A link turns a plus sign into a space.
    const x = text.trim() === "" ? NaN : Number(text.replace(/e (?=\d)/i, "e+"));
    if (!Number.isFinite(x)) {
      notes.push(`${key} = “${text.slice(0, 20)}” is not a number: ${fallback} used`);
      return fallback;
    }
    return within(r, key, x, notes);
  };
  s.law = choiceOf(
    q,
    notes,
    "law",
    laws.map((law) => law.name),
    s.law,
  );
  s.cradle = choiceOf(q, notes, "setup", ["drop", "cradle"], s.cradle ? "cradle" : "drop") === "cradle";
  for (const [key, name] of scalars) {
    const text = q.get(key);
    if (text !== null) s[name] = number(key, text, ranges[name], s[name]);
  }
  const radii = q.get("r")?.split(",");
  if (radii) {
    const n = Math.min(Math.max(radii.length, 2), MOST_BALLS);
    if (n !== radii.length) notes.push(`r: ${radii.length} balls are outside 2 … ${MOST_BALLS}: ${n} used`);
    setBallCount(s, n);
  }
  const list = (
    key: string,
    r: Range,
    count: number,
    set: (i: number, x: number) => void,
    get: (i: number) => number,
  ): void => {
    const texts = q.get(key)?.split(",");
    if (!texts) return;
    if (texts.length !== count && key !== "r") notes.push(`${key}: ${texts.length} values for ${count}`);
    for (let i = 0; i < Math.min(count, texts.length); i++) set(i, number(key, texts[i], r, get(i)));
  };
  const n = s.balls.length;
  for (const [name, c] of Object.entries(constants)) {
    const texts = q.get(c.key)?.split(",");
    if (!texts) continue;
    s.constants[name] = number(c.key, texts[0], c.range, s.constants[name]);
    delete s.own[name];
    if (texts.length > 1 && texts.length !== n) notes.push(`${c.key}: ${texts.length} values for ${n} contacts`);
    if (texts.length > 1)
      s.own[name] = s.gaps.map((_, i) =>
        number(c.key, texts[i + 1] ?? texts[texts.length - 1], c.range, s.constants[name]),
      );
  }
  list(
    "r",
    ranges.radius,
    n,
    (i, x) => (s.balls[i].radius = x),
    (i) => s.balls[i].radius,
  );
  list(
    "rho",
    ranges.density,
    n,
    (i, x) => (s.balls[i].density = x),
    (i) => s.balls[i].density,
  );
  list(
    "gap",
    ranges.gap,
    n - 1,
    (i, x) => (s.gaps[i] = x),
    (i) => s.gaps[i],
  );
  list(
    "u",
    ranges.velocity,
    n,
    (i, x) => (s.velocities[i] = x),
    (i) => s.velocities[i],
  );
  settle(s, notes);
}

// Conditions between the parameters.
export function settle(s: Scenario, notes: string[] = []): void {
  s.balls.forEach((b, i) => {
    const mass = clampTo(ranges.mass, massOf(b));
    if (Math.abs(mass / massOf(b) - 1) > 1e-9) {
      b.density = densityFor(mass, b.radius);
      notes.push(`the mass of ball ${i + 1} is outside ${ranges.mass.low} … ${ranges.mass.high} kg: ${mass} kg used`);
    }
  });
  if (s.cradle) {
    if (Object.keys(s.own).length > 0)
      notes.push("in a cradle all contacts have the same law: that of the first is used");
    s.own = {};
    const closing = s.velocities.some((v, i) => i > 0 && v < s.velocities[i - 1]);
    if (!closing) {
      s.velocities = s.velocities.map((_, i) => (i === 0 ? 1 : 0));
      notes.push("in a cradle one ball must approach the next: the first now moves at 1 m/s");
    }
  } else {
    if (s.velocities.some((v) => v !== 0))
      notes.push("a drop starts from rest on this page: the velocities are left out");
    s.velocities = s.velocities.map(() => 0);
    if (!(s.height >= lowestHeight(s))) {
      s.height = Number(lowestHeight(s).toPrecision(4)) + 1e-3;
      notes.push(`the lowest ball must start above the floor: its centre starts at ${s.height} m`);
    }
  }
}

// ---- a file for `hardlimit drop` -------------------------------------------------------------------------

export function toToml(s: Scenario): string {
  const lines = ["# hardlimit drop THIS_FILE.toml", `gravity = ${toml(s.cradle ? 0 : GRAVITY)}`];
  if (s.cradle) lines.push("cradle = true");
  else lines.push(`height = ${toml(s.height)}  # m, centre of the lowest ball`);
  lines.push(`gaps = [${s.gaps.map(toml).join(", ")}]  # m`);
  if (s.velocities.some((v) => v !== 0)) lines.push(`velocities = [${s.velocities.map(toml).join(", ")}]  # m/s`);
  for (const b of s.balls)
    lines.push("", "[[balls]]", `radius = ${toml(b.radius)}  # m`, `density = ${toml(b.density)}  # kg/m³`);
  const own = hasOwn(s);
  for (const contact of own ? s.balls.keys() : [0]) {
    lines.push(
      "",
      own ? `[[laws]]  # ${contact === 0 ? "floor and ball 1" : `balls ${contact} and ${contact + 1}`}` : "[law]",
      `name = "${s.law}"`,
    );
    for (const p of lawOf(s).parameters) {
      const value = p.name === "restitution" ? s.restitution : constantAt(s, p.name, contact);
      lines.push(`${p.name} = ${toml(value)}${p.unit === "1" ? "" : `  # ${p.unit}`}`);
    }
  }
  return lines.join("\n") + "\n";
}

// The same as comments of a CSV file.
export const settingLines = (s: Scenario): string[] =>
  toToml(s)
    .split("\n")
    .filter((line) => line !== "");

// A TOML float: JavaScript writes 50000000 and 1e-7, TOML wants a point or an exponent.
const toml = (x: number): string => (/[.e]/.test(String(x)) ? String(x).replace("e+", "e") : `${x}.0`);
