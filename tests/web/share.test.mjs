// Tools for a lecture: QR code, embed code, worksheet, sound of contacts, measured balls.
// PYTHON: an interpreter that has hardlimit installed. SHOTS: a folder for screenshots.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import decodeQR from "qr/decode.js";
import { accessible, frames, settled, shoot, Site, solved } from "./browser.mjs";
import { load, random, randomLink } from "./modules.mjs";

const lib = await load("embed", "measured", "presets", "qr", "sound", "worksheet");
const { copyOf, core, dropOf, presets, solve } = lib;

let site;
before(async () => void (site = await Site.begin()));
after(() => site?.end());

// An image of a QR code, with `size` pixels for each field.
function imageOf(fields, size = 4) {
  const side = size * fields.length;
  const data = new Uint8ClampedArray(4 * side * side);
  for (let i = 0; i < side * side; i++) {
    const dark = fields[Math.floor(i / side / size)][Math.floor((i % side) / size)];
    data.set(dark ? [0, 0, 0, 255] : [255, 255, 255, 255], 4 * i);
  }
  return { width: side, height: side, data };
}

test("a QR code is read as its link", () => {
  const next = random(71);
  for (let i = 0; i < 8; i++) {
    const link = `https://example.org/explorer/index.html?${randomLink(next)}&page=lab`;
    const fields = lib.qrFields(link);
    assert.ok(
      fields.every((row) => row.length === fields.length && row.slice(0, 4).every((dark) => !dark)),
      "a margin",
    );
    assert.equal(decodeQR(imageOf(fields)), link);
  }
  assert.ok(
    lib.isLocal("http://127.0.0.1:8000/?e=1") && lib.isLocal("http://localhost/") && !lib.isLocal("https://a.org/"),
  );
});

test("the embed code contains the setting and one panel", () => {
  const link = "https://example.org/x/?page=lab&e=0.5&gap=0,1e-4&guess=3";
  const code = lib.embedCode(link, "rebound");
  assert.equal(
    code,
    '<iframe src="https://example.org/x/?e=0.5&amp;gap=0,1e-4&amp;panel=rebound" title="Rebound height" width="100%" ' +
      'height="520" loading="lazy"></iframe>',
  );
});

// ---- sound ----------------------------------------------------------------------------------------------------

// Records the tones of an AudioContext.
class FakeContext {
  tones = [];
  currentTime = 5;
  closed = false;
  destination = {};
  createOscillator() {
    const tone = {
      frequency: {},
      connect: (next) => ((tone.gain = next), next),
      start: (t) => (tone.start = t),
      stop: (t) => (tone.end = t),
    };
    this.tones.push(tone);
    return tone;
  }
  createGain() {
    const gain = { connect: (next) => next };
    gain.gain = { setValueAtTime: (x) => (gain.loudness = x), exponentialRampToValueAtTime: () => {} };
    return gain;
  }
  close() {
    this.closed = true;
  }
}

test("the impulse of a contact is the change of momentum, its pitch follows the duration", () => {
  for (const id of ["fig2", "steel", "astro"]) {
    const d = dropOf(solve(core, copyOf(presets.find((p) => p.id === id).scenario)));
    const notes = lib.notesOf(d);
    assert.equal(
      notes.length,
      d.newton.run.contacts.filter((c) => c.begin <= d.newton.run.last && c.end > c.begin).length,
    );
    // The top ball receives all impulses of its contacts, less its weight.
    const top = d.scenario.balls.length - 1;
    const mass = lib.massOf(d.scenario.balls[top]);
    const contacts = d.newton.run.contacts.filter((c) => c.pair === top && c.end <= d.newton.run.last);
    const [first, last] = [contacts[0].begin, contacts.at(-1).end];
    const [a, b] = core.sample ? (core.set(d.scenario), core.solve(0), core.sample(0, [first, last])) : [];
    const received = contacts.reduce((sum, c) => sum + lib.impulseOf(d, top, c.begin, c.end), 0);
    const change = mass * (b.velocity[top] - a.velocity[top] + 9.81 * (last - first));
    assert.ok(Math.abs(received / change - 1) < 0.02, `${id}: ${received} N s, ${change} N s`);
    assert.ok(notes.every(({ pitch, loudness }) => pitch >= 80 && pitch <= 3000 && loudness > 0 && loudness <= 1));
    const sorted = [...notes].sort((p, q) => p.end - p.at - (q.end - q.at));
    sorted.forEach((note, i) => assert.ok(i === 0 || note.pitch <= sorted[i - 1].pitch, "a longer contact is lower"));
    assert.equal(Math.max(...notes.map((n) => n.loudness)), 1);
  }
});

test("each contact sounds once when the film passes it; nothing sounds before", () => {
  const d = dropOf(solve(core, copyOf(presets.find((p) => p.id === "fig2").scenario)));
  const contexts = [];
  const sound = new lib.ContactSound(() => (contexts.push(new FakeContext()), contexts.at(-1)));
  const screen = (from, to) => d.clock.toScreen(to) - d.clock.toScreen(from);
  const run = (playing) => {
    for (let s = 0; s <= d.clock.length; s += 1 / 60) sound.follow(d, d.clock.toPhysical(s), playing, screen);
  };
  run(true);
  assert.equal(contexts.length, 0, "no context before the reader asks");
  sound.switch(true);
  run(false);
  assert.equal(contexts[0].tones.length, 0, "a film that stands is silent");
  run(true);
  const notes = lib.notesOf(d);
  assert.deepEqual(
    contexts[0].tones.map((tone) => tone.frequency.value),
    notes.map(({ pitch }) => pitch),
  );
  contexts[0].tones.forEach((tone, i) => {
    assert.ok(Math.abs(tone.gain.loudness - 0.3 * notes[i].loudness) < 1e-12);
    assert.ok(tone.start === 5 && tone.end > 5.1 && tone.end <= 6.5);
  });
  sound.switch(false);
  run(true);
  assert.ok(contexts[0].closed && contexts.length === 1);
});

test("the page is silent until the button is pressed, and again afterwards", async (t) => {
  const page = await site.open(t, "?example=fig2");
  await page.evaluate(() => {
    window.contexts = [];
    window.AudioContext = class {
      constructor() {
        window.contexts.push(this);
      }
      currentTime = 0;
      destination = {};
      tones = 0;
      createOscillator() {
        this.tones++;
        return { frequency: {}, connect: (next) => next, start() {}, stop() {} };
      }
      createGain() {
        return { gain: { setValueAtTime() {}, exponentialRampToValueAtTime() {} }, connect: (next) => next };
      }
      async close() {
        this.closed = true;
      }
    };
  });
  await page.click("#play");
  await frames(page, 20);
  assert.equal(await page.evaluate(() => window.contexts.length), 0);
  await page.focus("#sound");
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => window.contexts[0]?.tones >= 2);
  assert.equal(await page.getAttribute("#sound", "aria-pressed"), "true");
  await page.click("#sound");
  await page.waitForFunction(() => window.contexts[0].closed);
  assert.equal(await page.evaluate(() => window.contexts.length), 1);
});

// ---- worksheet, dialogs, balls ------------------------------------------------------------------------------------

test("the worksheet fits the setting and gives no answer away", async (t) => {
  for (const example of ["basketball", "astro", "cradle"]) {
    const page = await site.open(t, `?example=${example}&page=lab`, { viewport: { width: 1280, height: 720 } });
    await page.click("#open-worksheet");
    await page.waitForSelector("#sheet ol li");
    const { text, shown, svgs } = await page.evaluate(() => ({
      text: document.getElementById("sheet").innerText,
      shown: [...document.body.children].filter((x) => x.getClientRects().length > 0).map((x) => x.id),
      svgs: document.querySelectorAll("#sheet svg").length,
    }));
    assert.deepEqual(shown, ["worksheet"]);
    assert.ok(svgs >= 2 && (text.match(/\?/g) ?? []).length >= 6);
    const report = await page.evaluate(() => window.hardlimit.report().numbers);
    for (const [name, x] of Object.entries(report))
      if (/rise|velocity/.test(name) && Math.abs(x) > 1e-3)
        assert.ok(!text.includes(Number(x).toPrecision(3)), `${example}: ${name} = ${x} is an answer`);
    assert.doesNotMatch(text, /NaN|undefined/);
    await accessible(page, `the worksheet of ${example}`);
    await shoot(page, `worksheet-${example}`, { fullPage: true });
    await page.keyboard.press("Escape");
    assert.ok(await page.isVisible("#film"));
  }
});

test("on paper the worksheet is alone, in at most three pages", async (t) => {
  const page = await site.open(t, "?example=fig2&page=lab");
  await page.click("#open-worksheet");
  await page.waitForSelector("#sheet ol li");
  const pdf = (await page.pdf({ format: "A4" })).toString("latin1");
  const pages = (pdf.match(/\/Type\s*\/Page\b/g) ?? []).length;
  assert.ok(pages >= 1 && pages <= 3, `${pages} pages`);
});

for (const [name, viewport, colorScheme] of [
  ["desk", { width: 1280, height: 720 }, "dark"],
  ["phone", { width: 390, height: 844 }, "light"],
])
  test(`QR and embed code, by keyboard, accessible: ${name}`, async (t) => {
    const page = await site.open(t, "?example=steel", { viewport, colorScheme });
    await page.focus("#share summary");
    await page.keyboard.press("Enter");
    await page.keyboard.press("Tab");
    await page.keyboard.press("Tab");
    await page.keyboard.press("Enter");
    await page.waitForSelector("dialog[open] svg.qr");
    assert.match(await page.innerText("#dialog-body"), /page=lab[^]*this computer only/);
    await accessible(page, "the QR code");
    await shoot(page, `share-qr-${name}`);
    await page.keyboard.press("Escape");
    await page.click("#embed");
    await page.waitForSelector("dialog[open] textarea");
    await page.selectOption("dialog select", "rebound");
    const code = await page.inputValue("dialog textarea");
    await accessible(page, "the embed code");
    await shoot(page, `share-embed-${name}`);
    await page.click("#dialog-close");
    const { hostname, search } = new URL(/src="([^"]*)"/.exec(code)[1].replaceAll("&amp;", "&"));
    assert.equal(hostname, "127.0.0.1");
    assert.match(search, /panel=rebound/);
    const panel = await site.open(t, search);
    assert.equal(
      await panel.evaluate(
        () =>
          document.querySelector("main > [data-shown]").id || document.querySelector("main > [data-shown]").className,
      ),
      "panel rebound",
    );
  });

test("a measured ball from the list: its radius and mass, and its source", async (t) => {
  const page = await site.open(t, "?example=fig2");
  for (const { id, by, mass, diameter } of lib.measuredBalls) {
    await page.selectOption("#kind2", id);
    const said = await page.textContent(".correction");
    assert.ok(said.includes(by), said);
    await settled(page);
    const ball = await page.evaluate(() => window.hardlimit.report().setting.balls[1]);
    assert.ok(2 * ball.radius >= diameter[0] && 2 * ball.radius <= diameter[1], id);
    assert.ok(lib.massOf(ball) >= 0.99 * mass[0] && lib.massOf(ball) <= 1.01 * mass[1], id);
    assert.equal(await page.inputValue("#kind2"), id);
  }
  await accessible(page, "a measured ball");
});

test("phones: the laboratory opens at its top, a single panel shows its picture first", async (t) => {
  const page = await site.open(t, "?story=count", { viewport: { width: 390, height: 844 } });
  await page.evaluate(() => scrollTo(0, 2500));
  await page.click("#leave");
  await page.waitForFunction(() => !document.documentElement.dataset.mode);
  assert.equal(await page.evaluate(() => scrollY), 0);
  for (const panel of ["map", "film", "rebound"]) {
    await page.goto(`${site.base}?panel=${panel}&example=fig2`);
    await solved(page);
    const [picture, words] = await page.evaluate(
      (name) =>
        [`main > .${name} .canvas`, "main > .answers"].map(
          (s) => document.querySelector(s).getBoundingClientRect().top,
        ),
      panel,
    );
    assert.ok(picture < words && picture < 300, `${panel}: ${picture}, ${words}`);
  }
});
