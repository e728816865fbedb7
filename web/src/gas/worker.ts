// The worker of the gas: advances both simulations on request.
import { GasCore, World } from "./core";
import type { Setting } from "./setting";
import { Simulation, type FrameOf, type Sample, type Start } from "./simulation";

export type Ask =
  | { kind: "start"; setting: Setting }
  | { kind: "advance"; steps: number; until: number } // one frame, or as many as needed to reach a time [s]
  | { kind: "log" };
export type Answer =
  | { kind: "start"; start: Start; frame: FrameOf; messages: string[] }
  | { kind: "advance"; samples: Sample[]; frame: FrameOf; late: boolean; ms: number } // late: the time is not reached
  | { kind: "log"; logs: [Float64Array, Float64Array]; states: [Float64Array, Float64Array] }
  | { kind: "error"; message: string };

const budget = 120; // longest time until an answer, so that the page can send another request [ms]
const outcomes = 8;

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

function answer(ask: Ask): Answer {
  if (ask.kind === "start") {
    core = new GasCore(module);
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

self.onmessage = (event: MessageEvent<WebAssembly.Module | { id: number; ask: Ask }>): void => {
  if (event.data instanceof WebAssembly.Module) {
    module = event.data;
    return;
  }
  const { id, ask } = event.data;
  let reply: Answer;
  try {
    reply = answer(ask);
  } catch (error) {
    reply = {
      kind: "error",
      message:
        error instanceof Error && !(error instanceof WebAssembly.RuntimeError)
          ? error.message
          : "The core has stopped; start again or change a value.",
    };
  }
  (self as unknown as Worker).postMessage({ id, answer: reply });
};
