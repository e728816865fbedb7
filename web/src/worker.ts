// Points of the map, computed beside the page.
import { Core } from "./core";

export interface WorkerStart {
  kind: "start";
  module: WebAssembly.Module;
}
export interface WorkerColumn {
  kind: "column";
  job: number;
  column: Float64Array;
  axis: number;
}
export interface WorkerBatch {
  kind: "batch";
  job: number;
  batch: number;
  points: Float64Array; // (ε, y)
}
export interface WorkerResult {
  job: number;
  batch: number;
  values: Float64Array;
  ms: number;
}

let core: Core | null = null;
let job = -1;
let axis = 0;

self.onmessage = (event: MessageEvent<WorkerStart | WorkerColumn | WorkerBatch>): void => {
  const message = event.data;
  if (message.kind === "start") core = new Core(message.module);
  else if (message.kind === "column") {
    core?.setColumn(message.column);
    ({ job, axis } = message);
  } else if (core && message.job === job) {
    const begin = performance.now();
    const values = core.scan(axis, message.points);
    const result: WorkerResult = { job, batch: message.batch, values, ms: performance.now() - begin };
    (self as unknown as Worker).postMessage(result, [values.buffer]);
  }
};
