// Where the energy is when the sequence is over, as shares of the energy at release that sum to 1.
import type { Track } from "../core/drop";
import { massOf, type Scenario } from "../scenario/scenario";

export interface Shares {
  balls: number[]; // bottom first: kinetic and potential energy
  stored: number; // elastic energy of contacts that still press
  lost: number; // dissipated
}

// The potential energy of a ball is measured from the lower of its place at the end and that at which nothing is
// compressed: a ball that rests on compressed contacts then has no negative share.
export function sharesOf(t: Track, s: Scenario): Shares {
  const { final } = t;
  const below = final.energy.map((energy, i) => {
    const kinetic = 0.5 * massOf(s.balls[i]) * final.velocity[i] ** 2;
    return s.cradle ? 0 : Math.min(energy - kinetic, 0);
  });
  const balls = final.energy.map((energy, i) => Math.max(energy - below[i], 0));
  const [stored, lost] = [Math.max(final.stored, 0), Math.max(final.dissipated, 0)];
  const whole = balls.reduce((a, b) => a + b, stored + lost);
  return { balls: Array.from(balls, (x) => x / whole), stored: stored / whole, lost: lost / whole };
}

// Shares as tenths of a per cent that sum to 1000: the largest remainders are rounded up.
export function tenths(shares: number[]): number[] {
  const exact = shares.map((x) => 1000 * x);
  const found = exact.map(Math.floor);
  const order = exact.map((x, i) => [x - found[i], i]).sort((a, b) => b[0] - a[0] || a[1] - b[1]);
  const left = Math.round(exact.reduce((a, b) => a + b, 0)) - found.reduce((a, b) => a + b, 0);
  for (let k = 0; k < left; k++) found[order[k][1]]++;
  return found;
}
