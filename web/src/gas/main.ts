// The page of the gas: controls, film, plots and sentences.
import { changes, find, setSentence, Sheet } from "../support/dom";
import { copyText, save, saveText } from "../support/output";
import { touchable } from "../support/touch";
import { themeOf } from "../style/theme";
import { ThemeSwitch } from "../support/theme_switch";
import { Client, StartsClient } from "./client";
import { csvOf } from "./csv";
import { present, thinned, type Facts } from "./facts";
import { drawGraph, graphs } from "./graphs";
import { picture } from "./picture";
import { pythonOf } from "./python";
import { reportOf, type Report } from "./report";
import { sentences, milliseconds } from "./sentences";
import { examples, filmFromQuery, fromQuery, ranges, rules, toQuery, type Quantity, type Setting } from "./setting";
import type { FrameOf } from "./simulation";
import { WorldView, gasTheme, type GasTheme } from "./worlds";
import type { Answer } from "./worker";

declare global {
  interface Window {
    hardlimit: { report: () => Report | null; log: () => Promise<Answer>; python: () => string };
  }
}

const root = document.documentElement;
const mostSamples = 1200;
const shown: Quantity[] = ["phi", "restitution", "tcNu", "gravity", "number", "friction", "stiffnessRatio"];
const [usualStarts, mostStarts] = [16, 256];

// t_c ν with its index, kept on one line.
function symbol(): HTMLElement {
  const whole = Object.assign(document.createElement("span"), { className: "whole" });
  whole.append("t", Object.assign(document.createElement("sub"), { textContent: "c" }), " ν");
  return whole;
}

class Page {
  private setting!: Setting;
  private facts: Facts | null = null;
  private frame: FrameOf | null = null;
  private next: FrameOf | null = null;
  private playing = false;
  private busy = false; // the worker has a request
  private run = 0; // counts starts; answers to earlier ones are ignored
  private answered = 0; // the last start that was answered
  private until = 0; // time of the link [s]
  private drawn = 0; // frames since the texts were written
  private theme!: GasTheme;
  private readonly client = new Client();
  private readonly startsClient = new StartsClient();
  private wanted = usualStarts; // starts
  private readonly worlds = (
    [
      ["hard", "icm"],
      ["newton", "newton"],
    ] as const
  ).map(([id, color]) => new WorldView(new Sheet(id, () => this.draw()), color));
  private readonly plots = graphs.map((id) => new Sheet(id, () => this.draw()));
  private timer = 0; // of a restart after a change

  constructor() {
    this.read();
    this.buildControls();
    // The theme switch draws at once.
    new ThemeSwitch({ theme: themeOf(root), redraw: () => this.retheme() }, () => this.draw(true));
    this.connect();
    void this.restart();
    requestAnimationFrame(() => this.tick());
    window.hardlimit = {
      report: () => (this.facts && this.current() ? reportOf(this.facts, this.playing) : null),
      log: () => this.client.ask({ kind: "log" }),
      python: () => pythonOf(this.facts!),
    };
  }

  // Reads the link. A link with a time shows that time, paused. With reduced motion the film stands at a time with
  // visible contacts.
  private read(): void {
    const q = new URLSearchParams(location.search);
    const notes: string[] = [];
    this.setting = fromQuery(q, notes);
    const { speed, time } = filmFromQuery(q, notes);
    this.playing = time === null && this.moves;
    this.until = time ?? (this.playing ? 0 : 0.02);
    find<HTMLSelectElement>("speed").value = speed;
    this.note(notes);
  }

  private readonly moves = !matchMedia("(prefers-reduced-motion: reduce)").matches;

  private current(): boolean {
    return this.facts !== null && this.answered === this.run;
  }

  private note(notes: string[]): void {
    find("notes").hidden = notes.length === 0;
    find("notes").textContent = notes.join(" ");
  }

  // --- controls ---

  private buildControls(): void {
    for (const key of shown) {
      const range = ranges[key];
      const slider = find<HTMLInputElement>(key);
      const scaled = (x: number): number => (range.log ? Math.log10(x) : x);
      [slider.min, slider.max, slider.step] = [scaled(range.low), scaled(range.high), range.step].map(String);
      touchable(slider);
      slider.addEventListener("input", () => {
        const x = range.log ? Number((10 ** Number(slider.value)).toPrecision(3)) : Number(slider.value);
        this.change({ [key]: x });
      });
    }
    for (const rule of rules) find(`rule-${rule}`).addEventListener("change", () => this.change({ rule }));
    const walls = find<HTMLInputElement>("walls");
    walls.addEventListener("change", () => this.change(walls.checked ? { walls: true } : { walls: false, gravity: 0 }));
    for (const example of examples)
      find(`example-${example.id}`).addEventListener("click", () => {
        this.writeLink();
        history.pushState(null, "", `?example=${example.id}`);
        this.change({ ...fromQuery(new URLSearchParams({ example: example.id }), []) });
      });
    this.showSetting();
  }

  // The film plays after every change, unless motion is reduced: then it goes on to a time with visible contacts.
  private change(part: Partial<Setting>): void {
    Object.assign(this.setting, part);
    this.playing = this.moves;
    if (this.setting.gravity > 0) this.setting.walls = true;
    this.until = this.playing ? 0 : 0.02;
    this.showSetting();
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => void this.restart(), 60);
  }

  private showSetting(): void {
    const s = this.setting;
    for (const key of shown) {
      const slider = find<HTMLInputElement>(key);
      slider.value = String(ranges[key].log ? Math.log10(s[key]) : s[key]);
      const text =
        key === "gravity"
          ? `${Number(s.gravity.toPrecision(3))} m/s²`
          : key === "number"
            ? String(s.number)
            : String(Number(s[key].toPrecision(3)));
      find(`${key}-value`).textContent = text;
      slider.setAttribute("aria-valuetext", text);
    }
    find<HTMLInputElement>(`rule-${s.rule}`).checked = true;
    find<HTMLInputElement>("walls").checked = s.walls;
    const rubs = s.friction > 0;
    find("stiffness-control").hidden = !rubs;
    find("ratio").parentElement!.hidden = !rubs;
    find("share").parentElement!.hidden = rubs;
    for (const example of examples) {
      const same = Object.entries(fromQuery(new URLSearchParams({ example: example.id }), [])).every(
        ([key, x]) => key === "seed" || s[key as keyof Setting] === x,
      );
      find(`example-${example.id}`).setAttribute("aria-pressed", String(same));
    }
  }

  private connect(): void {
    find("play").addEventListener("click", () => this.play(!this.playing));
    find("step").addEventListener("click", () => this.step());
    find("again").addEventListener("click", () => this.again());
    find("other").addEventListener("click", () => this.change({ seed: (this.setting.seed % 1_000_000) + 1 }));
    find("speed").addEventListener("change", () => this.writeLink());
    find("copy").addEventListener("click", () => void this.copy(this.link(), "Link copied."));
    find("python").addEventListener("click", () => {
      if (this.facts) void this.copy(pythonOf(this.facts), "Python copied.");
    });
    find("csv").addEventListener("click", () => {
      if (this.facts) saveText("hardlimit-gas.csv", csvOf(this.facts));
    });
    find("png").addEventListener("click", () => this.savePicture());
    find("more").addEventListener("click", () => {
      this.wanted = Math.min(2 * this.wanted, mostStarts);
      this.runStarts();
      this.writeTexts();
    });
    document.addEventListener("keydown", (e) => {
      const target = e.target as HTMLElement;
      if (e.ctrlKey || e.metaKey || e.altKey || target.closest(e.key === " " ? "input, select, button, a" : "select"))
        return;
      const act = { " ": () => this.play(!this.playing), ".": () => this.step(), r: () => this.again() }[
        e.key.toLowerCase()
      ];
      if (!act) return;
      e.preventDefault();
      act();
    });
    addEventListener("popstate", () => {
      this.read();
      this.showSetting();
      void this.restart();
    });
  }

  private play(on: boolean): void {
    if (on && this.facts?.done) return this.again();
    this.playing = on;
    this.showPlaying();
    this.writeLink();
  }
  private showPlaying(): void {
    find("play").textContent = this.playing ? "Pause" : "Play";
  }
  private step(): void {
    this.playing = false;
    this.showPlaying();
    void this.advance(1);
  }
  private again(): void {
    this.playing = true;
    this.until = 0;
    void this.restart();
  }

  private link(): string {
    const q = toQuery(this.setting);
    const { value } = find<HTMLSelectElement>("speed");
    if (value !== "1") q.set("speed", value);
    if (!this.playing && this.facts) q.set("t", String(this.facts.sample.time));
    return `${location.origin}${location.pathname}?${q}`;
  }
  private writeLink(): void {
    history.replaceState(null, "", this.link());
  }
  private async copy(text: string, done: string): Promise<void> {
    const note = find("copied");
    this.writeLink();
    const refused = text === this.link() ? "The link is in the address bar." : text;
    note.textContent = (await copyText(text)) ? done : refused;
  }
  private savePicture(): void {
    if (!this.facts) return;
    const canvas = picture(
      this.facts,
      this.worlds.map(({ sheet }) => sheet),
      this.theme,
    );
    canvas.toBlob((blob) => blob && save("hardlimit-gas.png", blob));
  }

  // --- the film ---

  private async restart(): Promise<void> {
    const run = ++this.run;
    clearTimeout(this.timer);
    this.timer = 0;
    this.next = null;
    this.busy = true;
    this.showPlaying();
    const answer = await this.client.start({ kind: "start", setting: { ...this.setting } });
    if (run !== this.run) return;
    this.busy = false;
    this.answered = run;
    root.dataset.run = String(run);
    if (answer.kind === "error") return this.fail(answer.message);
    const { start, frame, messages } = answer;
    if (start.tooSoft > 0) this.playing = false;
    this.wanted = usualStarts;
    this.frame = frame;
    this.facts = { start, messages, samples: [], starts: [], ...present(frame) };
    this.take([frame.sample], frame);
    this.runStarts();
    this.showPlaying();
    this.draw();
    this.writeTexts();
    if (this.until > 0 && start.tooSoft === 0) void this.advance(1, this.until);
    else this.writeLink();
  }

  // Runs the starts that are still wanted, in their own worker.
  private runStarts(): void {
    const { setting, tooSoft } = this.facts!.start;
    const run = this.run;
    const from = this.facts!.starts.length;
    root.dataset.starts = String(from);
    if (tooSoft > 0 || from >= this.wanted) return;
    void this.startsClient.run({ kind: "starts", setting, from, to: this.wanted }, (start) => {
      if (run !== this.run || !this.facts) return;
      this.facts = { ...this.facts, starts: [...this.facts.starts, start] };
      root.dataset.starts = String(this.facts.starts.length);
      if (this.playing) return;
      this.draw();
      this.writeTexts();
    });
  }

  private fail(message: string): void {
    this.playing = false;
    this.showPlaying();
    setSentence(find("verdict"), message);
  }

  private async advance(steps: number, until = 0): Promise<void> {
    if (this.busy || !this.facts || this.facts.done || this.facts.start.tooSoft > 0) return;
    const run = this.run;
    this.busy = true;
    const answer = await this.client.ask({ kind: "advance", steps, until });
    if (run !== this.run) return;
    this.busy = false;
    if (answer.kind === "error") return this.fail(answer.message);
    root.dataset.ms = answer.ms.toFixed(2);
    this.take(answer.samples, answer.frame);
    this.next = answer.frame;
    if (answer.late) return this.advance(steps, until);
    if (!this.playing) this.writeLink();
  }

  private take(samples: FrameOf["sample"][], frame: FrameOf): void {
    const all = this.facts!.samples.concat(samples);
    this.facts = { ...this.facts!, samples: all.length > mostSamples ? thinned(all) : all, ...present(frame) };
  }

  private tick(): void {
    requestAnimationFrame(() => this.tick());
    if (this.next) {
      this.frame = this.next;
      this.next = null;
      const { done } = this.frame;
      if (done && this.playing) {
        this.playing = false;
        this.showPlaying();
        this.writeLink();
      }
      if (this.playing && !document.hidden) void this.advance(this.steps);
      this.draw();
      if (++this.drawn % 12 === 0 || !this.playing) this.writeTexts();
    } else if (this.playing && !document.hidden) void this.advance(this.steps);
    const waits = this.busy || this.timer !== 0 || this.answered !== this.run;
    root.toggleAttribute("data-settled", !this.playing && !waits); // paused, drawn and written, for tests
  }
  private get steps(): number {
    return Number(find<HTMLSelectElement>("speed").value);
  }

  // --- drawing ---

  private retheme(): void {
    this.theme = gasTheme(themeOf(root), root);
    this.draw();
  }

  private draw(all = !this.playing): void {
    if (!this.frame || !this.facts || !this.theme) return;
    const begin = performance.now();
    const { start } = this.facts;
    this.worlds.forEach((world, i) => world.sheet.shown() && world.draw(start, this.frame!.worlds[i], this.theme));
    // The plots change slowly: one is drawn in each frame.
    this.plots.forEach(({ g, canvas, width, height, shown }, i) => {
      if (!shown() || !(all || this.drawn % this.plots.length === i)) return;
      // Of plots below each other only the last has numbers at the time axis.
      const timed = !this.plots.slice(i + 1).some((other) => other.canvas.offsetLeft === canvas.offsetLeft);
      drawGraph(g, width, height, graphs[i], this.facts!, this.theme, timed);
    });
    root.dataset.drawMs = (performance.now() - begin).toFixed(2);
  }

  private writeTexts(): void {
    if (!this.facts) return;
    const list = sentences(this.facts);
    const of = (...topics: string[]): string =>
      list
        .filter(({ topic }) => topics.includes(topic))
        .map(({ text }) => text)
        .join(" ");
    const write = (id: string, text: string): void => {
      const parts = text.split("t_c ν").flatMap((part, i) => (i === 0 ? [part] : [symbol(), part]));
      if (changes(find(id), text)) find(id).replaceChildren(...parts);
    };
    write("verdict", of("verdict"));
    write("law", of("law", "range", "forecast"));
    write("news", of("hard", "newton", "end"));
    write("mean", of("mean", "spins"));
    write("measured", of("measured", "contacts", "distance"));
    const { starts, start } = this.facts;
    const running = start.tooSoft === 0 && starts.length < this.wanted;
    find("more").hidden = running || start.tooSoft > 0 || this.wanted >= mostStarts;
    write(
      "starts",
      start.tooSoft > 0 ? "" : `${starts.length} ${running ? `of ${this.wanted} ` : ""}starts${running ? " …" : ""}`,
    );
    write("time", `${milliseconds(this.facts.sample.time)}`);
  }
}

new Page();
