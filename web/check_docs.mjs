// The built documentation in Chromium, without a network: node check_docs.mjs FOLDER Every page asks for nothing
// outside itself, sets all of its formulas, complains of nothing and fits a phone; the search works. Prints a line for
// each fault. Pages named after FOLDER are looked at instead of all. CHROMIUM: the browser. SHOTS: a folder for a
// picture of each page, light and dark, wide and on a phone.
import { createServer } from "node:http";
import { mkdirSync, readdirSync, readFileSync } from "node:fs";
import { extname, join, normalize } from "node:path";
import { launch } from "./chromium.mjs";

const root = process.argv[2];
const types = {
  ".html": "text/html; charset=utf-8",
  ".js": "text/javascript",
  ".css": "text/css",
  ".svg": "image/svg+xml",
  ".png": "image/png",
  ".gif": "image/gif",
  ".wasm": "application/wasm",
  ".woff": "font/woff",
  ".json": "application/json",
};
const only = process.argv.slice(3); // pages, instead of all
const pages = readdirSync(root, { recursive: true })
  .map(String)
  .filter((name) => name.endsWith(".html") && !name.startsWith("explorer-page") && !name.startsWith("_static"))
  .filter((name) => !only.length || only.includes(name))
  .sort();

const server = createServer((request, response) => {
  const path = normalize(decodeURIComponent(new URL(request.url, "http://localhost").pathname));
  try {
    const bytes = readFileSync(join(root, path));
    response
      .writeHead(200, {
        "content-type": types[extname(path)] ?? "application/octet-stream",
        "cache-control": "max-age=3600",
      })
      .end(bytes);
  } catch {
    response.writeHead(404).end();
  }
});
await new Promise((ready) => server.listen(0, "127.0.0.1", ready));
const base = `http://127.0.0.1:${server.address().port}/`;
// No network; a route of Playwright would turn off the cache.
const browser = await launch("--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1");

// A page of the site that notes what it should not do.
async function watched(context, note) {
  const page = await context.newPage();
  page.on(
    "request",
    (request) =>
      !/^(data|blob):/.test(request.url()) && !request.url().startsWith(base) && note("asks for " + request.url()),
  );
  page.on("console", (message) => message.type() === "error" && note(message.text()));
  page.on("pageerror", (error) => note(String(error)));
  page.on("response", (answer) => answer.status() >= 400 && note(`${answer.status()} for ${answer.url()}`));
  return page;
}

// In the page: what is wrong with its formulas and pictures. The first element is the number of formulas.
async function faultsOfContent() {
  const faults = [];
  const formulas = [...document.querySelectorAll(".math")];
  if (formulas.length) {
    if (!globalThis.MathJax?.startup) return [formulas.length, "has formulas and no MathJax"];
    await MathJax.startup.promise;
    await document.fonts.ready;
    const bare = formulas.filter((f) => !(f.querySelector("mjx-container")?.getBoundingClientRect().width > 0));
    if (bare.length) faults.push(`${bare.length} of ${formulas.length} formulas are not set`);
    if (document.querySelector("mjx-merror, [data-mjx-error]")) faults.push("a formula with a fault in it");
    if (![...document.fonts].some((f) => /MJX/.test(f.family) && f.status === "loaded"))
      faults.push("no font of MathJax");
  }
  for (const picture of document.images) {
    picture.loading = "eager";
    await picture.decode().catch(() => faults.push("a picture that cannot be shown: " + picture.src));
  }
  return [formulas.length, ...faults];
}

// In the page: what is wider than the screen.
function faultsOfWidth() {
  const excess = document.scrollingElement.scrollWidth - innerWidth;
  if (excess <= 0) return [];
  const wide = [...document.querySelectorAll("article *")].find((e) => e.getBoundingClientRect().right > innerWidth);
  return [`${excess} px wider than a screen of ${innerWidth} px: ${wide?.outerHTML.slice(0, 80)}`];
}

// In the page: code that is cut at the right, and panels of the explorer that are higher or wider than their frame.
// Lines that do not wrap have at most 90 letters: more fit or not with the font of the machine.
async function faultsOfBlocks() {
  const isTooLong = (e) =>
    getComputedStyle(e).whiteSpace === "pre" && e.innerText.split("\n").some((line) => line.length > 90);
  const faults = [...document.querySelectorAll("article pre")]
    .filter((e) => e.scrollWidth > e.clientWidth + 1 || isTooLong(e))
    .map((e) => "a block of code is cut: " + e.innerText.slice(0, 60));
  for (const frame of document.querySelectorAll("article iframe")) {
    frame.loading = "eager";
    const excess = () => {
      const inside = frame.contentDocument?.querySelector("svg, canvas") && frame.contentDocument.scrollingElement;
      return inside
        ? Math.max(inside.scrollWidth - frame.clientWidth, inside.scrollHeight - frame.clientHeight)
        : Infinity;
    };
    for (let k = 0; k < 600 && excess() > 0; k++) await new Promise(requestAnimationFrame); // until it is laid out
    if (excess() > 0) faults.push(`${frame.title}: ${excess()} px larger than its frame`);
  }
  return faults;
}

async function picture(page, name, view) {
  if (!process.env.SHOTS) return;
  mkdirSync(process.env.SHOTS, { recursive: true });
  for (const colorScheme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme });
    await page.screenshot({ path: join(process.env.SHOTS, `${name.replaceAll("/", "_")}-${view}-${colorScheme}.png`) });
  }
}

const context = await browser.newContext({ reducedMotion: "reduce" });
const faults = [];
let formulas = 0;
for (const name of pages) {
  const note = (text) => faults.push(`${name}: ${text}`);
  const page = await watched(context, note);
  await page.setViewportSize({ width: 1280, height: 900 });
  await page.goto(base + name, { waitUntil: "load" });
  const [count, ...match] = await page.evaluate(faultsOfContent);
  formulas += count;
  match.forEach(note);
  (await page.evaluate(faultsOfWidth)).forEach(note);
  (await page.evaluate(faultsOfBlocks)).forEach(note);
  await picture(page, name, "wide");
  await page.setViewportSize({ width: 390, height: 844 });
  (await page.evaluate(faultsOfWidth)).forEach(note);
  await picture(page, name, "phone");
  await page.close();
}
// The search finds what is on every page, without a server behind it.
const search = await watched(context, (text) => faults.push("search.html: " + text));
await search.goto(base + "search.html?q=restitution");
await search.waitForSelector("ul.search li", { timeout: 20_000 }).catch(() => faults.push("the search finds nothing"));
await browser.close();
server.close();
if (!formulas && !only.length) faults.push(`no formula on ${pages.length} pages`);
faults.forEach((fault) => console.log(fault));
console.log(`${pages.length} pages, ${formulas} formulas, ${faults.length} faults`);
process.exit(faults.length ? 1 : 0);
