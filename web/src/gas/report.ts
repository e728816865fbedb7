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
  law: Pick<
    Start,
    | "law"
    | "error"
    | "errorBar"
    | "trusted"
    | "measured"
    | "collisionRate"
    | "contactDuration"
    | "temperature"
    | "compression"
    | "tooSoft"
    | "known"
    | "outside"
  >;
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
  const { start, hard, newton, samples, sample, done, starts } = facts;
  const {
    law,
    error,
    errorBar,
    trusted,
    measured,
    collisionRate,
    contactDuration,
    temperature,
    compression,
    tooSoft,
    known,
    outside,
    until,
    setting,
    input,
    state,
  } = start;
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
    law: {
      law,
      error,
      errorBar,
      trusted,
      measured,
      collisionRate,
      contactDuration,
      temperature,
      compression,
      tooSoft,
      known,
      outside,
    },
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
