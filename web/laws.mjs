import { readFileSync } from "node:fs";

// The laws as the core states them (bindings/wasm.cpp), in the order of its registry. Infinite bounds become null.
export function laws(wasm) {
  const core = new WebAssembly.Instance(new WebAssembly.Module(readFileSync(wasm)), {}).exports;
  const text = new Uint8Array(core.memory.buffer, core.law_records());
  const lines = new TextDecoder().decode(text.slice(0, text.indexOf(0))).trimEnd().split("\n");
  const bounds = core.scratch(2 * lines.length);
  core.law_ranges(bounds);
  const range = new Float64Array(core.memory.buffer, bounds, 2 * lines.length);
  const found = [];
  let at = 0;
  for (const [kind, name, ...rest] of lines.map((line) => line.split("\t"))) {
    if (kind === "law") found.push({ name, alternative: Number(rest[0]), parameters: [] });
    else found.at(-1).parameters.push({ name, unit: rest[0], meaning: rest[1], lowest: range[at++], highest: range[at++] });
  }
  return JSON.stringify(found); // writes an infinity as null
}
