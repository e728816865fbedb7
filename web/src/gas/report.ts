// The present contents of the page as data, for tests: window.hardlimit.report().
import type { Facts } from "./facts";
import { sentences, type Sentence } from "./sentences";
import type { Input, Observed } from "./core";
import { pythonOf } from "./python";
import type { Sample, Start } from "./simulation";
import type { OneStart } from "./starts";
import { toQuery, type Setting } from "./setting";

export interface Report {
  setting: Setting;
  link: string;
  input: Input;
  start: { positions: number[]; velocities: number[]; spins: number[] }; // spins: with friction
  law: Omit<Start, "setting" | "input" | "state" | "until">;
  playing: boolean;
  done: boolean;
  time: number;
  hard: Observed;
  newton: Observed;
  samples: readonly Sample[];
  starts: readonly OneStart[];
  until: number; // to which the starts are run [s]
  python: string;
  sentences: Sentence[];
}

export function reportOf(facts: Facts, playing: boolean): Report {
  const { hard, newton, samples, sample, done, starts } = facts;
  const { until, setting, input, state, ...law } = facts.start;
  const half = 2 * setting.number;
  return {
    setting,
    link: `?${toQuery(setting)}`,
    input,
    start: {
      positions: Array.from(state.subarray(0, half)),
      velocities: Array.from(state.subarray(half, 2 * half)),
      spins: Array.from(state.subarray(2 * half)),
    },
    law,
    playing,
    done,
    time: sample.time,
    hard,
    newton,
    samples,
    starts,
    until,
    python: pythonOf(facts),
    sentences: sentences(facts),
  };
}
