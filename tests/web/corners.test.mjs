// Unusual use, in Chromium: touch, history, invalid links, long computations, rejected entries.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import {
  answerInPart,
  download,
  goTo,
  linked,
  mapDrawn,
  numbers,
  phone,
  rest,
  settled,
  Site,
  solved,
  visit,
} from "./browser.mjs";
import { load, random, randomLink } from "./modules.mjs";
import { long } from "./scenarios.mjs";

let site;
before(async () => void (site = await Site.begin()));
after(() => site?.end());

async function open(t, query = "", options = {}) {
  const page = await site.open(t, query, options);
  await rest(page);
  return page;
}
const zoomOf = async (page) => (await linked(page)).searchParams.get("zoom");

// ---- film and headline --------------------------------------------------------------------------------------

for (const query of [
  "?example=astro&t=0.2",
  "?example=fig6&t=0.2",
  "?example=astro&r=0.027,0.019,0.001,0.009&t=0.1",
  "?example=fig2&r=0.05,0.01,0.05&t=0.1",
])
  test(`the film goes on where independent collisions accumulate: ${query}`, async (t) => {
    const page = await open(t, query);
    assert.equal(await page.isVisible("#notes"), false, await page.textContent("#notes"));
    assert.match(await page.textContent("#time"), /0\.[12]00 s/);
    await page.focus("#scrubber");
    await page.keyboard.press("End");
    const { bytes } = await download(page, "#csv");
    assert.ok(Number(String(bytes).trim().split("\n").at(-1).split(",")[0]) >= 0.1);
  });

test("heights: collisions still to come count, later ones are told apart", async (t) => {
  const page = await open(t, "?example=astro&gap=0,5e-5,5e-5");
  assert.match(await page.textContent("#verdict"), /7\.42 m/);
  await visit(page, "?example=fig2");
  assert.match(await page.textContent("#verdict"), /rises to 0\.484 m/);
  assert.match(await page.textContent("tr[data-id=later]"), /later.*68\.0 cm/);
  assert.match(
    await page.textContent("#definitions"),
    /greatest height of its centre above the floor after its first bounce/,
  );
  await page.click("#definitions summary");
  assert.match(await page.textContent("#definitions dl"), /restitution that would give/);
});

// Results of settings are tested in settings.test.mjs, their pictures in drawing.test.mjs.
test("random settings, one after the other, in one page", async (t) => {
  const { core, solve, paper, fromQuery, exactNumbers } = await load();
  const page = await open(t, "?example=fig2");
  const next = random(7);
  for (let i = 0; i < 6; i++) {
    const q = randomLink(next);
    const scenario = paper();
    fromQuery(scenario, q, []);
    await visit(page, `?example=fig2&${q}`);
    assert.deepEqual(await numbers(page), exactNumbers(solve(core, scenario)), q.toString());
  }
});

// ---- touch --------------------------------------------------------------------------------------------------

// Waits until nothing scrolls any more.
const still = (page) =>
  page.evaluate(
    () =>
      new Promise((done) => {
        let [last, count] = [NaN, 0];
        const tick = () => {
          count = scrollY === last ? count + 1 : 0;
          last = scrollY;
          if (count < 10) requestAnimationFrame(tick);
          else done();
        };
        tick();
      }),
  );

test("a swipe scrolls and changes nothing", async (t) => {
  const page = await open(t, "?example=fig2", phone);
  const session = await page.context().newCDPSession(page);
  const before = await numbers(page);
  for (const id of ["restitution", "scrubber", "forces", "timeline", "map"]) {
    const element = page.locator(`#${id}`);
    await element.evaluate((e) => e.scrollIntoView({ block: "center" }));
    await still(page);
    const box = await element.boundingBox();
    const from = await page.evaluate(() => scrollY);
    const time = await page.textContent("#time");
    const up = from > 400; // the last pictures are at the end of the page
    const [x, y] = [box.x + 0.3 * box.width, box.y + 0.5 * box.height];
    await session.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints: [{ x, y }] });
    for (let k = 1; k <= 10; k++)
      await session.send("Input.dispatchTouchEvent", {
        type: "touchMove",
        touchPoints: [{ x, y: y + (up ? 15 : -15) * k }],
      });
    await session.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
    await page.waitForFunction((from) => scrollY !== from, from);
    await settled(page);
    assert.deepEqual(await numbers(page), before, id);
    assert.equal(await page.textContent("#time"), time, id);
  }
});

// Moves one or two fingers along positions in an element, which are fractions of its box.
async function fingers(page, id, ...path) {
  const session = await page.context().newCDPSession(page);
  const box = await page.locator(`#${id}`).boundingBox();
  const points = (step) => step.map(([x, y], k) => ({ x: box.x + x * box.width, y: box.y + y * box.height, id: k }));
  for (const [i, step] of path.entries())
    await session.send("Input.dispatchTouchEvent", {
      type: i === 0 ? "touchStart" : "touchMove",
      touchPoints: points(step),
    });
  await session.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
  await settled(page);
}

test("after a tap fingers drag the timeline, and move and pinch the map", async (t) => {
  const page = await open(t, "?example=fig2", { maps: true, ...phone });
  const epsilon = async () => Number(await page.inputValue("#restitution-value"));
  await page.locator("#timeline").evaluate((e) => e.scrollIntoView({ block: "center" }));
  await page.waitForSelector("#timeline[data-computed=true]");
  await page.locator("#timeline").tap({ position: { x: 200, y: 150 } });
  await settled(page);
  const tapped = await epsilon();
  await fingers(page, "timeline", [[0.5, 0.4]], [[0.5, 0.5]], [[0.5, 0.6]], [[0.5, 0.7]]);
  assert.ok((await epsilon()) < tapped - 0.1, `${await epsilon()} after ${tapped}`);
  await page.locator("#map").evaluate((e) => e.scrollIntoView({ block: "center" }));
  await mapDrawn(page);
  await page.locator("#map").tap({ position: { x: 200, y: 150 } });
  await settled(page);
  const chosen = await numbers(page);
  await fingers(
    page,
    "map",
    [
      [0.45, 0.5],
      [0.55, 0.5],
    ],
    [
      [0.4, 0.5],
      [0.6, 0.5],
    ],
    [
      [0.3, 0.5],
      [0.7, 0.5],
    ],
  );
  const limits = async () => (await zoomOf(page)).split(",").map(Number);
  const [x0, x1] = await limits();
  assert.ok(x1 - x0 < 0.6, "pinched");
  await fingers(page, "map", [[0.5, 0.5]], [[0.45, 0.5]], [[0.35, 0.5]]);
  assert.ok((await limits())[0] > x0);
  assert.deepEqual(await numbers(page), chosen, "moving the map chooses nothing");
});

// ---- long computations --------------------------------------------------------------------------------------

test("a long computation shows its progress and is given up", async (t) => {
  const page = await open(t, "?example=fig2");
  const before = await numbers(page);
  await answerInPart(page); // so that it is not over before it is given up
  await goTo(page, long);
  await page.waitForSelector("#busy:not([hidden])");
  const said = await page.textContent("#busy-what");
  assert.match(said, /^Computing .*: \d+\.\d s$/);
  for (const told of [said, "next"]) {
    const last = told === "next" ? await page.textContent("#busy-what") : told;
    await page.waitForFunction(
      (last) =>
        document.documentElement.dataset.busy !== undefined &&
        document.getElementById("busy-what").textContent !== last,
      last,
    );
  }
  await page.click("#give-up");
  await settled(page);
  assert.equal(await page.isVisible("#busy"), false);
  assert.equal(await page.inputValue("#restitution-value"), "0.7");
  assert.deepEqual(await numbers(page), before);
});

const enter = async (page, id, value) => {
  await page.fill(`#${id}-value`, value);
  await page.press(`#${id}-value`, "Enter");
};

test("given up: the page says again what it said, and undo goes back from there", async (t) => {
  const page = await open(t, "?example=fig2");
  const said = () =>
    page.evaluate(() => [
      document.getElementById("verdict").textContent,
      document.getElementById("numbers").textContent,
      document.getElementById("answer").textContent,
    ]);
  const before = await said();
  await answerInPart(page);
  await page.evaluate(() => {
    for (const [id, value] of [
      ["tolerance", "0.1"],
      ["restitution-value", "0.5"],
    ]) {
      const field = document.getElementById(id);
      field.value = value;
      field.dispatchEvent(new Event("change"));
    }
  });
  await page.waitForFunction(() => /still being computed/.test(document.getElementById("verdict").textContent));
  await page.click("#give-up");
  await settled(page);
  assert.deepEqual(await said(), before);
  const { current, tolerance } = await page.evaluate(() => window.hardlimit.report());
  assert.deepEqual([current, tolerance, await page.inputValue("#tolerance")], [true, 0.01, "0.01"]);
  assert.equal(await page.isDisabled("#undo"), true); // the cancelled setting is not in the list
  await enter(page, "restitution", "0.6");
  await settled(page);
  await page.click("#undo");
  await settled(page);
  assert.equal(await page.inputValue("#restitution-value"), "0.7");
});

test("a part of an answer gives way to a larger one", async (t) => {
  const page = await open(t, "?example=fig2");
  await answerInPart(page);
  await goTo(page, "?law=viscoelastic&e=0.5&r=0.05,0.04,0.03,0.02,0.01,0.008&gap=1e-5,1e-5,1e-5,1e-5,1e-5");
  await page.waitForFunction(
    () => window.hardlimit.report().setting.balls.length === 6 && document.getElementById("answer").textContent !== "",
  );
  await page.waitForSelector("#busy:not([hidden])");
});

test("undo after the browser's Back goes to the setting that Back has shown", async (t) => {
  const page = await open(t, "?example=fig2");
  await page.selectOption("#preset", "fig5");
  await settled(page);
  await page.goBack();
  await page.waitForFunction(() => document.getElementById("preset").value === "fig2");
  assert.equal(await page.isDisabled("#undo"), true);
  await enter(page, "restitution", "0.5");
  await settled(page);
  await page.click("#undo");
  await settled(page);
  assert.equal(await page.inputValue("#preset"), "fig2");
});

test("maps of several balls say how far they are, and how long they took", async (t) => {
  const page = await open(t, "?example=astro", { maps: true });
  await page.evaluate(
    () =>
      new Promise((done) => {
        const state = document.getElementById("map-state");
        new MutationObserver(() => /\d+ % computed/.test(state.textContent) && done()).observe(state, {
          characterData: true,
          childList: true,
          subtree: true,
        });
        document.getElementById("zoom-in").click();
      }),
  );
  await page.waitForFunction(() => /points in [\d.]+ s/.test(document.getElementById("map-state").textContent));
});

// ---- map, history, entries ----------------------------------------------------------------------------------

test("the map: its reading is the point's, the wheel zooms and a drag moves without choosing", async (t) => {
  const page = await open(t, "?example=fig2&map=gap&show=effective", { maps: true });
  assert.doesNotMatch(await page.locator(".hint:has(#map-reading)").innerText(), /^·/);
  await page.locator("#map").scrollIntoViewIfNeeded();
  await mapDrawn(page);
  const box = await page.locator("#map").boundingBox();
  const at = [box.x + 0.62 * box.width, box.y + 0.47 * box.height];
  const before = await numbers(page);
  await page.mouse.move(...at);
  await page.waitForFunction(() => /contact/.test(document.getElementById("map-reading").textContent));
  await page.keyboard.down("Control");
  await page.mouse.wheel(0, -300);
  await page.keyboard.up("Control");
  await page.waitForFunction(() => new URL(location.href).searchParams.has("zoom"));
  const zoom = await zoomOf(page);
  await page.mouse.down();
  await page.mouse.move(at[0] + 60, at[1] + 20, { steps: 6 });
  await page.mouse.up();
  assert.notEqual(await zoomOf(page), zoom);
  assert.deepEqual(await numbers(page), before);
  await page.mouse.move(...at);
  const read = async () =>
    (
      await page.waitForFunction(() => /.*contact.*/.exec(document.getElementById("map-reading").textContent)?.[0])
    ).jsonValue();
  const reading = await read();
  await page.mouse.click(...at);
  await settled(page);
  assert.equal(await read(), reading, "hovering and chosen");
  const [, contacts, ratio] = /: (\d+) contacts?, ε_?eff\/ε = (\S+)/.exec(reading.replaceAll("_", ""));
  assert.equal(await page.textContent("tr[data-id=contacts] td:nth-child(2)"), contacts);
  assert.equal(await page.textContent("tr[data-id=ratio] td:nth-child(2)"), ratio);
});

test("examples enter the history", async (t) => {
  const page = await open(t, "?example=fig2");
  await page.selectOption("#preset", "steel");
  await settled(page);
  const steel = await numbers(page);
  await page.selectOption("#preset", "fig5");
  await settled(page);
  await page.goBack();
  await page.waitForFunction(() => document.getElementById("preset").value === "steel");
  await settled(page);
  assert.deepEqual(await numbers(page), steel);
  await page.goBack();
  await page.waitForFunction(() => document.getElementById("preset").value === "fig2");
});

test("the menu closes, and the focus stays in sight", async (t) => {
  const page = await open(t, "?e=7&a.example=fig2");
  const focused = () =>
    page.evaluate(
      () => document.activeElement.closest(".menu summary, #panel-choice")?.textContent ?? document.activeElement.id,
    );
  const isOpen = () => page.evaluate(() => document.getElementById("menu").open);
  await page.click("#notes button");
  assert.equal(await focused(), "Menu");
  await page.keyboard.press("Enter");
  assert.equal(await isOpen(), true);
  await page.keyboard.press("Tab");
  await page.keyboard.press("Escape");
  assert.deepEqual([await isOpen(), await focused()], [false, "Menu"]);
  await page.keyboard.press("Enter");
  await page.click("#verdict");
  assert.equal(await isOpen(), false);
  await page.focus("#unpin");
  await page.keyboard.press("Enter");
  assert.equal(await focused(), "Menu");
  await enter(page, "restitution", "0.5");
  await settled(page);
  await page.focus("#undo");
  await page.keyboard.press("Enter");
  assert.deepEqual([await page.isDisabled("#undo"), await focused()], [true, "Menu"]);
});

test("an example is known again from its link", async (t) => {
  const page = await open(t, "?example=fig4");
  assert.equal(await page.inputValue("#preset"), "fig4");
  await page.waitForFunction(() => new URL(location.href).searchParams.has("map"));
  await page.reload();
  await solved(page);
  assert.equal(await page.inputValue("#preset"), "fig4");
});

test("entries: what is made of them is said; a plus sign in a link is one", async (t) => {
  const page = await open(t, "?example=fig2&k=4e+07");
  assert.equal(await page.isVisible("#notes"), false);
  assert.equal(await page.inputValue("#stiffness-value"), "40 MN/m");
  await page.fill("#height-value", "120");
  await page.keyboard.press("Tab");
  await settled(page);
  assert.match(await page.textContent(".correction"), /120 m is outside 1 cm … 10 m: 10 m used/);
  await page.fill("#mass1-value", "5 furlongs");
  await page.keyboard.press("Tab");
  assert.match(await page.textContent(".correction"), /^Mass m₁: “5 furlongs” is not a value in kg; 3\.519 kg stays$/);
  assert.equal(await page.getAttribute("#mass1-value", "aria-invalid"), "true");
  assert.match(await page.textContent("#controls"), /Density 840 kg\/m³: stays when R₁ changes, so m₁ follows/);
});

test("a screen reader hears the present ε of the timeline while that is out of the window", async (t) => {
  const page = await open(t, "?example=fig2", phone);
  for (const [example, restitution] of [
    ["fig5", "0.9"],
    ["fig6", "0.8"],
  ]) {
    await page.selectOption("#preset", example);
    await settled(page);
    assert.equal(await page.getAttribute("#timeline", "aria-valuenow"), restitution);
  }
});

test("Space plays from a slider, the theme stays, nothing announces each frame, 320 pixels are enough", async (t) => {
  const page = await open(t, "?example=fig2");
  await page.focus("#restitution");
  await page.keyboard.press("Space");
  assert.equal(await page.textContent("#play"), "Pause");
  await page.keyboard.press("Space");
  assert.equal(await page.textContent("#play"), "Play");
  assert.equal(await page.locator("#time[aria-live], output#time, output#speed, output#map-reading").count(), 0);
  await page.click("#theme");
  const theme = await page.getAttribute("html", "data-theme");
  await page.reload();
  await solved(page);
  assert.equal(await page.getAttribute("html", "data-theme"), theme);
  await page.setViewportSize({ width: 320, height: 640 });
  for (const query of ["?example=fig2", "?example=astro", "?example=cradle"]) {
    await visit(page, query);
    assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 320, query);
  }
});

test("at 2560 pixels text and pictures grow with the page", async (t) => {
  const page = await open(t, "?example=fig2", { viewport: { width: 2560, height: 1400 } });
  const [font, main] = await page.evaluate(() => [
    parseFloat(getComputedStyle(document.documentElement).fontSize),
    document.querySelector("main").clientWidth,
  ]);
  assert.ok(font > 24 && main > 2400, `${font} px, ${main} px`);
});
