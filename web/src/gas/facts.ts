// What is known of the two worlds at this moment.
import type { Observed } from "./core";
import type { Sample, Start } from "./simulation";

export interface Facts {
  start: Start;
  hard: Observed;
  newton: Observed;
  sample: Sample; // the last
  samples: readonly Sample[];
  messages: readonly string[]; // of the outcomes
  done: boolean;
}

// Newton's energy at the last time by the law of the error: the energies of the event-driven world at later times of
// Newton's (Sample.predicted). NaN without a prediction.
export function interpolated({ samples, sample }: Pick<Facts, "samples" | "sample">, bound = 0): number {
  const at = sample.time;
  const known = samples.filter(({ predicted }) => Number.isFinite(predicted[bound]));
  if (known.length < 2 || !Number.isFinite(sample.predicted[bound])) return NaN;
  let k = known.findIndex(({ predicted }) => predicted[bound] >= at);
  if (k === 0) return 1;
  if (k < 0) k = known.length - 1; // beyond the last: the straight line of √(E(0)/E) goes on
  const [a, b] = [known[k - 1], known[k]];
  const y = (s: Sample): number => 1 / Math.sqrt(s.energy[0]);
  const slope = (y(b) - y(a)) / (b.predicted[bound] - a.predicted[bound]);
  return (y(a) + slope * (at - a.predicted[bound])) ** -2;
}

// Fewer samples of a long run: every second one, except the last.
export const thinned = (samples: Sample[]): Sample[] => samples.filter((_, i) => i % 2 === 0 || i === samples.length - 1);
