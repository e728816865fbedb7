// The pages without their server, and on paper.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import {
  address,
  answerInPart,
  forget,
  frames,
  goTo,
  mapDone,
  newMap,
  resize,
  rest,
  shoot,
  Site,
  solved,
  visit,
} from "./browser.mjs";
import { long } from "./scenarios.mjs";

let site;
before(async () => void (site = await Site.begin()));
after(() => site?.end());

// Requests of an offline page, of which there must be none. The browser requests the icon after a new link.
async function offline(page) {
  const requests = [];
  page.on("request", (request) => /^http(?!.*icon.svg)/.test(request.url()) && requests.push(request.url()));
  await page.context().setOffline(true);
  return requests;
}

test("the laboratory works without network once it is loaded", async (t) => {
  const page = await site.open(t, "", { maps: true });
  await mapDone(page); // by now it has loaded all that it needs
  const requests = await offline(page);
  await newMap(page, () => page.selectOption("#map-axis", "ratio"));
  for (const value of ["300", "700"]) {
    await forget(page);
    await page.evaluate(
      (value) => Object.assign(document.getElementById("restitution"), { value }).dispatchEvent(new Event("input")),
      value,
    );
    await rest(page);
  }
  await page.selectOption("#rebound-axis", "e");
  await page.waitForFunction(() => document.getElementById("rebound").dataset.done === "true");
  // A long computation is cancelled; its worker is replaced.
  await page.waitForSelector("#busy", { state: "hidden" }); // of the settings before
  await answerInPart(page);
  await goTo(page, long);
  await page.waitForSelector("#busy:not([hidden])");
  await page.click("#give-up");
  await forget(page);
  await page.evaluate(() =>
    Object.assign(document.getElementById("restitution"), { value: "600" }).dispatchEvent(new Event("input")),
  );
  await rest(page);
  await page.click("#open-story");
  await page.waitForFunction(() => document.documentElement.dataset.mode === "story");
  assert.deepEqual(requests, []);
});

test("the gas works without network once it is loaded", async (t) => {
  // Both workers run.
  const ready = (page) =>
    page.waitForFunction(
      () => window.hardlimit?.report()?.samples.length > 0 && Number(document.documentElement.dataset.starts) > 0,
    );
  const page = await site.open(t, "gas.html?n=150", { ready });
  const requests = await offline(page);
  await page.click("#example-collapse");
  await page.waitForFunction(
    () => window.hardlimit.report()?.setting.restitution < 0.7 && window.hardlimit.report().samples.length > 5,
  );
  assert.deepEqual(requests, []);
});

// Brightness of the background of a canvas, from its corner.
const grounds = (page) =>
  page.evaluate(() =>
    Object.fromEntries(
      [...document.querySelectorAll("canvas")]
        .filter((c) => c.width > 100 && c.getBoundingClientRect().width > 0)
        .map((canvas) => {
          const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
          let [dark, drawn] = [0, 0];
          for (let i = 0; i < data.length; i += 4) {
            if (data[i + 3] > 200) drawn++;
            if (data[i + 3] > 200 && Math.max(data[i], data[i + 1], data[i + 2]) < 40) dark++;
          }
          return [canvas.id, { drawn: drawn / (data.length / 4), dark: dark / Math.max(drawn, 1) }];
        }),
    ),
  );

// Plots out of the window are computed after the last change; the map shows when it is drawn.
const atRest = (page) =>
  page.waitForFunction(
    () => {
      dispatchEvent(new Event("beforeprint"));
      const done = ["timeline", "rebound", "map"].every((id) =>
        ["computed", "done", "ms"].some(
          (key) => !["false", undefined].includes(document.getElementById(id).dataset[key]),
        ),
      );
      dispatchEvent(new Event("afterprint"));
      return done;
    },
    null,
    { polling: 1000 },
  );

const pages = [
  ["story", "?page=story", atRest],
  ["laboratory", "", mapDone],
  [
    "gas",
    "gas.html?n=150&t=0.01",
    async (page) => {
      await page.waitForSelector("html[data-settled]");
      await frames(page);
    },
  ],
];
for (const [name, query, ready] of pages.slice(1))
  test(`${name}: forced colours are those of the pictures too`, async (t) => {
    const page = await site.open(t, query, { ready, colorScheme: "dark", forcedColors: "active" });
    await page.evaluate(() => localStorage.setItem("hardlimit-theme", "light")); // chosen without forced colours
    await page.reload();
    await ready(page);
    const inked = await page.evaluate(() => {
      // pixels of dark's --ink, #eef0f3
      const canvas = document.querySelector("#stage, canvas#energy");
      const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      return new Uint32Array(data.buffer).filter((x) => x === 0xfff3f0ee).length;
    });
    assert.ok(inked > 20, String(inked));
    const colours = await page.$$eval(name === "gas" ? ".key .overlap" : ".bar > div, .legend i", (list) =>
      list.map((x) => getComputedStyle(x).backgroundColor),
    );
    assert.ok(!colours.includes("rgb(0, 0, 0)"), colours.join());
    await page.evaluate(() => document.querySelector("#slow, #example-dense").setAttribute("aria-pressed", "true"));
    assert.equal(await page.$eval("#slow, #example-dense", (x) => getComputedStyle(x).borderTopWidth), "3px");
  });

for (const [name, query, ready] of pages)
  test(`${name}: a dark page is printed light, and is dark again`, async (t) => {
    const page = await site.open(t, query, { ready, maps: true, colorScheme: "dark" });
    const theme = () =>
      page.evaluate(() => [document.documentElement.dataset.theme, getComputedStyle(document.body).color]);
    assert.deepEqual(await theme(), ["dark", "rgb(238, 240, 243)"]);
    await page.evaluate(() => dispatchEvent(new Event("beforeprint")));
    assert.deepEqual((await theme())[0], "light");
    for (const [id, { drawn, dark }] of Object.entries(await grounds(page))) {
      assert.ok(drawn > 0.005, `${id} is empty`);
      assert.ok(id === "map" || dark < 0.4, `${id}: ${dark}`);
    }
    await page.evaluate(() => dispatchEvent(new Event("afterprint")));
    assert.deepEqual(await theme(), ["dark", "rgb(238, 240, 243)"]);
    await page.emulateMedia({ media: "print" });
    await page.waitForFunction(() => document.documentElement.dataset.theme === "light");
    const flat = await page.evaluate(() =>
      [...document.querySelectorAll("canvas")]
        .filter((c) => c.getBoundingClientRect().width > 200 && c.getBoundingClientRect().height < 100)
        .map((c) => c.id),
    );
    assert.deepEqual(flat, [], "pictures without height");
    await shoot(page, `print-${name}`, { fullPage: true });
    await page.emulateMedia({ media: "screen" });
    await page.waitForFunction(() => document.documentElement.dataset.theme === "dark");
  });

for (const query of [
  "?panel=film&example=fig6&t=0.0001",
  "?panel=rebound",
  "?panel=compare&example=fig2&a.example=basketball",
])
  test(`printed whole, without its buttons: ${query}`, async (t) => {
    const page = await site.open(t, query, { viewport: { width: 1280, height: 720 } });
    await page.waitForFunction(
      () => document.getElementById("compare").hidden || document.getElementById("compare").dataset.ready === "true",
    );
    await page.emulateMedia({ media: "print" });
    const faults = await page.evaluate(() => {
      const shown = [...document.querySelectorAll(".panel *, .panel-bar *")].filter(
        (x) => x.checkVisibility() && x.getBoundingClientRect().width > 0,
      );
      const box = (x) => x.getBoundingClientRect();
      const over = (a, b) =>
        !a.contains(b) &&
        !b.contains(a) &&
        Math.min(box(a).bottom, box(b).bottom) - Math.max(box(a).top, box(b).top) > 1 &&
        Math.min(box(a).right, box(b).right) - Math.max(box(a).left, box(b).left) > 1;
      const canvases = shown.filter((x) => x.tagName === "CANVAS");
      return [
        ...shown.filter((x) => x.matches(".panel-bar *, .compare button")),
        ...shown.filter(
          (x) =>
            box(x).right > box(x.closest(".panel") ?? document.body).right + 1 ||
            box(x).bottom > box(x.closest(".panel") ?? document.body).bottom + 1,
        ),
        ...canvases.filter((x) => box(x).height < 90 || shown.some((y) => over(x, y))),
      ].map((x) => `${x.tagName} ${x.id} ${x.textContent.trim().slice(0, 20)}`);
    });
    assert.deepEqual(faults, []);
  });

test("in a low window the laboratory shows first the film and a slider", async (t) => {
  const page = await site.open(t, "", { viewport: { width: 844, height: 390 } });
  for (const [width, height] of [
    [844, 390],
    [640, 360],
  ]) {
    await resize(page, width, height);
    const bottoms = await page.evaluate(() =>
      ["stage", "play", "restitution"].map((id) => document.getElementById(id).getBoundingClientRect().bottom),
    );
    for (const bottom of bottoms) assert.ok(bottom > 0 && bottom <= height, `${width}: ${bottoms}`);
  }
  await page.goto(`${site.base}?page=story`);
  await solved(page);
  const bottom = await page.evaluate(() => document.getElementById("let-go").getBoundingClientRect().bottom);
  assert.ok(bottom <= 360, `the button of the story ends at ${bottom}`);
});

test("tables, sliders and buttons fit into their panels", async (t) => {
  const low = ["480×320", "568×320", "640×360", "667×375", "740×360", "844×390"];
  const sizes = {
    "?example=fig2": low,
    "?example=cradle": ["1280×720", "1440×720", ...low],
    "?example=fig7": ["1280×720"],
    "?example=astro": ["390×720"],
  };
  const page = await site.open(t);
  for (const [query, windows] of Object.entries(sizes)) {
    await visit(page, query);
    for (const size of windows) {
      const [width, height] = size.split("×").map(Number);
      await resize(page, width, height);
      const over = await page.$$eval(".panel :is(table, .track, button, select)", (list) =>
        list
          .filter(
            (x) =>
              x.checkVisibility() &&
              x.getBoundingClientRect().right > x.closest(".panel").getBoundingClientRect().right,
          )
          .map((x) => x.id || x.firstElementChild.id),
      );
      assert.deepEqual(over, [], `${query} in ${size}`);
    }
  }
});

test("story: what the reader has not come to is printed too, each drawing in its place", async (t) => {
  const page = await site.open(t, "?page=story", { maps: true, colorScheme: "dark" });
  const printed = () => {
    dispatchEvent(new Event("beforeprint"));
    const { ms } = document.getElementById("map").dataset;
    const done = [
      ms !== undefined,
      document.getElementById("timeline").dataset.computed,
      document.getElementById("rebound").dataset.done,
    ].join();
    dispatchEvent(new Event("afterprint"));
    return done === "true,true,true";
  };
  await page.waitForFunction(
    () =>
      /^Above the line|^At the/.test(document.querySelectorAll('[data-step="map"] .text')[1].textContent) &&
      /are back\. Let go touching, the tennis ball reaches/.test(
        document.querySelector('[data-step="gap"] .text').textContent,
      ),
  );
  await page.waitForFunction(printed, null, { polling: 500 });
  const { search } = await address(page);
  assert.ok(!/show=|zoom=/.test(search), search);
  await page.emulateMedia({ media: "print" });
  await page.waitForFunction(() => document.documentElement.dataset.theme === "light");
  assert.deepEqual(
    await page.evaluate(() =>
      [...document.querySelectorAll(".keys")]
        .filter((e) => e.getBoundingClientRect().height > 0)
        .map((e) => e.textContent),
    ),
    [],
    "what a click does is not printed",
  );
  const places = await page.evaluate(() =>
    [...document.querySelectorAll(".chapter h2, .chapter .text, .chapter canvas")]
      .map((element) => {
        const { top, bottom, height } = element.getBoundingClientRect();
        return { what: element.id || element.textContent, top, bottom, height };
      })
      .filter(({ height }) => height > 0)
      .sort((a, b) => a.top - b.top),
  );
  assert.equal(places.length, 6 + 11 + 9);
  places.forEach(({ what, top }, i) =>
    assert.ok(i === 0 || top > places[i - 1].bottom - 1, `${what} over ${places[i - 1]?.what}`),
  );
  await page.emulateMedia({ media: "screen" });
  // The laboratory's map is unchanged.
  await page.click("#leave");
  await page.waitForFunction(() => document.documentElement.dataset.mode === undefined);
  assert.equal(await page.inputValue("#map-show"), "count");
});
