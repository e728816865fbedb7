// hardlimit's own server and a browser, for tests of the page. PYTHON: an interpreter that has hardlimit installed.
// CHROMIUM, FIREFOX: the browsers. SHOTS: a folder for screenshots. LATE: a random delay of up to LATE milliseconds is
// added to each answer of a worker, in order, as on a slow machine. Code that relies on quick answers then fails.
// SLOW: Chromium's main thread is slowed down by this factor. Tests wait for states of the page, never for a time.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { firefox } from "playwright-core";
import { launch } from "../../web/chromium.mjs";

const patience = 300_000; // longest wait for a state of the page [ms]
const axe = readFileSync(new URL("./node_modules/axe-core/axe.min.js", import.meta.url), "utf8");

function answerLate(most) {
  window.Worker = class extends Worker {
    last = 0;
    events = []; // timers less than a millisecond apart may change places
    get onmessage() {
      return super.onmessage;
    }
    set onmessage(receive) {
      super.onmessage = (event) => {
        this.last = Math.max(this.last, performance.now() + Math.random() * most);
        this.events.push(event);
        setTimeout(() => receive.call(this, this.events.shift()), this.last - performance.now());
      };
    }
  };
}

// Maps without values, at once: most tests look at other things, and each change would compute a map anew.
function answerWithoutMaps() {
  const { postMessage } = Worker.prototype;
  Worker.prototype.postMessage = function (message, ...more) {
    if (message.kind !== "points") return postMessage.call(this, message, ...more);
    const answer = new Float64Array((5 * message.ask.points.length) / 2).fill(NaN); // MAP_VALUES of each point
    setTimeout(() => this.onmessage?.({ data: { id: message.id, ms: 1, answer } }));
  };
}

// Debian's Firefox is controlled by WebDriver BiDi; its profile sets reduced motion.
const engines = {
  chromium: () => launch(),
  firefox: () =>
    firefox.launch({
      channel: "moz-firefox",
      executablePath: process.env.FIREFOX ?? "/usr/bin/firefox-esr",
      firefoxUserPrefs: { "ui.prefersReducedMotion": 1 },
    }),
};

export class Site {
  static async begin(engine = "chromium") {
    const site = Object.assign(new Site(), { engine });
    site.server = spawn(
      process.env.PYTHON ?? "python3",
      ["-m", "hardlimit", "explore", "--port", "0", "--no-browser"],
      { stdio: ["ignore", "pipe", "inherit"] },
    );
    site.base = await new Promise((resolve, reject) => {
      let text = "";
      site.server.stdout.on("data", (data) => {
        text += data;
        const url = /http:\/\/127\.0\.0\.1:\d+\//.exec(text);
        if (url) resolve(url[0]);
      });
      site.server.on("exit", () => reject(new Error("hardlimit explore ended: " + text)));
    });
    site.browser = await engines[engine]();
    return site;
  }

  async end() {
    await this.browser?.close();
    this.server?.kill();
  }

  async newContext(options = {}) {
    const context = await this.browser.newContext({ reducedMotion: "reduce", ...options });
    context.setDefaultTimeout(patience);
    return context;
  }

  // Opens a page. Warnings in the console and requests to other servers fail the test. `maps`: computed or not.
  async open(t, query = "", { ready = solved, maps = !!process.env.SHOTS, ...options } = {}) {
    const context = await this.newContext({
      viewport: { width: 1440, height: 900 },
      acceptDownloads: true,
      ...options,
    });
    if (!maps) await context.addInitScript(answerWithoutMaps);
    if (process.env.LATE) await context.addInitScript(answerLate, Number(process.env.LATE));
    const page = await context.newPage();
    const faults = [];
    t.after(async () => {
      await context.close();
      assert.deepEqual(faults, []);
    });
    if (process.env.SLOW && this.engine === "chromium")
      await (
        await context.newCDPSession(page)
      ).send("Emulation.setCPUThrottlingRate", { rate: Number(process.env.SLOW) });
    const complain = (text) => {
      // Playwright's screenshots cause this warning.
      if (!(process.env.SHOTS && text.includes("blocked an inline style"))) faults.push(text);
    };
    // The browser requests the icon after each new link.
    const icon = (m) => m.location().url.endsWith("/icon.svg") && m.text().includes("ERR_INTERNET_DISCONNECTED");
    page.on("console", (m) => ["error", "warning"].includes(m.type()) && !icon(m) && complain(m.text()));
    page.on("pageerror", (e) => complain(String(e)));
    page.on(
      "request",
      (r) => !/^(data|blob):/.test(r.url()) && !r.url().startsWith(this.base) && faults.push("request to " + r.url()),
    );
    openMenu(page);
    await page.goto(this.base + laboratory(query));
    await ready(page);
    return page;
  }
}

// Adds the laboratory to a link that does not name a page.
export const laboratory = (query) =>
  /^gas|[?&](story|panel|page|a\.)/.test(query) ? query : `${query}${query ? "&" : "?"}page=lab`;

// A click on an entry of a menu opens the menu first.
function openMenu(page) {
  const click = page.click.bind(page);
  page.click = async (selector, options) => {
    const menu = /^#[a-z-]+$/.test(selector) && (await page.$(`details.menu:has(${selector})`));
    const inside = menu && (await menu.evaluate((element, id) => !!element.querySelector(`div ${id}`), selector));
    if (inside) await menu.evaluate((element) => (element.open = true));
    await click(selector, options);
    if (inside) await menu.evaluate((element) => (element.open = false));
  };
}

// Goes to another setting by the history of the page. The numbers are the previous ones until it is solved.
export const goTo = (page, query) =>
  page.evaluate((query) => {
    history.pushState(null, "", query);
    dispatchEvent(new PopStateEvent("popstate"));
  }, laboratory(query));
export const forget = (page) => page.evaluate(() => delete document.documentElement.dataset.numbers);

// Waits for this number of frames. After two the page has drawn one with all that was entered before.
export const frames = (page, count = 2) =>
  page.evaluate(
    (count) =>
      new Promise((done) => {
        const tick = () => (count-- > 0 ? requestAnimationFrame(tick) : done());
        tick();
      }),
    count,
  );

// Waits until a page that was loaded shows its numbers and has set up its plots.
export async function solved(page) {
  await page.waitForFunction(
    () =>
      document.documentElement.dataset.numbers !== undefined && document.documentElement.dataset.complete !== undefined,
  );
  await frames(page, 3); // sizes and places of the plots are told after a frame
}
export const rest = (page) =>
  page.waitForFunction(
    () => document.documentElement.dataset.busy === undefined && document.documentElement.dataset.numbers,
  );
// Waits until what was entered is solved and written, and this number of frames is drawn since.
export const settled = (page, frames = 2) =>
  page.evaluate(
    (frames) =>
      new Promise((done) => {
        let left = frames;
        const tick = () => {
          if (document.documentElement.dataset.busy !== undefined) left = frames;
          if (left-- > 0) requestAnimationFrame(tick);
          else done();
        };
        tick();
      }),
    frames,
  );

// The address, of which page.url() learns late; `linked` waits until it is that of what the page shows.
export const address = async (page) => new URL(await page.evaluate(() => location.href));
export async function linked(page) {
  await settled(page);
  await page.waitForFunction(() => window.hardlimit.report().link === location.href);
  return address(page);
}

// Does `act`, and waits for a state of the page that may soon be over: it is looked for in each frame since before.
export const sees = (page, state, argument, act) =>
  Promise.all([page.waitForFunction(state, argument), frames(page).then(act)]);

export const mapDone = (page) => page.waitForFunction(() => document.getElementById("map").dataset.ms !== undefined);
// Does `act`, after which the map is computed anew, and waits for that map.
export async function newMap(page, act) {
  await sees(page, () => document.getElementById("map").dataset.ms === undefined, null, act);
  await mapDone(page);
}
export const mapDrawn = (page) => page.waitForSelector("#map[data-resolution]");

// Waits until a canvas has more than this number of colours.
export const drawn = (page, id, colours = 1) =>
  page.waitForFunction(
    ([id, colours]) => {
      const canvas = document.getElementById(id);
      const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      return new Set(new Uint32Array(data.buffer)).size > colours;
    },
    [id, colours],
  );

// Changes the size of the window.
export async function resize(page, width, height) {
  await page.setViewportSize({ width, height });
  await page.waitForFunction(([w, h]) => innerWidth === w && innerHeight === h, [width, height]);
  await frames(page, 3);
}

// Of the next drop only parts of the result arrive, as in an endless computation.
export const answerInPart = (page) =>
  page.evaluate(() => {
    const { postMessage } = Worker.prototype;
    Worker.prototype.postMessage = function (...message) {
      if (message[0].kind === "solve") {
        const hear = this.onmessage;
        this.onmessage = (event) => event.data.begun && hear.call(this, event);
        Worker.prototype.postMessage = postMessage;
      }
      postMessage.apply(this, message);
    };
  });
export const numbers = (page) => page.evaluate(() => JSON.parse(document.documentElement.dataset.numbers));
// Goes to another setting and waits for its numbers.
export async function visit(page, query) {
  await forget(page);
  await goTo(page, query);
  await rest(page);
}
export const phone = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true };

// The file that a button saves.
export async function download(page, selector) {
  const [file] = await Promise.all([page.waitForEvent("download"), page.click(selector)]);
  return { name: file.suggestedFilename(), bytes: readFileSync(await file.path()) };
}

// Number of colours of a canvas.
export const colours = (page, id) =>
  page.evaluate((id) => {
    const canvas = document.getElementById(id);
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return new Set(new Uint32Array(data.buffer)).size;
  }, id);

export async function accessible(page, what) {
  await page.evaluate(axe);
  const result = await page.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
  assert.deepEqual(
    result.violations.map((v) => `${v.id}: ${v.nodes.map((n) => n.target.join(" ")).join("; ")}`),
    [],
    what,
  );
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
  assert.ok(wide <= 0, `${what}: ${wide} pixels too wide`);
}

export async function shoot(page, name, options = {}) {
  const { SHOTS: folder } = process.env;
  if (!folder) return;
  mkdirSync(folder, { recursive: true });
  await page.screenshot({ path: join(folder, `${name}.png`), ...options });
}
