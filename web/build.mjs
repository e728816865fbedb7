// Bundles the page into ../src/hardlimit/explorer/page. Deterministic: the same sources give the same bytes.
import { build } from "esbuild";
import { copyFileSync, mkdirSync, readFileSync } from "node:fs";

const out = process.argv[2] ?? "../src/hardlimit/explorer/page";
mkdirSync(out, { recursive: true });

// The laws as the core states them (bindings/wasm.cpp), in the order of its registry. Infinite bounds become null.
function laws() {
  const core = new WebAssembly.Instance(new WebAssembly.Module(readFileSync(`${out}/core.wasm`)), {}).exports;
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

const define = { LAWS: laws() };
const common = { define, bundle: true, format: "esm", target: "es2022", minify: true, charset: "utf8", legalComments: "none" };
await build({ ...common, entryPoints: ["src/main.ts"], outfile: `${out}/main.js` });
await build({ ...common, entryPoints: ["src/worker.ts"], outfile: `${out}/worker.js` });
await build({ entryPoints: ["src/style.css"], outfile: `${out}/style.css`, minify: true, charset: "utf8" });
for (const file of ["index.html", "icon.svg"]) copyFileSync(`src/${file}`, `${out}/${file}`);
