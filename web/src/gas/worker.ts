// A worker of the gas: advances both simulations on request, or runs further starts.
import { GasCore, World } from "./core";
import type { Setting } from "./setting";
import { Simulation, type FrameOf, type Sample, type Start } from "./simulation";
import { StartRun, type OneStart } from "./starts";

export type Ask =
  | { kind: "start"; setting: Setting }
  | { kind: "advance"; steps: number; until: number } // one frame, or as many as needed to reach a time [s]
  | { kind: "log" }
  | { kind: "starts"; setting: Setting; from: number; to: number }; // an answer for each
export type Answer =
  | { kind: "start"; start: Start; frame: FrameOf; messages: string[] }
  | { kind: "advance"; samples: Sample[]; frame: FrameOf; late: boolean; ms: number } // late: the time is not reached
  | { kind: "log"; logs: [Float64Array, Float64Array]; states: [Float64Array, Float64Array] }
  | { kind: "starts"; start: OneStart }
  | { kind: "error"; message: string };
// A request with the module that it needs.
export interface Request {
  id: number;
  ask: Ask;
  module?: WebAssembly.Module;
}

const budget = 120; // longest time until an answer, so that the page can send another request [ms]
const outcomes = 8;
const slice = 8; // of a start, then a pause of the same length, so that the film stays smooth [ms]

let module: WebAssembly.Module;
let core: GasCore;
let simulation: Simulation;
let frame: FrameOf;

function joined(parts: Float64Array[]): Float64Array {
  const all = new Float64Array(parts.reduce((n, part) => n + part.length, 0));
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}

function advance(steps: number, until: number): Answer {
  const begin = performance.now();
  const samples: Sample[] = [];
  let late = false;
  do {
    if (!simulation.advance(steps, budget, until)) {
      late = true;
      break;
    }
    frame = simulation.frame();
    samples.push(frame.sample);
    late = simulation.now < until && !frame.done;
  } while (late && performance.now() - begin < budget);
  return { kind: "advance", samples, frame, late, ms: performance.now() - begin };
}

function answer(ask: Exclude<Ask, { kind: "starts" }>): Answer {
  if (ask.kind === "start") {
    core = new GasCore(module, ask.setting.friction > 0);
    simulation = new Simulation(core, ask.setting);
    frame = simulation.frame();
    return {
      kind: "start",
      start: simulation.start,
      frame,
      messages: Array.from({ length: outcomes }, (_, i) => core.outcome(i)),
    };
  }
  if (ask.kind === "advance") return advance(ask.steps, ask.until);
  const open = core.log(World.newton, true);
  return {
    kind: "log",
    logs: [joined(simulation.logs[0]), joined([...simulation.logs[1], open])],
    states: [core.state(World.hard), core.state(World.newton)],
  };
}

const post = (id: number, reply: Answer): void => (self as unknown as Worker).postMessage({ id, answer: reply });
const failed = (error: unknown): Answer => ({
  kind: "error",
  message:
    error instanceof Error && !(error instanceof WebAssembly.RuntimeError)
      ? error.message
      : "The core has stopped; start again or change a value.",
});

let timer = 0;
// Runs one start after another, in slices; a new request replaces this one.
function runStarts(id: number, { setting, from, to }: Extract<Ask, { kind: "starts" }>): void {
  clearTimeout(timer);
  core = new GasCore(module, setting.friction > 0);
  let k = from;
  let run: StartRun | null = null;
  const go = (): void => {
    try {
      run ??= new StartRun(core, setting, k);
      const start = run.advance(slice);
      if (start) {
        post(id, { kind: "starts", start });
        run = null;
        if (++k >= to) return;
      }
    } catch (error) {
      return post(id, failed(error));
    }
    timer = setTimeout(go, slice);
  };
  go();
}

self.onmessage = ({ data: { id, ask, module: needed } }: MessageEvent<Request>): void => {
  if (needed) module = needed;
  try {
    if (ask.kind === "starts") runStarts(id, ask);
    else post(id, answer(ask));
  } catch (error) {
    post(id, failed(error));
  }
};
