// Further starts of the same gas, one after another, in time slices: each gives the energies of both worlds at the same
// times. Runs in a worker of its own.
import type { GasCore } from "./core";
import { ranges, type Setting } from "./setting";
import { Simulation } from "./simulation";

export const INTERVALS = 60; // between the samples of a start

// One start, of both worlds, at INTERVALS + 1 times; NaN after the end of a world.
export interface OneStart {
  seed: number;
  energy: [number[], number[]];
  ratio: [number[], number[]];
  predicted: [number[], number[], number[]]; // Newton's energy by the law of the error, its lowest and highest value
  contacts: [number[], number[]]; // begun
  share: number; // of Newton's contacts that overlap in time, at the end
  ended: number; // Newton's contacts that have ended
  outcomes: [number, number];
}

// The seed of start k; that of k = 0 is shown as a film.
export const seedOf = ({ seed }: Setting, k: number): number => ((seed - 1 + k) % ranges.seed.high) + 1;

export class StartRun {
  private readonly simulation: Simulation;
  private at = 0;
  private readonly start: OneStart;

  constructor(core: GasCore, setting: Setting, k: number) {
    const seed = seedOf(setting, k);
    this.simulation = new Simulation(core, { ...setting, seed });
    const two = (): [number[], number[]] => [[], []];
    this.start = {
      seed,
      energy: two(),
      ratio: two(),
      predicted: [[], [], []],
      contacts: two(),
      share: NaN,
      ended: 0,
      outcomes: [0, 0],
    };
    this.take();
  }

  private take(): void {
    const { sample, observed } = this.simulation.sample();
    const { energy, ratio, predicted, contacts } = this.start;
    [0, 1].forEach((world) => {
      energy[world].push(sample.energy[world]);
      ratio[world].push(sample.ratio[world]);
      contacts[world].push(Number.isNaN(sample.energy[world]) ? NaN : observed[world].contacts);
      this.start.outcomes[world] = observed[world].outcome;
    });
    sample.predicted.forEach((x, i) => predicted[i].push(x));
    [this.start.share, this.start.ended] = [sample.share, observed[1].ended];
  }

  // Goes on for at most `budget` milliseconds. Returns the start if it is complete.
  advance(budget: number): OneStart | null {
    const begin = performance.now();
    const { until } = this.simulation.start;
    while (this.at < INTERVALS) {
      const left = budget - (performance.now() - begin);
      if (left <= 0 || !this.simulation.advanceTo(((this.at + 1) / INTERVALS) * until, left)) return null;
      this.at++;
      this.take();
    }
    return this.start;
  }
}
