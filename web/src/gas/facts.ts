// The present state of both simulations.
import type { Observed } from "./core";
import type { FrameOf, Sample, Start } from "./simulation";
import type { OneStart } from "./starts";
import type { Measure } from "./statistics";

export interface Facts {
  start: Start;
  hard: Observed;
  newton: Observed;
  sample: Sample; // the last
  samples: readonly Sample[];
  messages: readonly string[]; // of the outcomes
  done: boolean;
  atRest: boolean;
  starts: readonly OneStart[]; // so far
}

// What a frame says of the present.
type Present = Pick<Facts, "sample" | "done" | "atRest" | "hard" | "newton">;
export const present = ({ sample, done, atRest, worlds: [hard, newton] }: FrameOf): Present => ({
  sample,
  done,
  atRest,
  hard: hard.observed,
  newton: newton.observed,
});

export const measureOf = ({ start: { setting } }: Facts): Measure =>
  setting.restitution === 1 && setting.friction === 0 ? "contacts" : setting.gravity > 0 ? "loss" : "cooling";

// Keeps every second sample of a long run, and the last one.
export const thinned = (samples: Sample[]): Sample[] =>
  samples.filter((_, i) => i % 2 === 0 || i === samples.length - 1);
