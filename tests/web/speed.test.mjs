// Speed of the page in Chromium; ci.sh runs this file after the others. TIMES=off prints times without limits, for a
// busy machine. Except for the first picture, limits are on the processor time of the page's thread and of its workers,
// because on few cores these wait for each other and for the browser.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { answerInPart, frames, goTo, mapDone, newMap, rest, Site, visit } from "./browser.mjs";
import { long } from "./scenarios.mjs";

const strict = process.env.TIMES !== "off";
const mostBusy = 50; // longest task of the page that is not noticeable [ms of processor time]
const mostEach = 1000 / 60 / 1.5; // ms of processor time for a frame
let site;
before(async () => void (site = await Site.begin()));
after(() => site?.end());
const open = (t, query = "?example=fig2", options = {}) => site.open(t, query, { maps: strict, ...options });
const often = (count) => (strict ? count : Math.ceil(count / 10)); // without limits, a tenth shows that it works

// Processor times during `act` [ms]: of each task of the page's thread, in descending order, and of all workers
// together.
async function costOf(page, act) {
  await site.browser.startTracing(page, { categories: ["disabled-by-default-devtools.timeline"] });
  await act();
  const { traceEvents: events } = JSON.parse(String(await site.browser.stopTracing()));
  const thread = ({ pid, tid }) => `${pid} ${tid}`;
  const times = (name) => {
    const threads = new Set(events.filter((e) => e.name === "thread_name" && e.args.name.startsWith(name)).map(thread));
    return events
      .filter((e) => e.name === "RunTask" && e.tdur !== undefined && threads.has(thread(e)))
      .map((e) => e.tdur / 1000);
  };
  const tasks = times("CrRendererMain").sort((x, y) => y - x);
  assert.ok(tasks.length > 0, "tasks are seen");
  return { tasks, page: total(tasks), workers: total(times("DedicatedWorker")) };
}
const total = (times) => times.reduce((sum, x) => sum + x, 0);
const longest = (tasks) => `longest task ${tasks[0].toFixed(1)} ms of processor time`;

test("the first picture", async (t) => {
  const page = await open(t);
  const first = Number(await page.evaluate(() => document.documentElement.dataset.ready));
  t.diagnostic(`first picture after ${first} ms`);
  if (strict) assert.ok(first < 1000);
});

for (const [name, query] of [
  ["the film", "?example=fig2"],
  ["the second chapter's film", "?story=watch&example=fig2"],
])
  test(name, async (t) => {
    const page = await open(t, query, { reducedMotion: "no-preference" });
    await page.waitForFunction(() =>
      ["speed", "watch-speed"].some((id) => /× slower/.test(document.getElementById(id).textContent)),
    );
    let stamps = [];
    const cost = await costOf(
      page,
      async () =>
        void (stamps = await page.evaluate(
          (count) =>
            new Promise((done) => {
              const stamps = [];
              const tick = (now) => (
                stamps.push(now),
                stamps.length <= count ? requestAnimationFrame(tick) : done(stamps)
              );
              requestAnimationFrame(tick);
            }),
          often(90),
        )),
    );
    const rate = (1000 * (stamps.length - 1)) / (stamps[stamps.length - 1] - stamps[0]);
    const each = cost.page / (stamps.length - 1);
    t.diagnostic(`${rate.toFixed(1)} frames/s while animating; ${each.toFixed(1)} ms of processor time each`);
    if (strict) assert.ok(each < mostEach);
  });

test("the gas: 500 disks in both worlds", async (t) => {
  const ready = (page) => page.waitForFunction(() => window.hardlimit?.report()?.samples.length > 60);
  const page = await open(t, "gas.html?n=500", { ready, reducedMotion: "no-preference" });
  const wanted = often(180);
  let seconds = 0;
  const cost = await costOf(
    page,
    async () =>
      void (seconds = await page.evaluate(async (wanted) => {
        const [before, begin] = [window.hardlimit.report().samples.length, performance.now()];
        while (window.hardlimit.report().samples.length < before + wanted)
          await new Promise((done) => setTimeout(done, 50));
        return (performance.now() - begin) / 1000;
      }, wanted)),
  );
  const [onPage, inWorker] = [cost.page / wanted, cost.workers / wanted];
  t.diagnostic(
    `${(wanted / seconds).toFixed(1)} frames/s; each ${onPage.toFixed(1)} ms of processor time on the page, ` +
      `${inWorker.toFixed(1)} ms in the worker; ${longest(cost.tasks)}`,
  );
  if (strict) assert.ok(onPage < mostEach && inWorker < 1000 / 60 && cost.tasks[0] < mostBusy);
});

test("quick enough: slider and map", async (t) => {
  const page = await open(t, "?example=fig2", { maps: true });
  await mapDone(page);
  const change = (button) => newMap(page, () => page.click(button));
  await change("#zoom-in");
  const whole = await costOf(page, () => change("#zoom-all"));
  const [ms, cores] = await page.evaluate(() => [
    document.getElementById("map").dataset.ms,
    navigator.hardwareConcurrency,
  ]);
  t.diagnostic(`400 × 400 map: ${ms} ms, workers ${whole.workers.toFixed(0)} ms of processor time; ${cores} cores`);
  let redraw = [];
  const { tasks, page: all } = await costOf(
    page,
    async () =>
      void (redraw = await page.evaluate(async (count) => {
        const slider = document.getElementById("restitution");
        const took = [];
        for (let i = 0; i < count; i++) {
          slider.value = String(300 + 10 * i);
          const begin = performance.now();
          slider.dispatchEvent(new Event("input"));
          await new Promise((done) => requestAnimationFrame(() => setTimeout(done, 0)));
          took.push(performance.now() - begin);
        }
        return took.sort((a, b) => a - b);
      }, often(40))),
  );
  const each = all / redraw.length;
  t.diagnostic(
    `slider to redrawn plots: median ${redraw[redraw.length >> 1].toFixed(1)} ms, worst of ${redraw.length} ` +
      `${redraw.at(-1).toFixed(1)} ms; ` +
      `${each.toFixed(1)} ms of processor time each, ${longest(tasks)}`,
  );
  if (strict) {
    assert.ok(whole.workers < 3000);
    assert.ok(each < mostBusy && tasks[0] < mostBusy);
  }
});

test("the slider of the second chapter", async (t) => {
  const page = await open(t, "?story=watch");
  const steps = often(60);
  const cost = await costOf(page, () =>
    page.evaluate(async (steps) => {
      const slider = document.getElementById("watch-gap");
      for (let i = 0; i < steps; i++) {
        slider.value = String(300 + 5 * i);
        slider.dispatchEvent(new Event("input"));
        await new Promise((done) => requestAnimationFrame(done));
      }
    }, steps),
  );
  t.diagnostic(`a step: ${(cost.page / steps).toFixed(1)} ms of processor time on the page; ${longest(cost.tasks)}`);
  if (strict) assert.ok(cost.page / steps < 1000 / 60 && cost.tasks[0] < mostBusy);
});

test("the viscoelastic map is complete, and quick too", async (t) => {
  const page = await open(t, "?example=basketball", { maps: true });
  await mapDone(page);
  const { workers } = await costOf(page, () => newMap(page, () => page.check("#law-viscoelastic")));
  const map = await page.evaluate(() => ({ ...document.getElementById("map").dataset }));
  t.diagnostic(`400 × 400 viscoelastic map: ${map.ms} ms, workers ${workers.toFixed(0)} ms of processor time`);
  // Where it would take too long, the finest level is omitted.
  if (strict) assert.ok(map.resolution === "400" && workers < 8000, `${map.resolution}, ${workers} ms`);
});

test("no task holds the page up while a worker computes", async (t) => {
  const page = await open(t);
  await mapDone(page);
  await answerInPart(page); // so that it is not over before it is given up
  const { tasks } = await costOf(page, async () => {
    await goTo(page, long);
    await page.waitForSelector("#busy:not([hidden])");
    const said = await page.textContent("#busy-what");
    await page.waitForFunction((said) => document.getElementById("busy-what").textContent !== said, said);
    await page.click("#give-up");
    await rest(page);
  });
  t.diagnostic(longest(tasks));
  if (strict) assert.ok(tasks[0] < mostBusy);
});

test("no task holds the page up when the controls of six balls are built", async (t) => {
  const page = await open(t);
  await mapDone(page);
  const six = "?example=astro&r=0.027,0.022,0.019,0.016,0.0135,0.009&gap=5e-5,5e-5,5e-5,5e-5,5e-5";
  const tasks = [];
  for (let i = 0; i < often(3); i++)
    for (const query of [six, "?example=fig2"])
      tasks.push(
        (
          await costOf(page, async () => {
            await visit(page, query);
            await frames(page);
          })
        ).tasks[0],
      );
  tasks.sort((x, y) => y - x);
  t.diagnostic(longest(tasks));
  if (strict) assert.ok(tasks[0] < mostBusy);
});
