// The page in Chromium, from hardlimit's server; its numbers are compared with Python's.
// PYTHON: an interpreter that has hardlimit installed. CHROMIUM: the browser. SHOTS: a folder for screenshots.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import {
  accessible,
  address,
  download,
  drawn,
  linked,
  mapDone,
  mapDrawn,
  numbers,
  phone,
  settled,
  shoot,
  Site,
  solved,
  visit,
} from "./browser.mjs";

const python = process.env.PYTHON ?? "python3";
const shots = process.env.SHOTS;
const work = mkdtempSync(join(tmpdir(), "explorer-"));

let site;
before(async () => void (site = await Site.begin()));
after(async () => {
  await site?.end();
  rmSync(work, { recursive: true, force: true });
});

// The paper's Fig. 2 unless the link names another example.
const open = (t, query = "?example=fig2", options = {}) => site.open(t, query, options);

const picture = (page) =>
  page.evaluate(() => {
    const map = document.getElementById("map");
    return { resolution: Number(map.dataset.resolution), data: map.toDataURL() };
  });

// A map omits its finest level if that would take too long. On a busy machine only the finest maps are compared.
function same(t, maps) {
  const finest = Math.max(...maps.map((m) => m.resolution));
  const compared = maps.filter((m) => m.resolution === finest);
  if (compared.length < maps.length)
    t.diagnostic(`${compared.length} of ${maps.length} maps have ${finest} points a side`);
  assert.ok(
    compared.every((m) => m.data === compared[0].data),
    "the same map",
  );
}

function close(a, b, what, tolerance = 1e-9) {
  if (b === null || Number.isNaN(b)) return assert.equal(a, null, what);
  assert.ok(Math.abs(a - b) <= tolerance * Math.max(Math.abs(b), 1e-3), `${what}: page ${a}, Python ${b}`);
}

// Python's results for the columns in these TOML files.
function fromPython(files) {
  const program = `
import json, math, sys
import hardlimit as hl
from hardlimit.column.files import read
def tidy(x): return None if x is None or (isinstance(x, float) and math.isnan(x)) else x
def said(column):
    out = {}
    for name, solve in (("newton", hl.newton), ("icm", hl.independent)):
        r = solve(column)
        out[name] = {"contacts": int(r.n_contacts), "t_end": tidy(float(r.t_end)), "relative_velocity": tidy(float(r.relative_velocity)),
                     "separation_velocity": tidy(float(r.separation_velocity)), "effective_restitution": tidy(float(r.effective_restitution))}
    return out
print(json.dumps([said(read(path)) for path in sys.argv[1:]]))`;
  return JSON.parse(execFileSync(python, ["-c", program, ...files], { encoding: "utf8" }));
}
async function saved(page, button, name) {
  const path = join(work, name);
  writeFileSync(path, (await download(page, button)).bytes);
  return path;
}

function compare(shown, expected, n, example) {
  for (const model of ["newton", "icm"])
    for (const [key, value] of Object.entries(expected[model])) {
      if (n > 2 && key.includes("velocity")) continue; // not defined for more than two balls
      close(shown[`${model}_${key}`], value, `${example}: ${model} ${key}`, n > 2 || key === "t_end" ? 1e-8 : 1e-9);
    }
}

test("starts with the paper's Fig. 2", async (t) => {
  const page = await open(t);
  const response = await page.request.get(site.base);
  assert.match(response.headers()["content-security-policy"], /default-src 'none'.*frame-ancestors 'none'/);
  const n = await numbers(page);
  assert.equal(n.newton_contacts, 4);
  assert.equal(n.icm_contacts, 1);
  close(n.newton_relative_velocity, 0.171710897878, "v'_r", 1e-9);
  close(n.newton_separation_velocity, 0.125464928, "separation", 1e-8);
  close(n.newton_t_floor_end, 775.172e-6, "end of the floor contact", 1e-5);
  assert.match(await page.textContent("#verdict"), /^Four contacts/);
  assert.equal(await page.textContent("tr[data-id=contacts] td:nth-child(2)"), "4");
});

test("the balls are drawn before any text, from the answer of the worker that has the link", async (t) => {
  const page = await open(t);
  await page.addInitScript(() => {
    Object.assign(window, { drawn: null, requests: [], early: [] });
    const { clearRect } = CanvasRenderingContext2D.prototype;
    CanvasRenderingContext2D.prototype.clearRect = function (...place) {
      window.drawn ??= [
        this.canvas.id,
        document.documentElement.dataset.numbers === undefined,
        this.canvas.width > 300,
      ];
      return clearRect.apply(this, place);
    };
    const { postMessage } = Worker.prototype;
    Worker.prototype.postMessage = function (message, ...more) {
      const list = document.documentElement.dataset.numbers === undefined ? window.early : window.requests;
      if (message.kind === "solve") list.push(message.ask.scenario.restitution);
      return postMessage.call(this, message, ...more);
    };
  });
  for (const [query, canvas, restitution, tolerance] of [
    ["", "prediction", 0.76, 0.01],
    ["?page=lab&e=0.5&tol=0.02", "stage", 0.5, 0.02],
    ["?story=map&example=fig2&e=0.6", "duel", 0.6, 0.01],
  ]) {
    await page.goto(site.base + query);
    await page.waitForFunction(() => document.documentElement.dataset.numbers);
    // Later the story asks for the balls of other chapters.
    const { drawn, early, setting, said } = await page.evaluate(() => ({
      drawn: window.drawn,
      early: window.early,
      setting: window.hardlimit.report().setting,
      said: window.hardlimit.report().tolerance,
    }));
    assert.deepEqual([early, setting.restitution, said], [[], restitution, tolerance], query);
    if (!query.includes("map")) assert.deepEqual(drawn, [canvas, true, true], query);
  }
  await page.evaluate(() => {
    window.requests.length = 0;
    Object.assign(document.getElementById("watch-gap"), { value: "500" }).dispatchEvent(new Event("input"));
  });
  // A change causes a request, so the list above would not be empty.
  await page.waitForFunction(() => window.requests.length > 0);
});

test("numbers of every example are Python's", async (t) => {
  const page = await open(t, "?example=fig2");
  const examples = await page.$$eval("#preset option", (list) => list.map((x) => x.value).filter(Boolean));
  assert.ok(examples.length >= 10);
  const shown = [];
  for (const example of examples) {
    await visit(page, `?example=${example}`);
    const balls = await page.evaluate(() => window.hardlimit.report().setting.balls.length);
    shown.push({
      example,
      balls,
      numbers: await numbers(page),
      file: await saved(page, "#toml", `${example}.toml`),
    });
  }
  const said = fromPython(shown.map(({ file }) => file));
  shown.forEach(({ example, balls, numbers }, i) => compare(numbers, said[i], balls, example));
  const { numbers: last, file } = shown.at(-1);
  const { models } = JSON.parse(
    execFileSync(python, ["-m", "hardlimit", "drop", file, "--json"], { encoding: "utf8" }),
  );
  assert.equal(models.newton.n_contacts, last.newton_contacts, "the file is one for the command line");
});

test("every control moves the result and is in the link", async (t) => {
  const page = await open(t, "?example=fig2");
  for (const setup of ["", "?law=viscoelastic", "?law=tsuji", "?example=astro", "?example=cradle"]) {
    if (setup) await visit(page, setup);
    const ids = await page.$$eval("#controls input[type=range]", (list) => list.map((x) => x.id));
    assert.ok(ids.length >= 7, setup);
    for (const id of ids) {
      const before = await page.inputValue(`#${id}-value`);
      const numbersBefore = JSON.stringify(await numbers(page));
      await page.focus(`#${id}`);
      const up = Number(await page.inputValue(`#${id}`)) < 800;
      if (id.startsWith("velocity"))
        // The balls must still collide.
        for (let i = 0; i < 3; i++) await page.keyboard.press(up ? "ArrowRight" : "ArrowLeft");
      else await page.keyboard.press(up ? "PageUp" : "PageDown");
      await settled(page);
      assert.notEqual(await page.inputValue(`#${id}-value`), before, `${setup} ${id} shows its value`);
      assert.notEqual(JSON.stringify(await numbers(page)), numbersBefore, `${setup} ${id} changes the result`);
    }
  }
  await visit(page, "?example=fig2");
  await page.fill("#gap1-value", "0.25 mm");
  await page.keyboard.press("Tab");
  await page.fill("#restitution-value", "0.82");
  await page.keyboard.press("Tab");
  await page.click("#count-more");
  await page.waitForFunction(() => document.getElementById("count").textContent === "3");
  for (let i = 0; i < 3; i++) await page.click("#count-more");
  await settled(page);
  assert.equal(await page.textContent("#count"), "6");
  for (let i = 0; i < 4; i++) await page.click("#count-less");
  await page.waitForFunction(() => document.getElementById("count").textContent === "2");
  await page.check("#law-viscoelastic");
  await page.waitForSelector("#youngs_modulus");
  await page.fill("#restitution-value", "nonsense");
  await page.keyboard.press("Tab");
  assert.equal(await page.getAttribute("#restitution-value", "aria-invalid"), "true");
  await page.waitForFunction(
    () =>
      location.search.includes("e=0.82") &&
      location.search.includes("gap=0.00025") &&
      location.search.includes("law=viscoelastic"),
  );
});

test("an answer leaves what is being typed, and a refused entry", async (t) => {
  const page = await open(t, "?example=fig2");
  const answer = async (id) => {
    const before = await page.evaluate(() => document.documentElement.dataset.numbers);
    await page.evaluate((id) => {
      const slider = document.getElementById(id);
      slider.value = String(Number(slider.value) - 50);
      slider.dispatchEvent(new Event("input"));
    }, id);
    await page.waitForFunction((before) => document.documentElement.dataset.numbers !== before, before);
    await settled(page);
  };
  await page.fill("#restitution-value", "0.8");
  await answer("gap1");
  assert.equal(await page.inputValue("#restitution-value"), "0.8");
  await page.keyboard.press("Tab");
  await page.waitForFunction(() => location.search.includes("e=0.8"));
  await page.fill("#restitution-value", "nonsense");
  await page.keyboard.press("Tab");
  await page.selectOption("#tolerance", { index: 0 });
  await settled(page);
  assert.equal(await page.getAttribute("#restitution-value", "aria-invalid"), "true");
  await answer("restitution");
  assert.equal(await page.getAttribute("#restitution-value", "aria-invalid"), null);
  assert.notEqual(await page.inputValue("#restitution-value"), "nonsense");
  // Typed again before the answer to the last entry.
  await page.evaluate(() => {
    const field = document.getElementById("restitution-value");
    field.value = "0.8";
    field.dispatchEvent(new Event("change"));
    field.focus();
    field.value = "0.9";
  });
  await settled(page);
  assert.equal(await page.inputValue("#restitution-value"), "0.9");
});

test("a slider follows the mouse to where it is let go, on an example too", async (t) => {
  const page = await open(t);
  await page.locator("#restitution").scrollIntoViewIfNeeded();
  const box = await page.locator("#restitution").boundingBox();
  const at = (share) => [box.x + 8 + share * (box.width - 16), box.y + box.height / 2];
  await page.mouse.move(...at(0.69));
  await page.mouse.down();
  for (let i = 1; i <= 5; i++) {
    await page.mouse.move(...at(0.69 - 0.08 * i));
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  }
  await page.mouse.up();
  await settled(page);
  const value = Number(await page.inputValue("#restitution-value"));
  assert.ok(Math.abs(value - 0.3) < 0.02, `ε = ${value}`);
});

test("after a slider has moved, every text is that of the last answer", async (t) => {
  const page = await open(t, "?example=basketball");
  await page.evaluate(async () => {
    for (const [id, range] of [
      ["restitution", [0.3, 0.9]],
      ["gap1", [0, 0.95]],
    ]) {
      const slider = document.getElementById(id);
      for (let i = 0; i <= 30; i++) {
        slider.value = String(Number(slider.max) * (range[0] + ((range[1] - range[0]) * i) / 30));
        slider.dispatchEvent(new Event("input", { bubbles: true }));
        await new Promise((done) => requestAnimationFrame(done));
      }
    }
  });
  await page.waitForFunction(
    () =>
      document.documentElement.dataset.moving === undefined &&
      document.documentElement.dataset.busy === undefined &&
      window.hardlimit.report().current,
  );
  await settled(page, 30);
  const [written, report] = await page.evaluate(() => {
    const text = (selector) => document.querySelector(selector).textContent.replaceAll("\u00a0", " ");
    const cells = [...document.querySelectorAll("#numbers tbody tr")].map((tr) =>
      [...tr.children].map((cell) => cell.textContent),
    );
    return [
      {
        verdict: text("#verdict"),
        why: text("#why"),
        answer: text("#answer"),
        cells,
        restitution: document.getElementById("restitution-value").value,
      },
      window.hardlimit.report(),
    ];
  });
  const said = (list) => list.map((sentence) => sentence.text).join(" ");
  assert.equal(written.verdict, `${said(report.newton)} ${said(report.icm)}`);
  assert.equal(written.why, said(report.why));
  assert.equal(written.answer, report.verdict.text);
  assert.equal(Number(written.restitution), report.setting.restitution);
  assert.deepEqual(
    written.cells,
    report.table.map((row) => [row.name, ...row.values].map((text) => text.replaceAll("_", ""))),
  );
});

test("a link reproduces the view", async (t) => {
  const page = await open(t, "?example=basketball", { maps: true });
  await page.selectOption("#map-axis", "ratio");
  await page.selectOption("#map-show", "effective");
  await page.click("#zoom-in");
  await page.click("#slow");
  await page.fill("#gap1-value", "1 mm");
  await page.keyboard.press("Tab");
  await settled(page);
  await page.fill("#scrubber", "900");
  const link = await linked(page);
  assert.ok(link.searchParams.has("t"));
  const look = (p) =>
    p.evaluate(() => [
      document.documentElement.dataset.numbers,
      document.getElementById("time").textContent,
      document.getElementById("map-show").value,
      document.getElementById("map-axis").value,
      document.getElementById("slow").ariaPressed,
    ]);
  const other = await open(t, link.search, { maps: true });
  await settled(other);
  assert.deepEqual(await look(other), await look(page));
  await mapDone(page);
  await mapDone(other);
  same(t, [await picture(other), await picture(page)]);
  await page.selectOption("#preset", "fig2");
  await page.waitForFunction(() => !/[?&](e|r|k|h|gap|t)=/.test(location.search));
});

test("the map is the same whichever worker answers first", async (t) => {
  const pictures = [];
  for (const late of [0, 1]) {
    const page = await open(t, "?example=fig2&panel=numbers", { maps: true });
    await page.addInitScript((late) => {
      let created = 0;
      globalThis.Worker = class extends Worker {
        constructor(...options) {
          super(...options);
          if (created++ !== late) return;
          this.addEventListener("message", (event) => {
            if (!event.isTrusted) return;
            event.stopImmediatePropagation();
            setTimeout(() => this.dispatchEvent(new MessageEvent("message", { data: event.data })), 150);
          });
        }
      };
      Object.defineProperty(navigator, "hardwareConcurrency", { value: 2 });
    }, late);
    await page.goto(`${site.base}?example=basketball&panel=map`);
    await mapDone(page);
    pictures.push(await picture(page));
  }
  same(t, pictures);
});

test("bad parameters are clamped and said", async (t) => {
  const page = await open(
    t,
    "?e=7&k=abc&gap=-3&r=1e9,0.01&rho=840,840&h=1e99&law=jelly&zoom=3,2,1&t=x&map=%3Cscript%3E&example=none&n=%00",
  );
  const note = await page.textContent("#notes");
  for (const text of [
    "e = 7",
    "k = “abc”",
    "gap = -3",
    "r = 1000000000",
    "h = 1e+99",
    "jelly",
    "zoom",
    "t = “x”",
    "<script>",
    "none",
  ])
    assert.ok(note.includes(text), `${text} in ${note}`);
  assert.equal(await page.inputValue("#restitution-value"), "1");
  assert.equal(await page.isVisible("#notes"), true);
  assert.ok((await numbers(page)).newton_contacts >= 0);
  await page.click("#notes button");
  assert.equal(await page.isVisible("#notes"), false);
  for (const query of [
    "?r=0.1&e=NaN",
    "?r=" + "0.01,".repeat(50),
    "?gap=&u=1,2&e=0.02",
    "?setup=cradle&u=0,1",
    "?e=0.02&k=1e9&gap=1e-8",
    "?law=viscoelastic&e=0.02&Y=1e12",
    "?law=tsuji&e=0.02&K=1e12",
    "?h=0.01&r=0.5,0.001",
    "?e=1&gap=1&h=10",
    "?t=1e9",
  ]) {
    await visit(page, query);
    assert.notEqual(await page.textContent("#verdict"), "", query);
  }
});

test("a film that stands at its start does so again", async (t) => {
  const page = await open(t, "?example=fig2", { reducedMotion: "no-preference" });
  await page.evaluate(() => document.activeElement.blur());
  await page.keyboard.press("Home");
  await page.waitForFunction(() => new URL(location.href).searchParams.has("t"));
  const time = () => page.evaluate(() => window.hardlimit.report().time);
  const before = await time();
  await page.reload();
  await solved(page);
  assert.equal(await page.textContent("#play"), "Play");
  assert.ok(Math.abs((await time()) - before) < 1e-6);
  assert.equal(await page.isVisible("#notes"), false);
});

test("the story leaves the film as it is: its time, in real time", async (t) => {
  const page = await open(t, "?film=real&t=0.005");
  await page.click("#open-story");
  await page.click("#leave");
  assert.equal(await page.getAttribute("#slow", "aria-pressed"), "false");
  assert.match((await address(page)).search, /film=real&t=0\.005&/);
});

test("film: plays, slows, steps, is tied to the cursor", async (t) => {
  const page = await open(t, "?example=fig2", { reducedMotion: "no-preference" });
  const time = () => page.textContent("#time");
  const early = await time();
  await page.waitForFunction((x) => document.getElementById("time").textContent !== x, early);
  await page.waitForFunction(() => /× slower/.test(document.getElementById("speed").textContent));
  await page.click("#play");
  await settled(page); // the time is written in the next frame
  const pressed = await time();
  await settled(page, 12);
  assert.equal(await time(), pressed);
  await page.click("body", { position: { x: 5, y: 300 } });
  await page.keyboard.press("Home");
  await settled(page);
  const first = await time();
  assert.match(first, /−0\.3\d\d s/);
  await page.keyboard.press("ArrowRight");
  await settled(page);
  assert.notEqual(await time(), first);
  await page.keyboard.press("s");
  assert.equal(await page.getAttribute("#slow", "aria-pressed"), "false");
  const box = await page.locator("#forces").boundingBox();
  await page.locator("#forces").scrollIntoViewIfNeeded();
  await drawn(page, "forces");
  const at = await page.locator("#forces").boundingBox();
  await page.mouse.click(at.x + 0.5 * box.width, at.y + 0.5 * box.height);
  await settled(page);
  assert.match(await time(), /µs/);
  const cursor = await page.locator("#forces-box .cursor").first().boundingBox();
  assert.ok(Math.abs(cursor.x + cursor.width / 2 - (at.x + 0.5 * box.width)) < 3);
});

test("timeline chooses ε, map chooses and zooms", async (t) => {
  const page = await open(t, "?example=fig2", { maps: true });
  await page.locator("#timeline").scrollIntoViewIfNeeded();
  await page.waitForSelector("#timeline[data-computed=true]");
  const line = await page.locator("#timeline").boundingBox();
  await page.mouse.click(line.x + line.width / 2, line.y + line.height * 0.4);
  await settled(page);
  const chosen = Number(await page.inputValue("#restitution-value"));
  assert.ok(chosen > 0.5 && chosen < 0.9 && chosen !== 0.7, String(chosen));
  await page.focus("#timeline");
  await page.keyboard.press("ArrowDown");
  await settled(page);
  assert.ok(Math.abs(Number(await page.inputValue("#restitution-value")) - (chosen - 0.005)) < 1e-6);
  await mapDone(page);
  await page.locator("#map").scrollIntoViewIfNeeded();
  const map = await page.locator("#map").boundingBox();
  await page.mouse.click(map.x + map.width * 0.6, map.y + map.height * 0.5);
  await settled(page);
  const contacts = Number(
    await (
      await page.waitForFunction(() => /: (\d+) contact/.exec(document.getElementById("map-reading").textContent)?.[1])
    ).jsonValue(),
  );
  assert.ok(Math.abs(Number(await page.inputValue("#restitution-value")) - 0.6) < 0.15);
  await page.mouse.move(5, 5);
  await settled(page);
  assert.ok(Math.abs(contacts - (await numbers(page)).newton_contacts) <= 1);
  const zoomed = async (act) => {
    const before = (await linked(page)).searchParams.get("zoom");
    await act();
    await page.waitForFunction((x) => new URLSearchParams(location.search).get("zoom") !== x, before);
  };
  await zoomed(async () => {
    await page.keyboard.down("Shift");
    await page.mouse.move(map.x + map.width * 0.5, map.y + map.height * 0.3);
    await page.mouse.down();
    await page.mouse.move(map.x + map.width * 0.8, map.y + map.height * 0.6, { steps: 5 });
    await page.mouse.up();
    await page.keyboard.up("Shift");
  });
  const [x0, x1] = (await linked(page)).searchParams.get("zoom").split(",").map(Number);
  assert.ok(x0 > 0.3 && x1 < 0.95 && x1 > x0);
  await page.focus("#map");
  await zoomed(() => page.keyboard.press("+"));
  await zoomed(() => page.mouse.wheel(0, 200));
  await zoomed(() => page.click("#zoom-out"));
  await zoomed(() => page.click("#zoom-all"));
  await mapDone(page);
  assert.equal((await linked(page)).searchParams.get("zoom"), null);
  await page.focus("#map");
  const before = await page.inputValue("#gap1-value");
  await page.keyboard.press("ArrowUp");
  await settled(page);
  assert.notEqual(await page.inputValue("#gap1-value"), before);
});

test("exports", async (t) => {
  const page = await open(t, "?e=0.8&gap=3e-4&t=0.0002");
  const png = (await download(page, "#png")).bytes;
  assert.equal(png.subarray(1, 4).toString(), "PNG");
  assert.ok(png.readUInt32BE(16) >= 3000 && png.length > 50_000);
  if (shots) writeFileSync(join(shots, "export.png"), png);
  const csv = String((await download(page, "#csv")).bytes)
    .trim()
    .split("\n");
  const head = csv.findIndex((x) => x.startsWith("time,"));
  assert.ok(csv.slice(0, head).every((x) => x.startsWith("# ")));
  const columns = csv[head].split(",").length;
  assert.ok(csv.length - head > 1000 && csv.slice(head + 1).every((x) => x.split(",").length === columns));
  assert.match(String((await download(page, "#toml")).bytes), /restitution = 0\.8\n/);
});

test("keyboard alone reaches and works everything", async (t) => {
  const page = await open(t, "?example=fig2");
  const reached = new Set();
  for (let i = 0; i < 120; i++) {
    await page.keyboard.press("Tab");
    const [id, ring] = await page.evaluate(() => {
      const at = document.activeElement;
      return [at?.id ?? "", at === document.body || getComputedStyle(at).outlineStyle !== "none"];
    });
    assert.ok(ring, `focus of ${id} is visible`);
    if (id) reached.add(id);
  }
  const wanted = await page.$$eval("button[id], select[id], input[id], canvas[tabindex]", (list) =>
    list.filter((x) => x.type !== "radio" && !x.disabled && x.checkVisibility()).map((x) => x.id),
  );
  for (const id of wanted) assert.ok(reached.has(id), `${id} is reached`);
  await page.focus("#play");
  await page.keyboard.press("Enter");
  assert.equal(await page.textContent("#play"), "Pause");
});

// Checks colours of all parts in both themes, and the layout on the narrowest telephone.
for (const [name, options] of Object.entries({
  light: { colorScheme: "light" },
  dark: { colorScheme: "dark" },
  phone: { viewport: { width: 360, height: 740 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true },
}))
  test(`accessible: ${name}`, async (t) => {
    const page = await open(t, "?t=0.00021", options);
    await accessible(page, name);
    if (shots) await mapDone(page);
    await shoot(page, name, { fullPage: true });
    for (const query of ["?example=astro&e=9", "?example=cradle"]) {
      await visit(page, query);
      await accessible(page, `${name} ${query}`);
      await shoot(page, `${name}-${query.slice(9, 14)}`, { fullPage: true });
    }
  });

test("touch: a tap chooses in the map", async (t) => {
  const page = await open(t, "?example=fig2", { maps: true, ...phone });
  await page.locator("#map").scrollIntoViewIfNeeded();
  await mapDrawn(page);
  const box = await page.locator("#map").boundingBox();
  await page.touchscreen.tap(box.x + 0.6 * box.width, box.y + 0.4 * box.height);
  await page.waitForFunction(() => document.getElementById("restitution-value").value !== "0.7");
});
