// The motion for the film, interpolated between states that a worker has sampled.
import { stateOf, type State } from "./core";

export interface Samples {
  times: Float64Array; // ascending [s]
  rows: Float64Array; // one of the core's for each time
  balls: number;
}

// Between two samples positions and gaps follow the cubic polynomial with the velocities at both, which is exact in
// flight. Events are sampled on both sides.
export class Motion {
  constructor(private readonly samples: Samples) {}

  // Clamped to the first and last sample.
  at(time: number): State {
    const { times, rows, balls: n } = this.samples;
    const size = rows.length / times.length;
    const k = this.before(time);
    const row = rows.slice(k * size, (k + 1) * size);
    const h = k + 1 < times.length ? times[k + 1] - times[k] : 0;
    const u = h > 0 ? (time - times[k]) / h : 0;
    if (!(u > 0)) return stateOf(row, n);
    const next = rows.subarray((k + 1) * size, (k + 2) * size);
    const [v0, v1] = [row.slice(n, 2 * n), next.subarray(n, 2 * n)];
    for (let i = 0; i < size; i++) row[i] += u * (next[i] - rows[k * size + i]);
    for (let i = 0; i < n; i++) {
      const below = i > 0 ? 1 : 0; // the floor and a cradle's frame do not move
      row[i] = cubic(rows[k * size + i], next[i], h * v0[i], h * v1[i], u);
      const [w0, w1] = [v0[i] - below * v0[i - below], v1[i] - below * v1[i - below]];
      row[2 * n + i] = cubic(rows[k * size + 2 * n + i], next[2 * n + i], h * w0, h * w1, u);
    }
    return stateOf(row, n);
  }

  // Index of the last sample not after `time`.
  private before(time: number): number {
    const { times } = this.samples;
    let [low, high] = [0, times.length];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= time) low = middle;
      else high = middle;
    }
    return low;
  }
}

// Values y0, y1 and slopes d0, d1 at u = 0 and 1.
function cubic(y0: number, y1: number, d0: number, d1: number, u: number): number {
  const v = 1 - u;
  return y0 + (y1 - y0) * u * u * (3 - 2 * u) + u * v * (v * d0 - u * d1);
}
