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
  atRest: boolean;
}

// Fewer samples of a long run: every second one, except the last.
export const thinned = (samples: Sample[]): Sample[] =>
  samples.filter((_, i) => i % 2 === 0 || i === samples.length - 1);
