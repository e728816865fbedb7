// Axes of maps and curves: one parameter of the setting each, its range, and the setting moved to another value.
import { digits, withUnit } from "../support/format";
import {
  clampTo,
  constants,
  constantsOf,
  copyOf,
  densityFor,
  firstGap,
  lowestHeight,
  massOf,
  ranges,
  type Scenario,
} from "./scenario";

export const mapAxes = ["gap", "ratio", "e", "k", "mass", "h"] as const;
export type MapAxis = (typeof mapAxes)[number];
export type Limits = [low: number, high: number];

export interface Axis {
  title: (s: Scenario) => string; // at the axis and in the list of choices
  noun: string; // in "every …"
  symbol: (s: Scenario) => string;
  unit: (s: Scenario) => string;
  log: boolean;
  limits: (s: Scenario) => Limits; // how far the map can be zoomed out
  onFloorOnly?: boolean; // a cradle has no such axis
  get: (s: Scenario) => number;
  put: (s: Scenario, x: number) => void; // x as it is
  rounded: (s: Scenario, x: number) => number; // as a click chooses it
}

// The stiffness of the present law: k, Young's modulus, or the Hertz stiffness.
export const stiffnessOf = (s: Scenario): string => constantsOf(s)[0];
const figures = (x: number, n: number): number => Number(x.toPrecision(n));
const plain = (): string => "";
const uncapital = (text: string): string =>
  /^(Young|Hertz)/.test(text) ? text : text[0].toLowerCase() + text.slice(1);

export const axes: Record<MapAxis, Axis> = {
  e: {
    title: () => "ε",
    noun: "ε",
    symbol: () => "ε",
    unit: plain,
    log: false,
    limits: () => [ranges.restitution.low, 1],
    get: (s) => s.restitution,
    put: (s, x) => (s.restitution = x),
    rounded: (_, x) => clampTo(ranges.restitution, figures(x, 4)),
  },
  gap: {
    title: () => "gap Δh",
    noun: "gap",
    symbol: () => "Δh",
    unit: () => "m",
    log: true,
    limits: () => [1e-9, 10],
    get: (s) => s.gaps[firstGap(s)],
    put: (s, x) => (s.gaps = s.gaps.map((gap, i) => (i < firstGap(s) ? gap : x))),
    rounded: (_, x) => clampTo(ranges.gap, figures(x, 4)),
  },
  ratio: {
    title: () => "R₁/R₂",
    noun: "size of the lower ball",
    symbol: () => "R₁/R₂",
    unit: plain,
    log: true,
    limits: () => [0.02, 500],
    onFloorOnly: true,
    get: (s) => s.balls[0].radius / s.balls[1].radius,
    put: (s, x) => (s.balls[0].radius = x * s.balls[1].radius),
    rounded: ({ balls: [, b] }, x) => clampTo(ranges.radius, figures(x * b.radius, 6)) / b.radius,
  },
  k: {
    title: (s) => uncapital(constants[stiffnessOf(s)].label),
    noun: "stiffness",
    symbol: (s) => constants[stiffnessOf(s)].symbol,
    unit: (s) => constants[stiffnessOf(s)].range.unit,
    log: true,
    limits: (s) => [constants[stiffnessOf(s)].range.low, constants[stiffnessOf(s)].range.high],
    get: (s) => s.constants[stiffnessOf(s)],
    put: putStiffness,
    rounded: (s, x) => clampTo(constants[stiffnessOf(s)].range, figures(x, 4)),
  },
  mass: {
    title: () => "m₁/m₂",
    noun: "mass of the lower ball",
    symbol: () => "m₁/m₂",
    unit: plain,
    log: true,
    limits: () => [1e-4, 1e4],
    get: ({ balls: [a, b] }) => massOf(a) / massOf(b),
    put: ({ balls: [a, b] }, x) => (a.density = densityFor(x * massOf(b), a.radius)),
    rounded: ({ balls: [, b] }, x) => clampTo(ranges.mass, figures(x * massOf(b), 6)) / massOf(b),
  },
  h: {
    title: () => "height h",
    noun: "height",
    symbol: () => "h",
    unit: () => "m",
    log: true,
    limits: (s) => [Math.max(lowestHeight(s), ranges.height.low), ranges.height.high],
    onFloorOnly: true,
    get: (s) => s.height,
    put: (s, x) => (s.height = x),
    rounded: (s, x) => Math.max(clampTo(ranges.height, figures(x, 4)), lowestHeight(s)),
  },
};

// Contacts with their own stiffness keep its ratio to that of the floor, within the range of the page.
function putStiffness(s: Scenario, x: number): void {
  const name = stiffnessOf(s);
  const factor = x / s.constants[name];
  s.constants[name] = x;
  s.own[name] &&= s.own[name].map((own) => clampTo(constants[name].range, figures(own * factor, 12)));
}

export const hasAxis = (s: Scenario, axis: MapAxis): boolean => !(s.cradle && axes[axis].onFloorOnly);

export const axisValue = (s: Scenario, axis: MapAxis, x: number): string => {
  const { symbol, unit } = axes[axis];
  return `${symbol(s)} = ${unit(s) === "" ? digits(x) : x > 0 ? withUnit(x, unit(s)) : "0"}`;
};

// The setting moved to a point of two axes; null where the lowest ball would not start above the floor.
export function placed(s: Scenario, place: [MapAxis, number][]): Scenario | null {
  const moved = copyOf(s);
  for (const [axis, x] of place) axes[axis].put(moved, x);
  return !s.cradle && moved.height - moved.balls[0].radius <= 0 ? null : moved;
}
