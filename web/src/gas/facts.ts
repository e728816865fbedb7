// The present state of both simulations.
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
  atRest: boolean;
}

// Keeps every second sample of a long run, and the last one.
export const thinned = (samples: Sample[]): Sample[] =>
  samples.filter((_, i) => i % 2 === 0 || i === samples.length - 1);
