// Bundles the page into ../src/hardlimit/explorer/page. Deterministic: the same sources give the same bytes.
import { build } from "esbuild";
import { copyFileSync, mkdirSync, readFileSync } from "node:fs";
import { tables } from "./tables.mjs";

const out = process.argv[2] ?? "../src/hardlimit/explorer/page";
mkdirSync(out, { recursive: true });

const define = { TABLES: tables(`${out}/core.wasm`) };
const common = {
  define,
  bundle: true,
  format: "esm",
  target: "es2022",
  minify: true,
  charset: "utf8",
  legalComments: "eof",
};
// The licence of smol-toml stands in its code, those of the signals and of the QR codes do not.
const licence = readFileSync("node_modules/@preact/signals-core/LICENSE", "utf8").trim();
const qrLicence = {
  js: `/*! qr\n${readFileSync("node_modules/qr/LICENSE-MIT", "utf8")
    .trim()
    .replace(/ \(https:[^)]*\)/, "")}\n*/`,
};
const footer = { js: `/*! @preact/signals-core\n${licence}\n*/` };
await build({ ...common, footer, entryPoints: ["src/app/main.ts"], outfile: `${out}/main.js` });
await build({ ...common, footer: qrLicence, entryPoints: ["src/app/tools.ts"], outfile: `${out}/tools.js` });
await build({ ...common, entryPoints: ["src/core/first.ts"], format: "iife", outfile: `${out}/first.js` });
await build({ ...common, entryPoints: ["src/core/worker.ts"], outfile: `${out}/worker.js` });
await build({ ...common, entryPoints: ["src/gas/main.ts"], outfile: `${out}/gas.js` });
await build({ ...common, entryPoints: ["src/gas/worker.ts"], outfile: `${out}/gas_worker.js` });
await build({
  entryPoints: ["src/gas/gas.css"],
  bundle: true,
  outfile: `${out}/gas.css`,
  minify: true,
  charset: "utf8",
});
await build({
  entryPoints: ["src/style/page.css"],
  bundle: true,
  outfile: `${out}/style.css`,
  minify: true,
  charset: "utf8",
});
for (const file of ["index.html", "icon.svg"]) copyFileSync(`src/${file}`, `${out}/${file}`);
copyFileSync("src/gas/gas.html", `${out}/gas.html`);
