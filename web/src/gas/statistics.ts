// Means over starts of a gas. As in Python's hardlimit.fidelity, differences between the worlds are ratios of means,
// with standard errors from the residuals of the starts and Student's 99 % interval.
import type { OneStart } from "./starts";

export const FEWEST = 8; // starts of a verdict

export interface Estimate {
  value: number;
  error: number; // standard error
  half: number; // half-width of the 99 % interval
  scatter: number; // standard deviation of one start
}

// One quantity at one time, over the starts.
export interface Spread {
  mean: number;
  scatter: number; // standard deviation
}

const mean = (x: readonly number[]): number => x.reduce((sum, y) => sum + y, 0) / x.length;
function deviation(x: readonly number[]): number {
  const m = mean(x);
  return Math.sqrt(x.reduce((sum, y) => sum + (y - m) ** 2, 0) / (x.length - 1));
}

// t with P(|T| > t) = 1 % (Abramowitz & Stegun 26.7.5; within 0.3 % from 7 degrees of freedom on).
const z = 2.5758293035489;
export function student(freedom: number): number {
  const [a, b, c] = [
    (z ** 3 + z) / 4,
    (5 * z ** 5 + 16 * z ** 3 + 3 * z) / 96,
    (3 * z ** 7 + 19 * z ** 5 + 17 * z ** 3 - 15 * z) / 384,
  ];
  return z + a / freedom + b / freedom ** 2 + c / freedom ** 3;
}

// (⟨values⟩ − ⟨reference⟩)/⟨reference⟩ (Cochran, Sampling Techniques, 6.3).
export function difference(values: readonly number[], reference: readonly number[]): Estimate {
  const scale = mean(reference);
  const ratio = mean(values) / scale;
  const scatter = deviation(values.map((x, i) => (x - ratio * reference[i]) / scale));
  const error = scatter / Math.sqrt(values.length);
  return { value: ratio - 1, error, half: student(values.length - 1) * error, scatter };
}

export const spread = (x: readonly number[]): Spread => ({ mean: mean(x), scatter: deviation(x) });

// √(E(0)/E) − 1, which grows in proportion to the time in a cooling gas.
export const cooling = (energy: number): number => 1 / Math.sqrt(energy) - 1;

// Values of all starts at sample k, of one world.
export const at = (starts: readonly OneStart[], of: (s: OneStart) => readonly number[], k: number): number[] =>
  starts.map((s) => of(s)[k]);

// What is compared: how fast the gas cools; under gravity the energy lost; without loss the number of contacts.
export type Measure = "cooling" | "loss" | "contacts";
export const valueOf = (measure: Measure, s: OneStart, world: 0 | 1, k: number): number =>
  measure === "contacts"
    ? s.contacts[world][k]
    : measure === "loss"
      ? 1 - s.energy[world][k]
      : cooling(s.energy[world][k]);

// Results are kept for as long as there is no further start: the plots ask for them in each frame.
const known = new WeakMap<readonly OneStart[], Map<string, unknown>>();
export function remembered<T>(starts: readonly OneStart[], key: string, compute: () => T): T {
  const of = known.get(starts) ?? new Map<string, unknown>();
  known.set(starts, of);
  if (!of.has(key)) of.set(key, compute());
  return of.get(key) as T;
}

// The difference of the worlds at sample k; null if a world has ended in some start, or nothing has happened.
export const differenceAt = (starts: readonly OneStart[], measure: Measure, k: number): Estimate | null =>
  remembered(starts, `${measure} ${k}`, () => newDifference(starts, measure, k));
function newDifference(starts: readonly OneStart[], measure: Measure, k: number): Estimate | null {
  const [hard, newton] = ([0, 1] as const).map((world) => starts.map((s) => valueOf(measure, s, world, k)));
  if (starts.length < 2 || !hard.every(Number.isFinite) || !newton.every(Number.isFinite)) return null;
  return mean(newton) > 0 ? difference(hard, newton) : null;
}

// How much more energy Newton's world has at sample k.
export const surplusAt = (starts: readonly OneStart[], k: number): Estimate | null =>
  remembered(starts, `surplus ${k}`, () => newSurplus(starts, k));
function newSurplus(starts: readonly OneStart[], k: number): Estimate | null {
  const [hard, newton] = ([0, 1] as const).map((world) => at(starts, (s) => s.energy[world], k));
  if (starts.length < 2 || !hard.every(Number.isFinite) || !newton.every(Number.isFinite)) return null;
  return difference(newton, hard);
}

// The same differences by the law of the error, and with its error bar: from the energies of the event-driven worlds.
export interface Predicted {
  cooling: [number, number, number];
  surplus: [number, number, number];
}
export const predictedAt = (starts: readonly OneStart[], k: number): Predicted | null =>
  remembered(starts, `predicted ${k}`, () => newPrediction(starts, k));
function newPrediction(starts: readonly OneStart[], k: number): Predicted | null {
  const hard = at(starts, (s) => s.energy[0], k);
  const all = [0, 1, 2].map((i) => at(starts, (s) => s.predicted[i], k));
  if (starts.length === 0 || !all.flat().every(Number.isFinite) || !hard.every(Number.isFinite)) return null;
  const [slow, energy] = [mean(hard.map(cooling)), mean(hard)];
  const of = (f: (newton: number[]) => number): [number, number, number] => [f(all[0]), f(all[1]), f(all[2])];
  return {
    cooling: of((newton) => slow / mean(newton.map(cooling)) - 1),
    surplus: of((newton) => mean(newton) / energy - 1),
  };
}

// Numbers of starts in which a world could not go on.
export const failures = (starts: readonly OneStart[], world: 0 | 1): number =>
  starts.filter((s) => s.outcomes[world] !== 0).length;
