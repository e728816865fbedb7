import { readFileSync } from "node:fs";

// What the core states of its laws, the parameters of a column and its models (bindings/wasm.cpp), in its order.
// Infinite bounds become null.
export function tables(wasm) {
  const core = new WebAssembly.Instance(new WebAssembly.Module(readFileSync(wasm)), {}).exports;
  const at = core.records(); // which may let the memory grow, and leave its former buffer detached
  const text = new Uint8Array(core.memory.buffer, at);
  const lines = new TextDecoder()
    .decode(text.slice(0, text.indexOf(0)))
    .trimEnd()
    .split("\n")
    .map((line) => line.split("\t"));
  const bounds = core.scratch(2 * lines.length);
  core.record_ranges(bounds);
  const range = Array.from(new Float64Array(core.memory.buffer, bounds, 2 * lines.length));
  const quantity = ([name, unit, meaning]) => ({ name, unit, meaning, lowest: range.shift(), highest: range.shift() });
  const value = { laws: [], swept: [], models: [] };
  for (const [kind, ...rest] of lines) {
    if (kind === "law") value.laws.push({ name: rest[0], alternative: Number(rest[1]), parameters: [] });
    if (kind === "parameter") value.laws.at(-1).parameters.push(quantity(rest));
    if (kind === "swept") value.swept.push(quantity(rest));
    if (kind === "model") value.models.push({ name: rest[0], label: rest[1], short: rest[2] });
  }
  return JSON.stringify(value); // writes an infinity as null
}
