// Distribution of the energy after the sequence, as fractions of the energy at release, whose sum is 1.
import type { Track } from "../core/drop";
import { massOf, type Scenario } from "../scenario/scenario";

export interface Shares {
  balls: number[]; // bottom first: kinetic and potential energy
  stored: number; // elastic energy of contacts that last
  lost: number; // dissipated
}

// Zero of the potential energy of a ball: its position without compression, or its final position if that is lower. A
// ball that rests on compressed contacts then has no negative energy.
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

// Shares in tenths of a per cent. The largest remainders are rounded up, so that the sum is 1000.
export function tenths(shares: number[]): number[] {
  const exact = shares.map((x) => 1000 * x);
  const rounded = exact.map(Math.floor);
  const order = exact.map((x, i) => [x - rounded[i], i]).sort((a, b) => b[0] - a[0] || a[1] - b[1]);
  const left = Math.round(exact.reduce((a, b) => a + b, 0)) - rounded.reduce((a, b) => a + b, 0);
  for (let k = 0; k < left; k++) rounded[order[k][1]]++;
  return rounded;
}
