// The web worker: computes one task after another.
import { opening } from "./opening"; // first
import { Core, Model, type TimelineRow } from "./core";
import { solve, type Answered, type Solved, type Unsolved } from "./drop";
import { mapPoints, type MapTask } from "./map_points";
import { risesOf } from "./rises";
import { questionOf } from "../scenario/link";
import type { Scenario } from "../scenario/scenario";
import { trajectoryCsv } from "./trajectory_csv";

export interface Tasks {
  solve: { ask: { scenario: Scenario; tolerance: number }; answer: Solved | Unsolved };
  csv: { ask: { scenario: Scenario }; answer: string | null };
  // Points of a map; MAP_VALUES numbers each.
  points: { ask: MapTask; answer: Float64Array };
  // For each column the rebound height of its top ball under both models.
  curve: { ask: { columns: Float64Array[] }; answer: Float64Array };
  // For each ε the gap from which on both models agree.
  agreement: {
    ask: { column: Float64Array; restitution: number[]; low: number; high: number; tolerance: number };
    answer: Float64Array;
  };
  // Rows of the timeline; `adiabatic` also those of the lower ball unaffected by the upper one.
  timeline: {
    ask: { column: Float64Array; restitution: number[]; adiabatic: boolean };
    answer: { newton: TimelineRow[]; adiabatic: TimelineRow[] };
  };
}
export type Kind = keyof Tasks;

export interface Request<K extends Kind = Kind> {
  id: number;
  kind: K;
  ask: Tasks[K]["ask"];
}
export interface Reply {
  id: number;
  ms: number;
  answer?: unknown;
  error?: string;
  begun?: { what: string; share: number; known: Answered | null }; // progress: the next stage, and the results so far
}

let module: WebAssembly.Module;
let core: Core;
let loading: Promise<void> | null = null; // the first worker loads the core
const post = (reply: Reply, transfer: Transferable[] = []): void =>
  (self as unknown as Worker).postMessage(reply, transfer);

const perform: { [K in Kind]: (ask: Tasks[K]["ask"], id: number) => Tasks[K]["answer"] } = {
  solve: ({ scenario, tolerance }, id) =>
    solve(core, scenario, tolerance, (what, share, known) => post({ id, ms: 0, begun: { what, share, known } })),
  csv: ({ scenario }) => trajectoryCsv(core, scenario),
  points: (ask) => mapPoints(core, ask),
  curve: ({ columns }) => risesOf(core, columns),
  agreement({ column, restitution, low, high, tolerance }) {
    core.setColumn(column);
    return core.agreementGaps(restitution, low, high, tolerance);
  },
  timeline({ column, restitution, adiabatic }) {
    core.setColumn(column);
    return {
      newton: core.timeline(Model.newton, restitution),
      adiabatic: adiabatic ? core.timeline(Model.adiabatic, restitution) : [],
    };
  },
};

function transferable(answer: unknown): Transferable[] {
  if (answer instanceof Float64Array) return [answer.buffer];
  if (answer && typeof answer === "object" && "newton" in answer && "icm" in answer) {
    const { newton, icm, times, forces } = answer as Solved;
    return [
      times.buffer,
      ...forces.map((f) => f.buffer),
      ...[newton, icm].flatMap(({ samples }) => [samples.times.buffer, samples.rows.buffer]),
    ];
  }
  return [];
}

function start(compiled: WebAssembly.Module): void {
  module = compiled;
  core = new Core(module);
}

async function answer({ id, kind, ask }: Request): Promise<void> {
  let begin = NaN;
  try {
    await loading;
    begin = performance.now();
    const answer = (perform[kind] as (ask: unknown, id: number) => unknown)(ask, id);
    post({ id, ms: performance.now() - begin, answer }, transferable(answer));
  } catch (error) {
    if (module) core = new Core(module); // the state after a trap is undefined
    post({ id, ms: performance.now() - begin, error: String(error) });
  }
}

self.onmessage = ({ data }: MessageEvent<WebAssembly.Module | Request>): void => {
  if (data instanceof WebAssembly.Module) start(data);
  else void answer(data);
};

// The setting of the link is the first request to the worker that opens the page.
if (opening) {
  loading = opening.then(start);
  void answer({ id: 1, kind: "solve", ask: questionOf(new URL(self.name).searchParams) });
}
