// What must hold for every gas, over random settings, ties and extremes included: same collisions, bit for bit, same
// numbers and the same verdict as Python's. PYTHON: an interpreter that has hardlimit installed.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, test } from "node:test";
import { build } from "esbuild";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { agrees, Python } from "./gas.mjs";
import { random } from "./modules.mjs";

const count = 120;
const src = new URL("../../web/src/gas/", import.meta.url).pathname;
const wasm = process.env.EXPLORER_GAS_WASM ?? new URL("../../src/hardlimit/explorer/page/gas.wasm", import.meta.url).pathname;

async function load() {
  const folder = mkdtempSync(join(tmpdir(), "gas-"));
  const outfile = join(folder, "gas.mjs");
  const names = ["core", "simulation", "setting", "report", "sentences", "facts"];
  await build({ stdin: { contents: names.map((name) => `export * from "${src}${name}";`).join("\n"), resolveDir: src, loader: "ts" }, outfile, bundle: true, format: "esm", platform: "node" });
  const modules = await import(outfile);
  rmSync(folder, { recursive: true, force: true });
  return modules;
}
const { GasCore, Simulation, World, examples, fromQuery, toQuery, ranges, reportOf, rules, usual } = await load();
const module = new WebAssembly.Module(readFileSync(wasm));
const python = new Python();
after(() => python.end());

// One of the ends of the range, or a value that decides something, or anything between.
function draw(next, { low, high, log }, ties) {
  const u = next();
  if (u < 0.12) return low;
  if (u < 0.24) return high;
  if (u < 0.4) return ties[Math.floor(next() * ties.length)];
  const x = log ? low * (high / low) ** next() : low + (high - low) * next();
  return Number(x.toPrecision(3));
}
function randomSetting(next) {
  const gravity = next() < 0.25 ? draw(next, ranges.gravity, [9.81]) : 0;
  return {
    number: [100, 101, 150, 250][Math.floor(4 * next())],
    phi: draw(next, ranges.phi, [0.05, 0.3, 0.5]),
    restitution: draw(next, ranges.restitution, [0.6, 0.9, 0.99]),
    tcNu: draw(next, ranges.tcNu, [0.01, 0.05, 0.1]),
    rule: rules[Math.floor(rules.length * next())],
    walls: gravity > 0 || next() < 0.25,
    gravity,
    seed: 1 + Math.floor(1000 * next()),
  };
}

function played(setting, frames, steps) {
  const core = new GasCore(module);
  const simulation = new Simulation(core, setting);
  const samples = [];
  let frame = simulation.frame();
  samples.push(frame.sample);
  const begin = performance.now();
  if (simulation.start.tooSoft === 0)
    for (let k = 0; k < frames && !frame.done && performance.now() - begin < 4000; k++) {
      while (!simulation.advance(steps, 100));
      frame = simulation.frame();
      samples.push(frame.sample);
    }
  const messages = Array.from({ length: 8 }, (_, i) => core.outcome(i));
  const facts = { start: simulation.start, hard: frame.worlds[0].observed, newton: frame.worlds[1].observed, sample: frame.sample, samples, messages, done: frame.done, atRest: frame.atRest };
  const joined = (parts) => parts.flatMap((part) => Array.from(part));
  const logs = [joined(simulation.logs[0]), joined([...simulation.logs[1], core.log(World.newton, true)])];
  return { report: reportOf(facts, false), worlds: { logs, states: [core.state(World.hard), core.state(World.newton)] } };
}

test(`${count} random gases: collisions, numbers and sentences are Python's`, async (t) => {
  const next = random(2027);
  const seen = {};
  for (let k = 0; k < count; k++) {
    const setting = randomSetting(next);
    const { report, worlds } = played(setting, Math.floor(2 + 60 * next()), [0.25, 1, 4, 9][k % 4]);
    await agrees(python, report, worlds);
    for (const { topic, id } of report.sentences) seen[`${topic}: ${id}`] = (seen[`${topic}: ${id}`] ?? 0) + 1;
  }
  t.diagnostic(JSON.stringify(seen));
  for (const id of ["too-soft", "stopped", "elastic", "elsewhere", "differs", "agrees", "open"]) assert.ok(seen[`verdict: ${id}`], id);
  for (const id of ["grows", "unknown"]) assert.ok(seen[`distance: ${id}`] > 5, id);
});

test("the examples do what they say", async () => {
  const runs = Object.fromEntries(await Promise.all(examples.map(async ({ id, setting }) => {
    const { report, worlds } = played({ ...usual, ...setting, number: Math.min(setting.number ?? usual.number, 400) }, 400, 1);
    await agrees(python, report, worlds);
    return [id, Object.fromEntries(report.sentences.map((s) => [s.topic, s.id]))];
  })));
  assert.equal(runs.thin.verdict, "agrees");
  assert.equal(runs.dense.verdict, "differs");
  assert.equal(runs.collapse.hard, "collapse");
  assert.equal(runs.settling.verdict, "elsewhere");
});

test("a link gives its setting again; what is out of range is said", () => {
  const next = random(5);
  for (let k = 0; k < 300; k++) {
    const setting = randomSetting(next);
    const notes = [];
    assert.deepEqual(fromQuery(toQuery(setting), notes), setting);
    assert.deepEqual(notes, []);
  }
  const notes = [];
  const found = fromQuery(new URLSearchParams("phi=2&e=x&n=120.4&rule=none&g=5&walls=0&example=moon&tcnu="), notes);
  assert.deepEqual(found, { ...usual, phi: ranges.phi.high, number: 120, gravity: 5, walls: true });
  assert.equal(notes.length, 7, notes.join(" | "));
});
