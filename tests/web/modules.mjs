// Loads the page's modules into node, with the compiled core, for tests without a browser.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { build } from "esbuild";
import { mkdtempSync, readdirSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { tables } from "../../web/tables.mjs";

const src = new URL("../../web/src/", import.meta.url).pathname;
const wasm =
  process.env.EXPLORER_WASM ?? new URL("../../src/hardlimit/explorer/page/maps.wasm", import.meta.url).pathname;

// The path of a module by its name, which occurs in one room of web/src only. The gas has modules of its own.
const paths = readdirSync(src, { recursive: true })
  .map(String)
  .filter((path) => path.endsWith(".ts") && !path.startsWith("gas/"));
function pathOf(name) {
  const matches = paths.filter((path) => path === `${name}.ts` || path.endsWith(`/${name}.ts`));
  if (matches.length !== 1) throw new Error(`web/src has ${matches.length} modules ${name}`);
  return src + matches[0];
}

// Loads the modules listed here and those in `more`.
export async function load(...more) {
  const folder = mkdtempSync(join(tmpdir(), "modules-"));
  const names = [
    "clock",
    "core",
    "drop",
    "exact_numbers",
    "format",
    "motion",
    "scenario",
    "table",
    "trajectory_csv",
    ...more,
  ];
  const outfile = join(folder, "modules.mjs");
  const contents = names.map((name) => `export * from "${pathOf(name)}";`).join("\n");
  await build({
    stdin: { contents, resolveDir: src, loader: "ts" },
    outfile,
    bundle: true,
    format: "esm",
    platform: "node",
    define: { TABLES: tables(wasm) },
  });
  const modules = await import(outfile);
  rmSync(folder, { recursive: true, force: true });
  return { ...modules, core: new modules.Core(new WebAssembly.Module(readFileSync(wasm))) };
}

// Output of a Python program that reads a list of texts as JSON and prints a line of JSON for each.
export async function fromPython(program, texts) {
  const python = spawn(process.env.PYTHON ?? "python3", ["-c", program], { stdio: ["pipe", "pipe", "inherit"] });
  python.stdin.end(JSON.stringify(texts));
  let said = "";
  for await (const data of python.stdout.setEncoding("utf8")) said += data;
  const lines = said
    .trim()
    .split("\n")
    .map((line) => JSON.parse(line));
  assert.equal(lines.length, texts.length);
  return lines;
}

// Numbers in [0, 1) from a seed (mulberry32).
export function random(seed) {
  let state = seed | 0;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

// A link to a random setting of two to six balls, with ties and touching balls.
export function randomLink(next) {
  const log = (low, high) => Number((low * (high / low) ** next()).toPrecision(4));
  const n = 2 + Math.floor(5 * next() ** 2); // small numbers are more frequent, since they take less time
  const law = ["linear", "viscoelastic", "tsuji"][Math.floor(3 * next())];
  const q = new URLSearchParams({ law, e: next() < 0.1 ? "1" : (0.3 + 0.7 * next()).toFixed(3) });
  if (law === "linear") q.set("k", log(1e5, 1e8));
  if (law === "viscoelastic")
    for (const [key, value] of [
      ["Y", log(1e7, 1e11)],
      ["nu", (0.5 * next()).toFixed(2)],
      ["v", log(0.1, 10)],
    ])
      q.set(key, value);
  if (law === "tsuji") q.set("K", log(1e7, 1e10));
  const common = log(0.005, 0.1);
  const alike = next() < 0.2;
  const list = (make) => Array.from({ length: n }, make).join();
  q.set(
    "r",
    list(() => (alike ? common : log(0.005, 0.1))),
  );
  q.set(
    "rho",
    list(() => log(300, 8000)),
  );
  q.set("gap", Array.from({ length: n - 1 }, () => (next() < 0.25 ? 0 : log(1e-6, 0.03))).join());
  q.set("h", log(0.15, 2));
  return q;
}
