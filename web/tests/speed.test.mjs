// How quick the page is, in Chromium, by itself: ci.sh runs this file when the others are done. TIMES=off prints the
// times and judges none, for a busy machine.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { forget, goTo, mapDone, Site } from "./browser.mjs";
import { long } from "./scenarios.mjs";

const strict = process.env.TIMES !== "off";
let site;
before(async () => void (site = await Site.begin()));
after(() => site?.end());
const open = (t, query = "?example=fig2", options = {}) => site.open(t, query, options);

test("the first picture", async (t) => {
  const page = await open(t);
  const first = Number(await page.evaluate(() => document.documentElement.dataset.ready));
  t.diagnostic(`first picture after ${first} ms`);
  if (strict) assert.ok(first < 1000);
});

test("the film", async (t) => {
  const page = await open(t, "?example=fig2", { reducedMotion: "no-preference" });
  await page.waitForFunction(() => /× slower/.test(document.getElementById("speed").textContent), null, { timeout: 10_000 });
  const frames = await page.evaluate(() => new Promise((done) => {
    const stamps = [];
    const tick = (now) => (stamps.push(now), stamps.length < 91 ? requestAnimationFrame(tick) : done(stamps));
    requestAnimationFrame(tick);
  }));
  const rate = (1000 * (frames.length - 1)) / (frames[frames.length - 1] - frames[0]);
  t.diagnostic(`${rate.toFixed(1)} frames/s while animating`);
  if (strict) assert.ok(rate > 50);
});

test("quick enough: slider and map", async (t) => {
  const page = await open(t);
  await mapDone(page);
  const times = [];
  for (let i = 0; i < (strict ? 3 : 1); i++) {
    await page.click("#zoom-in");
    await page.waitForFunction(() => document.getElementById("map").dataset.ms === undefined);
    await mapDone(page);
    await page.click("#zoom-all");
    await page.waitForFunction(() => document.getElementById("map").dataset.ms === undefined);
    await mapDone(page);
    times.push(await page.evaluate(() => [Number(document.getElementById("map").dataset.ms), Number(document.getElementById("map").dataset.computing)]));
  }
  const best = Math.min(...times.map((x) => x[0]));
  t.diagnostic(`400 × 400 map: ${times.map(([a, b]) => `${a} ms (workers ${b} ms)`).join(", ")}; ${await page.evaluate(() => navigator.hardwareConcurrency)} cores`);
  const redraw = await page.evaluate(async () => {
    const slider = document.getElementById("restitution");
    const took = [];
    for (let i = 0; i < 40; i++) {
      performance.clearMeasures();
      slider.value = String(300 + 10 * i);
      const begin = performance.now();
      slider.dispatchEvent(new Event("input"));
      await new Promise((done) => requestAnimationFrame(() => setTimeout(done, 0)));
      took.push(performance.now() - begin);
    }
    return took.sort((a, b) => a - b);
  });
  t.diagnostic(`slider to redrawn plots: median ${redraw[20].toFixed(1)} ms, worst of 40 ${redraw[39].toFixed(1)} ms`);
  if (strict) {
    assert.ok(best < 1000);
    assert.ok(redraw[36] < 50);
  }
});

test("the viscoelastic map is complete, and quick too", async (t) => {
  const page = await open(t, "?example=basketball");
  await mapDone(page);
  await page.check("#law-viscoelastic");
  await page.waitForFunction(() => document.getElementById("map").dataset.ms === undefined);
  await mapDone(page);
  const map = await page.evaluate(() => ({ ...document.getElementById("map").dataset }));
  t.diagnostic(`400 × 400 viscoelastic map: ${map.ms} ms (workers ${map.computing} ms)`);
  assert.equal(map.resolution, "400");
  if (strict) assert.ok(Number(map.ms) < 4000);
});

// Durations of the long tasks of the page, those of 50 ms or more, while `act` is carried out [ms].
async function longTasks(page, act) {
  await page.evaluate(() => {
    globalThis.tasks = [];
    globalThis.observer ??= new PerformanceObserver((list) => list.getEntries().forEach((e) => globalThis.tasks.push(Math.round(e.duration))));
    globalThis.observer.observe({ type: "longtask" });
  });
  await act();
  return page.evaluate(() => (globalThis.observer.disconnect(), globalThis.tasks));
}

const idle = (page) => page.waitForFunction(() => document.documentElement.dataset.busy === undefined && document.documentElement.dataset.numbers);

test("no long task while a worker computes", async (t) => {
  const page = await open(t);
  await mapDone(page);
  const tasks = await longTasks(page, async () => {
    await goTo(page, long);
    await page.waitForSelector("#busy:not([hidden])");
    const said = await page.textContent("#busy-what");
    await page.waitForFunction((said) => document.getElementById("busy-what").textContent !== said, said);
    await page.click("#give-up");
    await idle(page);
  });
  t.diagnostic(`long tasks: ${tasks.join(", ") || "none"} ms`);
  if (strict) assert.deepEqual(tasks, []);
});

test("no long task when the controls of six balls are built", async (t) => {
  const page = await open(t);
  await mapDone(page);
  const six = "?example=astro&r=0.027,0.022,0.019,0.016,0.0135,0.009&gap=5e-5,5e-5,5e-5,5e-5,5e-5";
  const tasks = [];
  for (let i = 0; i < 3; i++)
    for (const query of [six, "?example=fig2"])
      tasks.push(...(await longTasks(page, async () => {
        await forget(page);
        await goTo(page, query);
        await idle(page);
        await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
      })));
  t.diagnostic(`long tasks: ${tasks.join(", ") || "none"} ms`);
  if (strict) assert.deepEqual(tasks, []);
});
