// The page in a second engine: Firefox shows the same as Chromium, and keys, drawings and links work.
// FIREFOX: the browser.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { accessible, drawn, linked, mapDone, mapDrawn, rest, settled, shoot, Site, visit } from "./browser.mjs";
import { random, randomLink } from "./modules.mjs";

let firefox;
let chromium;
before(async () => void ([chromium, firefox] = await Promise.all([Site.begin(), Site.begin("firefox")])));
after(() => Promise.all([firefox?.end(), chromium?.end()]));

// All texts and numbers of the page for a setting.
async function said(page, query) {
  await visit(page, query);
  return page.evaluate(() => ({
    ...JSON.parse(document.documentElement.dataset.numbers),
    ...Object.fromEntries(
      ["verdict", "why", "numbers", "energy", "notes"].map((id) => [id, document.getElementById(id).textContent]),
    ),
  }));
}

test("every example and random settings: Firefox says what Chromium says", async (t) => {
  const pages = await Promise.all([firefox.open(t), chromium.open(t)]);
  const examples = await pages[0].$$eval("#preset option", (list) => list.map((x) => x.value).filter(Boolean));
  assert.ok(examples.length >= 10);
  const next = random(99);
  const queries = [
    ...examples.map((id) => `?example=${id}`),
    ...Array.from({ length: 8 }, () => `?${randomLink(next)}`),
  ];
  for (const query of queries) {
    // This panel has no plots.
    const [first, second] = await Promise.all(pages.map((page) => said(page, `${query}&panel=numbers`)));
    assert.deepEqual(first, second, query);
  }
});

test("the story is scrolled with the keys, and its pictures are drawn", async (t) => {
  const page = await firefox.open(t, "?page=story", { maps: true });
  for (const step of ["predict", "watch", "slow", "count", "gap", "map"]) {
    await page.evaluate((step) => document.querySelector(`.chapter[data-step="${step}"]`).scrollIntoView(), step);
    await page.waitForFunction(
      (step) => document.querySelector("#chapters [aria-current]").dataset.step === step,
      step,
    );
    await page.waitForFunction(
      (step) => document.querySelector(`.chapter[data-step="${step}"] .text`).textContent !== "",
      step,
    );
    if (step === "gap") await page.waitForFunction(() => document.getElementById("rebound").dataset.done === "true");
    if (step === "map") await mapDone(page);
    for (const id of await page.$$eval(`.chapter[data-step="${step}"] canvas`, (list) => list.map((x) => x.id))) {
      await page.locator(`#${id}`).scrollIntoViewIfNeeded();
      await drawn(page, id, 10);
    }
    await shoot(page, `firefox-${step}`);
  }
  await accessible(page, "the story");
  await page.keyboard.press("Home");
  await page.waitForFunction(
    () =>
      scrollY === 0 && window.hardlimit.report().step === "predict" && window.hardlimit.report().setting.gaps[0] === 0,
  );
  await page.focus("#duel-box .handle[aria-label^=Gap]");
  await page.keyboard.press("ArrowUp");
  await page.waitForFunction(() => window.hardlimit.report().current && window.hardlimit.report().setting.gaps[0] > 0);
  await page.click("#leave");
  await page.waitForFunction(() => new URL(location.href).searchParams.get("page") === "lab");
});

test("controls, keys and map; the link gives the same page again", async (t) => {
  const page = await firefox.open(t, "?example=fig2", { maps: true });
  await page.focus("#gap1-value");
  await page.keyboard.press("Control+A");
  await page.keyboard.type("0.25 mm");
  await page.keyboard.press("Tab");
  await page.focus("#restitution");
  await page.keyboard.press("ArrowRight");
  await page.selectOption("#map-axis", "ratio");
  await page.selectOption("#map-show", "effective");
  await settled(page);
  await page.focus("#forces");
  await drawn(page, "forces");
  await page.keyboard.press("ArrowRight");
  await page.focus("#map");
  await mapDrawn(page);
  await page.keyboard.press("+");
  await page.waitForFunction(() =>
    ["gap", "e", "map", "show", "zoom", "t"].every((key) => new URLSearchParams(location.search).has(key)),
  );
  const link = await linked(page);
  const look = (p) =>
    p.evaluate(() => [
      document.documentElement.dataset.numbers,
      ...["time", "verdict", "why", "map-reading"].map((id) => document.getElementById(id).textContent),
    ]);
  const second = await firefox.open(t, link.search, { maps: true });
  await rest(second);
  await mapDone(page);
  await mapDone(second);
  assert.deepEqual(await look(second), await look(page));
  await shoot(page, "firefox-page", { fullPage: true });
});
