// The present contents of the page as data, for tests: window.hardlimit.report().
import type { Facts } from "./facts";
import { sentences, type Sentence } from "./sentences";
import type { Input, Observed } from "./core";
import type { Sample, Start } from "./simulation";
import { toQuery, type Setting } from "./setting";

export interface Report {
  setting: Setting;
  link: string;
  input: Input;
  start: { positions: number[]; velocities: number[] };
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
  >;
  playing: boolean;
  done: boolean;
  time: number;
  hard: Observed;
  newton: Observed;
  samples: readonly Sample[];
  sentences: Sentence[];
}

export function reportOf(facts: Facts, playing: boolean): Report {
  const { start, hard, newton, samples, sample, done } = facts;
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
    setting,
    input,
    state,
  } = start;
  const half = state.length / 2;
  return {
    setting,
    link: `?${toQuery(setting)}`,
    input,
    start: { positions: Array.from(state.subarray(0, half)), velocities: Array.from(state.subarray(half)) },
    law: { law, error, errorBar, trusted, measured, collisionRate, contactDuration, temperature, compression, tooSoft },
    playing,
    done,
    time: sample.time,
    hard,
    newton,
    samples,
    sentences: sentences(facts),
  };
}
