// The WebAssembly modules return the bits of the native core. Golden values: tests/data/golden_wasm.json.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

const root = new URL("../../", import.meta.url);
const wasm = process.env.EXPLORER_WASM ?? new URL("src/hardlimit/explorer/page/maps.wasm", root);
const golden = JSON.parse(readFileSync(new URL("tests/data/golden_wasm.json", root), "utf8"));
const load = (file) => new WebAssembly.Instance(new WebAssembly.Module(readFileSync(file)), {}).exports;
const core = load(wasm);
const view = (pointer, n, of = core) => new Float64Array(of.memory.buffer, pointer, n);

const cell = new DataView(new ArrayBuffer(8));
function decode(text) {
  if (text === "nan") return NaN;
  cell.setBigUint64(0, BigInt(`0x${text}`));
  return cell.getFloat64(0);
}
function encode(x) {
  if (Number.isNaN(x)) return "nan";
  cell.setFloat64(0, x);
  return cell.getBigUint64(0).toString(16).padStart(16, "0");
}
const bits = (pointer, n) => Array.from(view(pointer, n), encode);
const setColumn = (column) => view(core.column_buffer(), column.length).set(column.map(decode));

for (const { name, column, runs } of golden.cases) {
  test(name, () => {
    setColumn(column);
    for (const { model, until, run } of runs) {
      const exists = core.solve(model, decode(until));
      assert.equal(exists !== 0, run !== null);
      if (!run) continue;
      assert.deepEqual(bits(core.reply_buffer(), 12), run.reply);
      const contacts = core.scratch(run.contacts.length + 1);
      core.contacts_of(model, contacts);
      assert.deepEqual(bits(contacts, run.contacts.length), run.contacts);
      const n = run.times.length;
      const times = core.scratch(n + run.states.length);
      view(times, n).set(run.times.map(decode));
      core.sample(model, n, times, times + 8 * n);
      assert.deepEqual(bits(times + 8 * n, run.states.length), run.states);
    }
  });
}

function hash(values) {
  let a = 2166136261;
  let b = 0x9e3779b9;
  const words = new Uint32Array(2);
  const value = new Float64Array(words.buffer);
  for (const x of values) {
    value[0] = x;
    if (Number.isNaN(x)) [words[0], words[1]] = [0, 0x7ff80000];
    for (const word of words) {
      a = Math.imul(a ^ word, 16777619);
      b = Math.imul(b ^ word, 0x85ebca6b) ^ (b >>> 13);
    }
  }
  return [a, b].map((x) => (x >>> 0).toString(16).padStart(8, "0")).join("");
}

for (const { name, axis, side, column, hash: expected } of golden.maps) {
  test(`map of ${side * side} points: ${name}`, () => {
    setColumn(column);
    const n = side * side;
    const pointer = core.scratch(5 * n);
    const points = view(pointer, 2 * n);
    let k = 0;
    for (let i = 0; i < side; i++)
      for (let j = 0; j < side; j++) {
        points[k++] = 0.02 + 0.98 * ((i + 0.5) / side);
        points[k++] = axis === 0 ? 1e-8 * ((j + 1) * (j + 1)) : 0.5 + 0.05 * j;
      }
    core.scan_points(axis, n, pointer, pointer + 16 * n);
    assert.equal(hash(view(pointer + 16 * n, 3 * n)), expected);
  });
}

const gas = process.env.EXPLORER_GAS_WASM ?? new URL("src/hardlimit/explorer/page/gas.wasm", root);
for (const { name, number, until, setting, placed, start, compression, refusal, worlds } of golden.gases) {
  test(`gas: ${name}`, () => {
    const module = load(gas);
    const values = (pointer, n) => view(pointer, n, module);
    const at = module.gas_setting(number);
    values(at, setting.length).set(setting.map(decode));
    assert.equal(module.gas_place(5), placed);
    module.gas_heat(7, 0.5);
    assert.equal(hash(values(at + 8 * module.gas_fields(), 4 * number)), start);
    assert.deepEqual(encode(module.gas_compression(1, 1)), compression[0]);
    assert.equal(module.gas_start(), refusal);
    worlds.forEach(({ reached, observed, state, logged, log, open, open_rows: openRows }, world) => {
      assert.equal(module.gas_advance(world, decode(until[0]), 1e9), reached);
      assert.deepEqual(Array.from(values(module.gas_observe(world), observed.length), encode), observed);
      assert.equal(hash(values(module.gas_state(world), 4 * number)), state);
      assert.equal(module.gas_take_log(world, 0), logged);
      assert.equal(hash(values(module.gas_log(), 7 * logged)), log);
      assert.equal(module.gas_take_log(world, 1), open);
      assert.equal(hash(values(module.gas_log(), 7 * open)), openRows);
    });
  });
}

test("the law of the error", () => {
  const module = load(gas);
  for (const { rule, at, law, error, last } of golden.laws) {
    const [phi, epsilon] = at.map(decode);
    assert.deepEqual(Array.from(view(module.law_of_error(phi, epsilon, rule, 0, 0, 1), 3, module), encode), law);
    assert.deepEqual(Array.from(view(module.law_errors(phi, epsilon, rule, 0, 0, 1, 0.1), 2, module), encode), error);
    assert.deepEqual(
      [module.law_largest(phi, epsilon, rule, 0, 0, 1, 0.01), module.law_rate(phi, 2e-3, 0.125)].map(encode),
      last,
    );
  }
});
