// Divergence of both simulations: slope of the logarithm of their distance over the collisions per disk, where it is
// linear.
import type { Sample } from "./simulation";

export interface Divergence {
  rate: number; // e-folds of the distance per collision of each disk
  from: number; // collisions of each disk at the begin and at the end of the fit
  to: number;
  low: number; // distance there by the fit [diameters]
  high: number;
}

const saturated = 0.3; // distance of saturation [diameters]: disks then collide with different partners
const fewest = 10; // samples of a fit
const leastGrowth = 2; // e-folds of a straight part
const straight = 0.98; // least R² of a straight part
const parts = 8; // the fit may omit up to four eighths of the samples at the begin

interface Line {
  slope: number;
  level: number;
  r2: number;
}

function fit(points: readonly [number, number][]): Line {
  const n = points.length;
  const mean = (f: (p: readonly [number, number]) => number): number => points.reduce((sum, p) => sum + f(p), 0) / n;
  const [mx, my] = [mean(([x]) => x), mean(([, y]) => y)];
  const [xx, xy, yy] = [
    mean(([x]) => (x - mx) ** 2),
    mean(([x, y]) => (x - mx) * (y - my)),
    mean(([, y]) => (y - my) ** 2),
  ];
  return { slope: xy / xx, level: my - (xy / xx) * mx, r2: xy ** 2 / (xx * yy) };
}

// Fit to the longest linear part that ends where the distance saturates; null: there is none.
export function divergenceOf(samples: readonly Sample[]): Divergence | null {
  const end = samples.findIndex(({ distance }) => distance > saturated);
  const points = samples
    .slice(0, end < 0 ? undefined : end)
    .filter(({ distance }) => distance > 0)
    .map(({ collisions, distance }): [number, number] => [collisions, Math.log(distance)]);
  for (let part = 0; part <= parts / 2; part++) {
    const window = points.slice(Math.floor((part * points.length) / parts));
    if (window.length < fewest) return null;
    const { slope, level, r2 } = fit(window);
    const [from, to] = [window[0][0], window[window.length - 1][0]];
    if (r2 >= straight && slope * (to - from) >= leastGrowth)
      return { rate: slope, from, to, low: Math.exp(level + slope * from), high: Math.exp(level + slope * to) };
  }
  return null;
}
