// The laboratory in Chromium: what the menus Share and Export give, axes of the map, tools for a lecture.
// PYTHON: an interpreter that has hardlimit installed. SHOTS: a folder for screenshots.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { accessible, download, mapDone, sees, shoot, Site } from "./browser.mjs";
import { load } from "./modules.mjs";

const lib = await load("axes", "map_points", "link", "theme", "rises");
const { core } = lib;

let site;
before(async () => void (site = await Site.begin()));
after(() => site?.end());
const open = (t, query, options = {}) => site.open(t, query, options);

const saved = async (page, selector) => String((await download(page, selector)).bytes);
const scenarioOf = (query) => lib.settingOf(new URLSearchParams(query), []).scenario;
const csv = (text) => {
  const lines = text
    .trimEnd()
    .split("\n")
    .filter((line) => !line.startsWith("#"));
  return { head: lines[0].split(","), rows: lines.slice(1).map((line) => line.split(",").map(Number)) };
};
// Texts of an SVG picture with their sizes [px].
const textsOf = (svg) =>
  [...svg.matchAll(/<text [^>]*font-size="([^"]*)"[^>]*>([^<]*)</g)].map(([, size, text]) => ({
    size: Number(size),
    text,
  }));

// From a value to its pixel, by the first and the last tick of an axis. A label follows its tick.
function scaleOf(svg, along, log, value) {
  const pattern =
    along === "y"
      ? /d="M[\d.]+ ([\d.]+)L[\d.]+ \1"[^>]*>\n<text [^>]*text-anchor="end"[^>]*>([^<]+)</g
      : /d="M([\d.]+) [\d.]+L\1 [\d.]+"[^>]*>\n<text [^>]*text-anchor="middle"[^>]*>([^<]+)</g;
  const ticks = [...svg.matchAll(pattern)]
    .map(([, at, text]) => [Number(at), value(text)])
    .filter(([, x]) => Number.isFinite(x));
  const f = log ? Math.log : (x) => x;
  const [[a, low], [b, high]] = [ticks[0], ticks.at(-1)];
  assert.ok(ticks.length > 2 && low !== high, `ticks along ${along}`);
  return (x) => a + ((f(x) - f(low)) / (f(high) - f(low))) * (b - a);
}

function hasTexts(svg, names) {
  const texts = textsOf(svg);
  assert.ok(
    texts.every(({ size }) => size >= 13),
    "legible",
  );
  for (const name of names)
    assert.ok(
      texts.some(({ text }) => text === name),
      `${name} in ${texts.map(({ text }) => text)}`,
    );
}

test("the curve as CSV and as SVG: the values of the core", async (t) => {
  const page = await open(t, "?example=fig2&curve=e");
  await page.waitForFunction(() => document.getElementById("rebound").dataset.done === "true");
  const { head, rows } = csv(await saved(page, "#curve-csv"));
  assert.deepEqual(head, ["restitution", "newton_top_ball_height_m", "icm_top_ball_height_m"]);
  assert.ok(rows.length > 25 && rows.every(([x], i) => i === 0 || x > rows[i - 1][0]));
  const scenario = scenarioOf("example=fig2");
  for (const [x, ...heights] of rows.filter((_, i) => i % 5 === 0)) {
    const values = lib.risesOf(core, [lib.columnOf(lib.placed(scenario, [["e", x]]))]);
    heights.forEach((z, k) => assert.ok(Object.is(z, values[k]), `ε = ${x}: ${z}, ${values[k]}`));
  }
  const svg = await saved(page, "#curve-svg");
  hasTexts(svg, ["top ball rises to (m)", "coefficient of restitution ε", "Newton"]);
  const [x, y] = [scaleOf(svg, "x", false, Number), scaleOf(svg, "y", false, Number)];
  const paths = [...svg.matchAll(/<path d="M([^"]*)" fill="none" stroke="#0b57a4"/g)].map(([, d]) =>
    d.split(/[LM]/).map((point) => point.split(" ").map(Number)),
  );
  const curve = paths.sort((a, b) => b.length - a.length)[0];
  const drawn = rows.filter(([, z]) => Number.isFinite(z));
  assert.equal(curve.length, drawn.length);
  drawn.forEach(([e, z], i) => {
    const far = Math.hypot(curve[i][0] - x(e), curve[i][1] - y(z)); // ticks are rounded to pixels
    assert.ok(far < 1.5, `ε = ${e}, ${z} m: ${curve[i]}, ${[x(e), y(z)]}`);
  });
});

// Colours [r, g, b] of an SVG picture at some places [pixels].
const colorsIn = (page, svg, places) =>
  page.evaluate(
    async ([svg, places]) => {
      const image = new Image();
      image.src = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
      await image.decode();
      const canvas = Object.assign(document.createElement("canvas"), { width: image.width, height: image.height });
      const g = canvas.getContext("2d", { willReadFrequently: true });
      g.drawImage(image, 0, 0);
      return places.map(([x, y]) => Array.from(g.getImageData(Math.floor(x), Math.floor(y), 1, 1).data).slice(0, 3));
    },
    [svg, places],
  );

for (const { query, axes, show, title } of [
  { query: "?example=fig5", axes: ["e", "gap"], show: "effective", title: "gap Δh" },
  {
    query: "?example=fig2&across=k&map=h&show=verdict&zoom=1e8,1e9,0.12,0.4",
    axes: ["k", "h"],
    show: "verdict",
    title: "height h",
  },
])
  test(`the map as CSV and as SVG, ${show} over ${axes}: the values of the core`, async (t) => {
    const page = await open(t, query, { maps: true });
    await page.locator("#map-box").scrollIntoViewIfNeeded();
    await mapDone(page);
    const { rows } = csv(await saved(page, "#map-csv"));
    assert.ok(rows.length >= 2500, String(rows.length));
    const some = rows.filter((_, i) => i % Math.ceil(rows.length / 150) === 7);
    const tolerance = show === "verdict" ? 0.01 : null;
    const points = Float64Array.from(some.flatMap(([x, y]) => [x, y]));
    const values = lib.mapPoints(core, { scenario: scenarioOf(query), axes, tolerance, points });
    some.forEach(([x, y, ...row], i) =>
      row.forEach((z, k) => assert.ok(Object.is(z, values[lib.MAP_VALUES * i + k]), `${x}, ${y}: ${z}`)),
    );
    const svg = await saved(page, "#map-svg");
    const legend =
      show === "verdict"
        ? ["agree", "do not agree", "independent collisions and Newton"]
        : ["effective ε over ε", "0", "1"];
    hasTexts(svg, [title, ...legend]);
    const unit = { e: "", gap: "m", k: "N/m", h: "m" };
    const [x, y] = ["x", "y"].map((along, i) =>
      scaleOf(svg, along, lib.axes[axes[i]].log, (text) => lib.parse(text, unit[axes[i]])),
    );
    const seen = await colorsIn(
      page,
      svg,
      some.map((row) => [x(row[0]), y(row[1])]),
    );
    const wrong = some.filter((row, i) => {
      const color = show === "verdict" ? lib.verdictColors[row[5]] : lib.ratioColor(row[3]);
      return color.some((c, k) => Math.abs(c - seen[i][k]) > 12);
    });
    // The cross at the setting, the line of agreement and texts cover a few points.
    assert.ok(wrong.length < 0.12 * some.length, `${wrong.length} of ${some.length}`);
  });

test("axes of the map: any two, by keyboard, in the link, with its claims", async (t) => {
  const page = await open(t, "?example=fig2", { maps: true });
  await page.locator("#map-box").scrollIntoViewIfNeeded();
  await page.selectOption("#map-across", "k");
  await page.selectOption("#map-axis", "mass");
  assert.equal(await page.textContent("#map-title"), "Every stiffness and every mass of the lower ball");
  await mapDone(page);
  await page.waitForFunction(() => location.search.includes("map=mass&across=k"));
  assert.match(await page.textContent("#map-reading"), /^k = 50 MN\/m, m₁\/m₂ = 1000: 4 contacts/);
  const before = await page.evaluate(() => document.documentElement.dataset.numbers);
  await page.focus("#map");
  await page.keyboard.press("ArrowLeft");
  await page.waitForFunction((text) => document.documentElement.dataset.numbers !== text, before);
  const stiffness = Number(
    /[?&]k=([^&]+)/.exec(
      await page.evaluate(
        () => window.hardlimit && location.search + "&k=" + window.hardlimit.report().setting.constants.stiffness,
      ),
    )[1],
  );
  assert.ok(stiffness < 4.5e7 && stiffness > 4e7, String(stiffness));
  await page.selectOption("#map-across", "mass"); // both change places
  assert.deepEqual(
    await page.evaluate(() => ["map-across", "map-axis"].map((id) => document.getElementById(id).value)),
    ["mass", "k"],
  );
  await accessible(page, "the laboratory with other axes");
  await page.selectOption("#map-show", "verdict");
  await mapDone(page);
  const said = await page.evaluate(() => [
    document.getElementById("map-reading").textContent,
    document.getElementById("answer").textContent,
  ]);
  assert.match(said[0], /do not agree to 1 %/);
  assert.match(said[1], /^No:/);
  await shoot(page, "lab-map-axes");
});

test("a cradle has neither height nor radii on the map", async (t) => {
  const page = await open(t, "?example=cradle&map=h&across=ratio");
  const off = await page.evaluate(() =>
    [...document.getElementById("map-axis").options].filter((o) => o.disabled).map((o) => o.value),
  );
  assert.deepEqual(off, ["ratio", "h"]);
  assert.deepEqual(
    await page.evaluate(() => ["map-across", "map-axis"].map((id) => document.getElementById(id).value)),
    ["e", "gap"],
  );
});

test("this setting as Python and as a command: copied, by keyboard", async (t) => {
  const page = await open(t, "?example=fig2");
  await page.evaluate(() =>
    Object.defineProperty(navigator, "clipboard", {
      value: { writeText: async (text) => void (window.copied = text) },
    }),
  );
  await page.focus("#export summary");
  await page.keyboard.press("Enter");
  await page.keyboard.press("Tab");
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => window.copied);
  assert.match(
    await page.evaluate(() => window.copied),
    /^import hardlimit as hl\n[^]*radius|Ball\(0.1, density=840\)/,
  );
  await page.keyboard.press("Tab");
  await page.evaluate(() => delete window.copied);
  // The button says so for a moment.
  const says = () => document.getElementById("copy-command").textContent === "Copied";
  await sees(page, says, null, () => page.keyboard.press("Enter"));
  await page.waitForFunction(() => window.copied);
  assert.match(await page.evaluate(() => window.copied), /^hardlimit drop --law linear --radius 0.1 /);
  await accessible(page, "the open menu");
  await page.keyboard.press("Escape");
  assert.equal(await page.evaluate(() => document.activeElement.closest("details").id), "export");
});
