// Gases over random settings, with ties and extremes: the collisions have the same bits as Python's, and the numbers
// and the verdict are the same. PYTHON: an interpreter that has hardlimit installed.
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
const wasm =
  process.env.EXPLORER_GAS_WASM ?? new URL("../../src/hardlimit/explorer/page/gas.wasm", import.meta.url).pathname;

async function load() {
  const folder = mkdtempSync(join(tmpdir(), "gas-"));
  const outfile = join(folder, "gas.mjs");
  const names = ["core", "simulation", "setting", "report", "sentences", "facts"];
  await build({
    stdin: {
      contents: names.map((name) => `export * from "${src}${name}";`).join("\n"),
      resolveDir: src,
      loader: "ts",
    },
    outfile,
    bundle: true,
    format: "esm",
    platform: "node",
  });
  const modules = await import(outfile);
  rmSync(folder, { recursive: true, force: true });
  return modules;
}
const {
  GasCore,
  Simulation,
  World,
  examples,
  filmFromQuery,
  fromQuery,
  toQuery,
  percent,
  ranges,
  reportOf,
  rules,
  usual,
} = await load();
const module = new WebAssembly.Module(readFileSync(wasm));
const python = new Python();
after(() => python.end());

// An end of the range, a special value, or a random one.
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
  const facts = {
    start: simulation.start,
    hard: frame.worlds[0].observed,
    newton: frame.worlds[1].observed,
    sample: frame.sample,
    samples,
    messages,
    done: frame.done,
    atRest: frame.atRest,
  };
  const joined = (parts) => parts.flatMap((part) => Array.from(part));
  const logs = [joined(simulation.logs[0]), joined([...simulation.logs[1], core.log(World.newton, true)])];
  return {
    report: reportOf(facts, false),
    worlds: { logs, states: [core.state(World.hard), core.state(World.newton)] },
  };
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
  for (const id of ["too-soft", "stopped", "elastic-differs", "elsewhere", "differs", "agrees", "open"])
    assert.ok(seen[`verdict: ${id}`], id);
  for (const id of ["grows", "unknown"]) assert.ok(seen[`distance: ${id}`] > 5, id);
});

test("the examples do what they say", async () => {
  const runs = Object.fromEntries(
    await Promise.all(
      examples.map(async ({ id, setting }) => {
        const { report, worlds } = played(
          { ...usual, ...setting, number: Math.min(setting.number ?? usual.number, 400) },
          400,
          1,
        );
        await agrees(python, report, worlds);
        return [id, Object.fromEntries(report.sentences.map((s) => [s.topic, s.id]))];
      }),
    ),
  );
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
  const report = fromQuery(new URLSearchParams("phi=2&e=x&n=120.4&rule=none&g=5&walls=0&example=moon&tcnu="), notes);
  assert.deepEqual(report, { ...usual, phi: ranges.phi.high, number: 120, gravity: 5, walls: true });
  assert.equal(notes.length, 7, notes.join(" | "));
  for (const [query, said, key, value] of [
    ["n=149.5", "disks: 149.5 is not whole; it is 150.", "number", 150],
    ["n=1100.5", "disks: 1100.5 is outside 100 to 1000; it is 1000.", "number", 1000],
    ["walls=false", "walls = “false” is none of 0, 1: 0 used", "walls", false],
    ["example=settling&walls=no", "walls = “no” is none of 0, 1: 1 used", "walls", true],
  ]) {
    const notes = [];
    assert.equal(fromQuery(new URLSearchParams(query), notes)[key], value);
    assert.deepEqual(notes, [said]);
  }
});

test("the film of a link: its speed and its time, and what is neither", () => {
  for (const [query, film, noted] of [
    ["", { speed: "1", time: null }, 0],
    ["speed=4&t=0.01", { speed: "4", time: 0.01 }, 0],
    ["t=0", { speed: "1", time: 0 }, 0],
    ["speed=7&t=-5", { speed: "1", time: null }, 2],
    ["t=abc", { speed: "1", time: null }, 1],
    ["t=Infinity", { speed: "1", time: null }, 1],
  ]) {
    const notes = [];
    assert.deepEqual(filmFromQuery(new URLSearchParams(query), notes), film);
    assert.equal(notes.length, noted, `${query}: ${notes}`);
  }
});

test("a film that goes on to a time ends there, in steps of any size", () => {
  for (const steps of [0.25, 1, 4]) {
    const simulation = new Simulation(new GasCore(module), { ...usual, number: 100, phi: 0.3 });
    while (simulation.now < 0.00123) while (!simulation.advance(steps, 100, 0.00123));
    assert.equal(simulation.now, 0.00123);
    while (!simulation.advance(steps, 100, 0.00123));
    assert.ok(simulation.now > 0.00123, "and goes on from there");
  }
});

test("a share too small to be shown is not said to be 0; sliders end where their range does", () => {
  assert.deepEqual(
    [0, 6e-6, 1e-4, -0.012, 0.2].map((x) => percent(x).replaceAll("\u00a0", " ")),
    ["0 %", "less than 0.01 %", "0.01 %", "−1.2 %", "20 %"],
  );
  for (const { low, high, step, log } of Object.values(ranges)) {
    const [from, to] = log ? [Math.log10(low), Math.log10(high)] : [low, high];
    const last = from + Math.floor((to - from) / step + 1e-9) * step;
    assert.equal(Number((log ? 10 ** last : last).toPrecision(3)), high);
  }
});
