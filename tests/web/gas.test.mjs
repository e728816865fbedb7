// The page of the gas in a browser: collisions, sentences, film, controls, links, themes, sizes. gas_settings.test.mjs
// compares its results with Python.
import assert from "node:assert/strict";
import { readdirSync, statSync } from "node:fs";
import { after, before, test } from "node:test";
import { accessible, address, colours, download, frames, resize, sees, shoot, Site } from "./browser.mjs";
import { agrees, Python } from "./gas.mjs";

let site;
let firefox;
const python = new Python();
before(async () => void ([site, firefox] = await Promise.all([Site.begin(), Site.begin("firefox")])));
after(async () => {
  python.end();
  await Promise.all([site?.end(), firefox?.end()]);
});

const ready = (page) => page.waitForFunction(() => window.hardlimit?.report()?.samples.length > 0);
const open = (t, query = "", options = {}, from = site) => from.open(t, `gas.html${query}`, { ready, ...options });
// Waits for a film that is paused, drawn at the time of its link or later.
async function settled(page) {
  await frames(page);
  await page.waitForSelector("html[data-settled]");
}
// Waits until this many starts have run.
const started = (page, n) => page.waitForFunction((n) => Number(document.documentElement.dataset.starts) >= n, n);
const report = (page) => page.evaluate(() => window.hardlimit.report());
const moving = { reducedMotion: "no-preference" };

async function both(page) {
  const worlds = await page.evaluate(async () => {
    const { logs, states } = await window.hardlimit.log();
    return { logs: logs.map((x) => Array.from(x)), states: states.map((x) => Array.from(x)) };
  });
  return [await report(page), worlds];
}

// gas_settings.test.mjs has more of them, without a browser.
const settings = [
  "?phi=0.4&e=0.7&tcnu=0.03&n=100&rule=tc&walls=1&g=9.8&t=0.01",
  "?example=collapse&n=100&t=0.03",
  "?phi=0.4&e=0.9&tcnu=0.1&n=100&mu=0.5&t=0.005",
];
for (const engine of ["Chromium", "Firefox"])
  test(`${engine}: collisions and sentences are Python's`, async (t) => {
    const page = await open(t, settings[0], {}, engine === "Firefox" ? firefox : site);
    for (const query of settings) {
      await page.evaluate((query) => {
        history.pushState(null, "", query);
        dispatchEvent(new PopStateEvent("popstate"));
      }, query);
      await page.waitForFunction(
        (t) => window.hardlimit.report()?.time >= t || window.hardlimit.report()?.done,
        Number(new URLSearchParams(query).get("t")),
      );
      await settled(page);
      await started(page, 8);
      await agrees(python, ...(await both(page)));
    }
  });

test("what is written on the page is what the report says", async (t) => {
  const page = await open(t, settings[1]);
  await settled(page);
  await started(page, 16);
  const { sentences } = await report(page);
  const written = await page.evaluate(() =>
    ["verdict", "law", "news", "mean", "measured"].map((id) => document.getElementById(id).textContent).join(" "),
  );
  for (const { text } of sentences) assert.ok(written.includes(text.replaceAll("t_c", "tc")), text);
  assert.match(written, /inelastic collapse, infinitely many collisions in a finite time\. Newton’s equations go on/);
});

const canvases = ["hard", "newton", "energy", "cooling", "surplus", "distance", "share"];

test("it opens playing; pause, step, again and keys", async (t) => {
  const page = await open(t, "?n=100", moving);
  await page.waitForFunction(() => window.hardlimit.report().samples.length > 20);
  assert.equal(await page.textContent("#play"), "Pause");
  await page.click("#play");
  const stopped = async () => {
    await settled(page);
    return (await report(page)).time;
  };
  const before = await stopped();
  await frames(page, 10);
  assert.equal(await stopped(), before);
  await page.click("#step");
  const after = await stopped();
  assert.ok(after > before);
  assert.equal((await address(page)).searchParams.has("t"), true);
  await page.keyboard.press("."); // the button still has the focus
  assert.ok((await stopped()) > after);
  const again = (after) =>
    window.hardlimit.report()?.time < after && document.getElementById("play").textContent === "Pause";
  await sees(page, again, after, () => page.keyboard.press("R"));
  await page.evaluate(() => document.activeElement.blur());
  await page.keyboard.press(" ");
  assert.equal(await page.textContent("#play"), "Play");
});

test("a link keeps the time at which the film stands still", async (t) => {
  const time = async (page) => Number((await address(page)).searchParams.get("t"));
  const page = await open(t, "?n=100&phi=0.3&t=0.01&speed=4", moving);
  await settled(page);
  assert.deepEqual([await time(page), (await report(page)).time], [0.01, 0.01]);
  await page.click("#step");
  await settled(page);
  const next = await time(page);
  assert.ok(next > 0.01);
  assert.equal(next, (await report(page)).time);
  await page.click("#play");
  await page.waitForFunction(() => window.hardlimit.report().time > 0.02);
  await page.click("#play");
  await settled(page);
  const { time: last, samples } = await report(page);
  assert.equal(await time(page), last);
  const other = await open(t, (await address(page)).search, moving);
  await settled(other);
  const again = await report(other);
  assert.equal(again.time, last);
  assert.deepEqual(again.samples.at(-1).energy, samples.at(-1).energy);
});

test("a film that stands at its start does so again", async (t) => {
  const page = await open(t, "?n=100&t=0", moving);
  assert.equal(await page.textContent("#play"), "Play");
  assert.equal((await report(page)).time, 0);
});

test("it plays after a change; the starts are those of the link", async (t) => {
  const page = await open(t, "?n=100&phi=0.3&t=0.001", moving);
  await settled(page);
  const before = (await report(page)).setting.restitution;
  await page.focus("#restitution");
  await page.keyboard.press("ArrowLeft");
  await page.waitForFunction(() => document.getElementById("play").textContent === "Pause");
  await page.waitForFunction(
    (before) => window.hardlimit.report()?.setting.restitution < before && window.hardlimit.report().samples.length > 5,
    before,
  );
  await started(page, 8);
  const { starts, setting } = await report(page);
  assert.deepEqual(
    starts.slice(0, 8).map(({ seed }) => seed),
    [1, 2, 3, 4, 5, 6, 7, 8],
  );
  const other = await open(t, `?${new URLSearchParams({ n: 100, phi: 0.3, e: setting.restitution, seed: 1 })}`);
  await started(other, 8);
  assert.deepEqual((await report(other)).starts.slice(0, 8), starts.slice(0, 8));
  await started(other, 16);
  await other.click("#more");
  await started(other, 17);
});

test("saves a table and a picture; copies Python", async (t) => {
  const page = await open(t, "?n=100&phi=0.3&mu=0.4&e=0.9&t=0.002");
  await settled(page);
  await started(page, 16);
  const lines = String((await download(page, "#csv")).bytes)
    .trim()
    .split("\n");
  const rows = lines.filter((line) => !line.startsWith("#")).map((line) => line.split(","));
  const { starts, python: program } = await report(page);
  assert.equal(rows.length, 62);
  assert.ok(rows.every((row) => row.length === rows[0].length));
  const column = rows[0].indexOf("newton_energy_of_seed_3");
  assert.equal(Number(rows[61][column]), starts[2].energy[1][60]);
  assert.ok(lines.includes(`# ${program}`));
  assert.equal((await download(page, "#png")).bytes.subarray(1, 4).toString(), "PNG");
});

test("with reduced motion it stands still, and nothing is empty", async (t) => {
  const page = await open(t);
  await settled(page);
  const { time, playing, samples } = await report(page);
  assert.ok(time > 0.01 && !playing && samples.length > 100);
  for (const id of canvases) assert.ok((await colours(page, id)) > 8, id);
});

test("controls change the setting, and the link gives the same page again", async (t) => {
  const page = await open(t, "?n=100&t=0.003");
  await settled(page);
  for (const [id, key] of [
    ["phi", "ArrowRight"],
    ["restitution", "ArrowLeft"],
    ["tcNu", "ArrowRight"],
    ["number", "ArrowRight"],
    ["gravity", "ArrowRight"],
    ["friction", "ArrowRight"],
  ]) {
    await page.focus(`#${id}`);
    await page.keyboard.press(key);
  }
  await page.check("#rule-tc");
  await page.selectOption("#speed", "0.25");
  await page.waitForFunction(() => window.hardlimit.report()?.setting.rule === "tc");
  const { setting } = await report(page);
  assert.deepEqual(
    { ...setting, tcNu: 0 },
    {
      number: 150,
      phi: 0.51,
      restitution: 0.84,
      tcNu: 0,
      rule: "tc",
      walls: true,
      gravity: 0.5,
      seed: 1,
      friction: 0.01,
      stiffnessRatio: 0.286,
    },
  );
  assert.ok(setting.tcNu > 0.1 && setting.tcNu < 0.12);
  await settled(page);
  for (let i = 0; i < 3; i++) {
    await page.click("#step");
    await settled(page);
  }
  const first = await report(page);
  const query = (await address(page)).search;
  const other = await open(t, query);
  await settled(other);
  const second = await report(other);
  assert.equal(await other.inputValue("#speed"), "0.25");
  assert.deepEqual(second.setting, first.setting);
  assert.deepEqual(second.start, first.start);
  assert.equal(second.time, first.time);
  await page.uncheck("#walls");
  await page.waitForFunction(() => window.hardlimit.report()?.setting.gravity === 0);
  await page.click("#other");
  await page.waitForFunction(() => window.hardlimit.report()?.setting.seed === 2);
});

test("of two changes while the worker is busy the last one counts", async (t) => {
  const page = await open(t, "?n=100&t=0.001");
  await settled(page);
  const shown = await page.evaluate(async () => {
    const { postMessage } = Worker.prototype;
    let busy = null; // a worker that gets no more messages
    Worker.prototype.postMessage = function (...message) {
      // eslint-disable-next-line @typescript-eslint/no-this-alias -- the worker whose method this is
      if (message[0].ask?.kind === "start") busy ??= this;
      if (this !== busy) postMessage.apply(this, message);
    };
    const slider = document.getElementById("phi");
    for (const phi of [0.1, 0.6]) {
      slider.value = String(phi);
      slider.dispatchEvent(new Event("input"));
      await new Promise((done) => setTimeout(done, 400));
    }
    while (!window.hardlimit.report()) await new Promise((done) => setTimeout(done, 20));
    return window.hardlimit.report().setting.phi;
  });
  assert.equal(shown, 0.6);
});

test("examples start a run", async (t) => {
  const page = await open(t, "?n=150", moving);
  const all = ["thin", "dense", "collapse", "settling", "rough"];
  for (const id of all) {
    const run = await page.evaluate(() => document.documentElement.dataset.run);
    await page.click(`#example-${id}`);
    await page.waitForFunction(
      ([id, run]) =>
        document.documentElement.dataset.run !== run &&
        document.getElementById(`example-${id}`).getAttribute("aria-pressed") === "true" &&
        window.hardlimit.report()?.samples.length > 15,
      [id, run],
    );
    assert.equal(await page.getAttribute('[aria-pressed="true"][id^="example"]', "id"), `example-${id}`);
    await shoot(page, `gas-${id}`);
  }
  await page.goBack(); // examples are steps of the history
  await page.waitForFunction(() => document.getElementById("example-settling").getAttribute("aria-pressed") === "true");
});

test("what cannot run is said in one line", async (t) => {
  const page = await open(t, "?phi=0.02&tcnu=0.3&e=7&g=3&walls=0");
  await page.waitForFunction(() => document.getElementById("verdict").textContent !== "");
  assert.equal(await page.isVisible("#more"), false);
  assert.match(await page.textContent("#verdict"), /^These disks are too soft: .* Choose t_?c ν below 0\.\d+\.$/);
  assert.match(
    await page.textContent("#notes"),
    /restitution ε: 7 is outside 0\.1 to 1; it is 1\..*Gravity needs a floor/,
  );
  await settled(page);
  for (const id of ["hard", "newton", "energy"]) assert.ok((await colours(page, id)) > 4, id);
  await page.click("#step");
  await page.click("#play");
  assert.equal((await report(page)).time, 0);
});

test("the disks cover their packing fraction of the picture", async (t) => {
  for (const [n, deviceScaleFactor] of [
    [500, 1],
    [150, 2],
  ]) {
    const page = await open(t, `?n=${n}&phi=0.4&t=0`, { deviceScaleFactor });
    await settled(page);
    const shares = await page.evaluate(() =>
      ["hard", "newton"].map((id) => {
        const canvas = document.getElementById(id);
        const inset = Math.ceil(0.04 * canvas.width); // the edge is not drawn here
        const { data } = canvas
          .getContext("2d")
          .getImageData(inset, inset, canvas.width - 2 * inset, canvas.height - 2 * inset);
        const disk = getComputedStyle(document.documentElement).getPropertyValue("--disk");
        const dark = parseInt(/#(..)/.exec(disk)[1], 16);
        let covered = 0;
        for (let i = 0; i < data.length; i += 4) covered += (255 - data[i]) / (255 - dark);
        return covered / (data.length / 4);
      }),
    );
    for (const share of shares) assert.ok(Math.abs(share - 0.4) < 0.02, `${n} disks: ${share}`);
  }
});

test("accessible, in both themes, at every size and in print", async (t) => {
  const sizes = {
    phone: [390, 844],
    landscape: [844, 390],
    laptop: [1280, 720],
    large: [1920, 1080],
    zoomed: [640, 360],
    "zoomed fourfold": [320, 256],
  };
  const page = await open(t, "?example=dense&n=100");
  await settled(page);
  await started(page, 8);
  for (const [name, [width, height]] of Object.entries(sizes)) {
    await resize(page, width, height);
    for (const colorScheme of ["light", "dark"]) {
      await page.emulateMedia({ colorScheme });
      await page.waitForFunction((scheme) => document.documentElement.dataset.theme === scheme, colorScheme);
      await accessible(page, `${name}, ${colorScheme}`);
      const seen = await page.evaluate(
        () => document.getElementById("newton").getBoundingClientRect().bottom <= innerHeight,
      );
      if (!name.startsWith("zoomed")) assert.ok(seen, `${name}: both worlds are on the first screen`);
      await shoot(page, `gas-${name}-${colorScheme}`, { fullPage: true });
      if (name !== "laptop") continue;
      await page.emulateMedia({ media: "print" });
      await accessible(page, "print");
      await shoot(page, `gas-print-${colorScheme}`, { fullPage: true });
      await page.emulateMedia({ media: "screen" });
    }
  }
  const ground = () => page.evaluate(() => getComputedStyle(document.documentElement).backgroundColor);
  const before = await ground();
  await page.click("#theme");
  assert.notEqual(await ground(), before, "the theme is switched by hand");
});

test("the first page links to the gas, and back", async (t) => {
  const page = await site.open(t);
  await page.click("#menu summary");
  await page.click('a[href="gas.html"]');
  await ready(page);
  await page.click('h1 a[href="index.html"]');
  await page.waitForURL(/index\.html$/);
});

test("below 550 kB; friction is loaded when it is chosen", (t) => {
  const folder = new URL("../../src/hardlimit/explorer/page/", import.meta.url);
  const size = readdirSync(folder)
    .filter((name) => name.startsWith("gas") && name !== "gas_friction.wasm")
    .reduce((sum, name) => sum + statSync(new URL(name, folder)).size, 0);
  const { size: rubbing } = statSync(new URL("gas_friction.wasm", folder));
  t.diagnostic(`${size} bytes, with friction ${rubbing} more`);
  assert.ok(size < 550_000 && rubbing < 550_000, `${size} ${rubbing}`);
});
