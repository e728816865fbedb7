// The page: state, what follows from a change of it, and what the pointer and the keys do.
import { Core, Model } from "./core";
import { Controls } from "./controls";
import { solve, type Drop } from "./drop";
import { csv, save } from "./exporting";
import { drawForces, forcesSummary, type ForcesLayout } from "./forces";
import { digits, withUnit } from "./format";
import { ContactMap, type MapLayout } from "./map";
import { exactNumbers, fillEnergy, fillTable, subscripted, verdict } from "./numbers";
import type { Frame, Scale } from "./plot";
import { presets, type Preset } from "./presets";
import { clampTo, constants, constantsOf, copyOf, firstGap, fromQuery, lowestHeight, ranges, toQuery, toToml, type Scenario } from "./scenario";
import { drawStage } from "./stage";
import { themeOf, type Theme } from "./theme";
import { Timeline, type TimelineLayout } from "./timeline";
import { firstView, mapLimits, viewFromQuery, viewToQuery, wholeMap, type Box, type View } from "./view";

const find = <T extends HTMLElement>(id: string): T => document.getElementById(id) as T;

// A canvas that fills its box at the screen's resolution.
class Sheet {
  readonly canvas: HTMLCanvasElement;
  readonly g: CanvasRenderingContext2D;
  width = 0;
  height = 0;
  constructor(id: string, resized: () => void) {
    this.canvas = find<HTMLCanvasElement>(id);
    this.g = this.canvas.getContext("2d")!;
    this.measure();
    new ResizeObserver(() => {
      if (this.measure()) resized();
    }).observe(this.canvas.parentElement!);
  }
  private measure(): boolean {
    const { clientWidth: w, clientHeight: h } = this.canvas.parentElement!;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const [pw, ph] = [Math.round(w * ratio), Math.round(h * ratio)];
    if (this.canvas.width === pw && this.canvas.height === ph) return false;
    this.canvas.width = pw;
    this.canvas.height = ph;
    this.width = w;
    this.height = h;
    this.g.setTransform(ratio, 0, 0, ratio, 0, 0);
    return true;
  }
}

const queryOf = (s: Scenario): string => {
  const q = new URLSearchParams();
  toQuery(s, q);
  return q.toString();
};

class Page {
  private scenario: Scenario;
  private about = "";
  private preset = "";
  private readonly view: View = firstView();
  private drop: Drop | null = null;
  private theme: Theme = themeOf(document.documentElement);
  private readonly timeline = new Timeline();
  private readonly map: ContactMap;
  private readonly controls: Controls;
  private readonly stage: Sheet;
  private readonly forces: Sheet;
  private readonly timelineSheet: Sheet;
  private readonly mapSheet: Sheet;
  private forcesLayout: ForcesLayout | null = null;
  private timelineLayout: TimelineLayout | null = null;
  private mapLayout: MapLayout | null = null;
  private screen = 0; // place in the film [s on the screen]
  private playing: boolean;
  private held = 0; // time the last picture has been shown
  private lastFrame = 0;
  private dirty = { solve: true, plots: true, timeline: true, map: true, mapPicture: true, stage: true };
  private mapKey = "";
  private mapDrawn = 0;
  private timelineKey = "";
  private urlTimer = 0;
  private hover: [number, number] | null = null;

  constructor(
    private readonly core: Core,
    module: WebAssembly.Module,
  ) {
    const notes: string[] = [];
    const query = new URLSearchParams(location.search);
    const named = presets.find((p) => p.id === query.get("example"));
    if (query.get("example") !== null && !named) notes.push(`example = “${query.get("example")?.slice(0, 20)}” is unknown: the paper’s is shown`);
    const base = named ?? presets[0];
    this.scenario = copyOf(base.scenario);
    Object.assign(this.view.map, base.map);
    fromQuery(this.scenario, query, notes);
    viewFromQuery(this.view, query, notes);
    this.note(notes);
    this.playing = this.view.time === null && !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.map = new ContactMap(module, new URL("worker.js", import.meta.url).href, () => {
      this.dirty.mapPicture = true;
    });
    this.map.setShow(this.view.map.show);
    this.controls = new Controls(find("controls"), this.scenario, () => this.edited());
    const all = (): void => void Object.assign(this.dirty, { plots: true, mapPicture: true, stage: true });
    this.stage = new Sheet("stage", all);
    this.forces = new Sheet("forces", all);
    this.timelineSheet = new Sheet("timeline", all);
    this.mapSheet = new Sheet("map", all);
    this.fillPresets([base, ...presets].find((p) => queryOf(p.scenario) === queryOf(this.scenario))?.id ?? "");
    this.listen();
    this.setTheme(null);
    this.frame(performance.now());
    document.documentElement.dataset.ready = String(Math.round(performance.now()));
  }

  // ---- state ------------------------------------------------------------------------------------------

  private fillPresets(chosen: string): void {
    const select = find<HTMLSelectElement>("preset");
    const own = new Option("Your own", "");
    own.hidden = true;
    select.append(own, ...presets.map((p) => new Option(p.name, p.id)));
    select.addEventListener("change", () => {
      const preset = presets.find((p) => p.id === select.value);
      if (preset) this.load(preset);
    });
    this.choosePreset(chosen);
  }

  private choosePreset(id: string): void {
    this.preset = id;
    find<HTMLSelectElement>("preset").value = id;
    this.about = presets.find((p) => p.id === id)?.about ?? "";
  }

  private load(preset: Preset): void {
    this.scenario = copyOf(preset.scenario);
    this.view.map.zoom = null;
    Object.assign(this.view.map, preset.map);
    this.map.setShow(this.view.map.show);
    this.view.time = null;
    this.screen = 0;
    this.note([]);
    this.choosePreset(preset.id);
    this.dirty.solve = true;
    this.play(!matchMedia("(prefers-reduced-motion: reduce)").matches);
  }

  private edited(): void {
    if (this.preset) this.choosePreset("");
    this.dirty.solve = true;
  }

  private note(notes: string[]): void {
    const box = find("notes");
    box.hidden = notes.length === 0;
    box.querySelector("ul")!.replaceChildren(
      ...notes.slice(0, 15).map((text) => {
        const li = document.createElement("li");
        li.textContent = text;
        return li;
      }),
    );
  }

  private link(): string {
    const q = new URLSearchParams();
    toQuery(this.scenario, q);
    viewToQuery({ ...this.view, time: this.playing || this.screen === 0 ? null : this.time() }, q);
    const text = q.toString().replaceAll("%2C", ",");
    return `${location.origin}${location.pathname}${text ? `?${text}` : ""}`;
  }

  private writeLink(): void {
    clearTimeout(this.urlTimer);
    this.urlTimer = window.setTimeout(() => history.replaceState(null, "", this.link()), 250);
  }

  private clock(): Drop["clock"] {
    return this.view.slow ? this.drop!.clock : this.drop!.realTime;
  }
  private time(): number {
    return this.drop ? this.clock().toPhysical(this.screen) : 0;
  }
  private seek(time: number): void {
    if (!this.drop) return;
    this.screen = this.clock().toScreen(time);
    this.held = 0;
    this.dirty.stage = true;
  }
  private play(on: boolean): void {
    this.playing = on;
    this.held = 0;
    if (on && this.drop && this.screen >= this.clock().length) this.screen = 0;
    find("play").textContent = on ? "Pause" : "Play";
    this.dirty.stage = true;
    this.writeLink();
  }
  private setSlow(on: boolean): void {
    const time = this.time();
    this.view.slow = on;
    find("slow").setAttribute("aria-pressed", String(on));
    this.seek(time);
    this.writeLink();
  }

  // ---- computing --------------------------------------------------------------------------------------

  private resolve(): void {
    const before = this.drop;
    const share = before ? this.screen / this.clock().length : 0;
    const result = solve(this.core, this.scenario);
    if ("reason" in result) {
      this.drop = null;
      find("verdict").textContent = result.reason;
      return;
    }
    this.drop = result;
    if (this.view.time !== null) {
      const kept = Math.min(Math.max(this.view.time, result.start), result.stop);
      if (Math.abs(kept - this.view.time) > 1e-6) this.note([`t = ${this.view.time} s is outside the film: ${digits(kept)} s used`]);
      this.seek(kept);
      this.view.time = null;
    } else this.screen = Math.min(share, 1) * this.clock().length;
    this.controls.set(this.scenario, this.about);
    fillTable(find("numbers").querySelector("tbody")!, result);
    fillEnergy(find("energy"), result);
    const [newton, icm] = verdict(result, this.core);
    const [a, b] = [document.createElement("span"), document.createElement("span")];
    a.className = "newton";
    b.className = "icm";
    a.textContent = newton + " ";
    b.textContent = icm;
    find("verdict").replaceChildren(a, b);
    this.forces.canvas.setAttribute("aria-description", forcesSummary(result));
    this.refreshMapChoices();
    const timelineKey = JSON.stringify({ ...this.scenario, restitution: 0 });
    if (timelineKey !== this.timelineKey) this.timeline.start(copyOf(this.scenario));
    this.timelineKey = timelineKey;
    this.refreshMap();
    this.dirty.plots = this.dirty.stage = this.dirty.mapPicture = true;
    document.documentElement.dataset.numbers = JSON.stringify(exactNumbers(result));
    this.writeLink();
  }

  private refreshMapChoices(): void {
    const s = this.scenario;
    const axis = find<HTMLSelectElement>("map-axis");
    axis.options[1].disabled = s.cradle;
    if (s.cradle) this.view.map.axis = "gap";
    const show = find<HTMLSelectElement>("map-show");
    const pairOnly = s.balls.length !== 2 || s.cradle;
    for (const i of [1, 2]) show.options[i].disabled = pairOnly;
    if (pairOnly && this.view.map.show !== "count") {
      this.view.map.show = "count";
      this.map.setShow("count");
    }
    axis.value = this.view.map.axis;
    show.value = this.view.map.show;
    find("map-title").textContent = this.view.map.axis === "gap" ? "Every ε and every gap" : "Every ε and every size of the lower ball";
  }

  private mapBox(): Box {
    const { run } = this.drop!.newton;
    const floor = Number.isFinite(run.tFloorEnd) ? run.tFloorEnd : this.drop!.to - this.drop!.from;
    const speed = this.scenario.cradle ? Math.max(...this.scenario.velocities.map(Math.abs)) : run.impactSpeed;
    return this.view.map.zoom ?? wholeMap(this.scenario, this.view.map.axis, floor, speed);
  }

  private refreshMap(): void {
    if (!this.drop) return;
    const box = this.mapBox();
    const { axis } = this.view.map;
    const s = copyOf(this.scenario);
    s.restitution = 0;
    if (axis === "gap") s.gaps = s.gaps.map((gap, i) => (i < firstGap(s) ? gap : 0));
    else s.balls[0].radius = 0;
    const key = JSON.stringify([s, axis, box]);
    if (key === this.mapKey) return;
    this.mapKey = key;
    this.map.start(this.scenario, axis, box);
    this.dirty.mapPicture = true;
  }

  // ---- drawing ----------------------------------------------------------------------------------------

  private readonly frame = (now: number): void => {
    requestAnimationFrame(this.frame);
    const passed = Math.min((now - this.lastFrame) / 1000, 0.1);
    this.lastFrame = now;
    if (this.dirty.solve) {
      this.dirty.solve = false;
      const begin = performance.now();
      this.resolve();
      this.drawPlots();
      performance.measure("solve", { start: begin });
    }
    if (this.drop && this.playing) this.advance(passed);
    if (!this.timeline.done && this.timeline.work(this.core, 9)) this.dirty.plots = true;
    this.drawPlots();
    if (this.dirty.stage && this.drop) {
      this.dirty.stage = false;
      this.drawFilm();
    }
    const due = this.map.elapsed !== null || this.map.fresh || now - this.mapDrawn > 80; // while workers need the processor
    if (this.dirty.mapPicture && this.drop && due) {
      this.dirty.mapPicture = this.map.fresh = false;
      this.mapDrawn = now;
      this.drawMap();
    }
  };

  private advance(passed: number): void {
    const end = this.clock().length;
    if (this.screen < end) {
      this.screen = Math.min(this.screen + passed, end);
      this.dirty.stage = true;
    } else {
      this.held += passed;
      if (this.held > 2.5) {
        this.screen = this.held = 0;
        this.dirty.stage = true;
      }
    }
  }

  private drawPlots(): void {
    if (!this.dirty.plots || !this.drop) return;
    this.dirty.plots = false;
    const { forces, timelineSheet } = this;
    this.forcesLayout = drawForces(forces.g, forces.width, forces.height, this.drop, this.theme);
    this.timelineLayout = this.timeline.draw(timelineSheet.g, timelineSheet.width, timelineSheet.height, this.drop, this.theme);
    this.placeCursors();
    const s = this.scenario;
    timelineSheet.canvas.setAttribute("aria-valuenow", String(s.restitution));
    const exact = s.law === "linear" && s.balls.length === 2 && !s.cradle;
    find("timeline-hint").textContent =
      (exact ? "Fine edges: the same with the lower ball unaffected by the upper one. " : "") + (s.cradle ? "" : "Dashed: the floor contact ends. ") + "Click chooses ε.";
  }

  private drawFilm(): void {
    const d = this.drop!;
    const time = this.time();
    const [newton] = this.core.sample(Model.newton, [time]);
    const [icm] = this.core.sample(Model.independent, [time]);
    const rate = this.view.slow ? d.clock.rate(time) : 1;
    drawStage(this.stage.g, this.stage.width, this.stage.height, d, { time, rate, newton, icm }, this.theme);
    const scrubber = find<HTMLInputElement>("scrubber");
    scrubber.value = String(Math.round((2000 * this.screen) / this.clock().length));
    const told = clockText(time, d);
    find("time").textContent = `t = ${told}`;
    const slower = 1 / rate;
    const speed = slower < 1.05 ? "real time" : `${slower < 10 ? slower.toFixed(1) : Math.round(Number(slower.toPrecision(2))).toLocaleString("en").replaceAll(",", " ")} × slower than real`;
    find("speed").textContent = speed;
    scrubber.setAttribute("aria-valuetext", `${told}, ${speed}`);
    if (!this.playing || this.stage.canvas.getAttribute("aria-label") === null)
      this.stage.canvas.setAttribute("aria-label", `Animation at ${told}: balls of Newton’s equations beside those of independent collisions`);
    this.placeCursors();
  }

  private placeCursors(): void {
    if (!this.drop) return;
    const time = this.time();
    const place = (box: string, x: Scale, frames: Frame[]): void => {
      find(box).querySelectorAll<HTMLElement>(".cursor").forEach((cursor, i) => {
        const frame = frames[i];
        cursor.hidden = !frame || time < x.low || time > x.high;
        if (cursor.hidden) return;
        cursor.style.transform = `translate(${x.at(time)}px, ${frame.top}px)`;
        cursor.style.height = `${frame.height}px`;
      });
    };
    const f = this.forcesLayout;
    if (f) {
      place("forces-box", f.x, f.frames);
      const share = Math.round((1000 * (time - f.x.low)) / (f.x.high - f.x.low));
      this.forces.canvas.setAttribute("aria-valuenow", String(Math.min(Math.max(share, 0), 1000)));
      if (!this.playing) this.forces.canvas.setAttribute("aria-valuetext", clockText(time, this.drop));
    }
    const t = this.timelineLayout;
    if (t) place("timeline-box", t.x, [t.frame]);
  }

  private marked(): [number, number] {
    const s = this.scenario;
    return [s.restitution, this.view.map.axis === "gap" ? s.gaps[firstGap(s)] : s.balls[0].radius / s.balls[1].radius];
  }

  private drawMap(): void {
    const { mapSheet } = this;
    this.mapLayout = this.map.draw(mapSheet.g, mapSheet.width, mapSheet.height, this.view.map.axis, this.marked(), this.theme);
    this.tellMap();
    mapSheet.canvas.dataset.computing = String(Math.round(this.map.computing));
    mapSheet.canvas.dataset.resolution = String(this.map.resolution);
    if (this.map.elapsed !== null) mapSheet.canvas.dataset.ms = String(Math.round(this.map.elapsed));
    else delete mapSheet.canvas.dataset.ms;
  }

  private tellMap(): void {
    const [e, y] = this.hover ?? this.marked();
    const r = this.map.read(e, y);
    const where = `ε = ${digits(e)}, ${this.view.map.axis === "gap" ? `Δh = ${y > 0 ? withUnit(y, "m") : "0"}` : `R₁/R₂ = ${digits(y)}`}`;
    let what = y > 0 ? "outside the map" : "touching, below the map";
    if (r) {
      what = Number.isNaN(r.count) ? "cannot fall" : r.count === 1 ? "1 contact" : `${r.count} contacts`;
      const value = this.view.map.show === "separation" ? r.separation : r.effective;
      if (!Number.isNaN(value)) what += `, ε_eff/ε = ${digits(value)}`;
    }
    const text = `${where}: ${what}`;
    const out = find("map-reading");
    if (out.dataset.text === text) return;
    out.dataset.text = text;
    out.replaceChildren(...subscripted(text));
  }

  // ---- pointer and keys -------------------------------------------------------------------------------

  private listen(): void {
    find("notes").querySelector("button")!.addEventListener("click", () => this.note([]));
    find("play").addEventListener("click", () => this.play(!this.playing));
    find("slow").addEventListener("click", () => this.setSlow(!this.view.slow));
    find("slow").setAttribute("aria-pressed", String(this.view.slow));
    find("play").textContent = this.playing ? "Pause" : "Play";
    const scrubber = find<HTMLInputElement>("scrubber");
    scrubber.addEventListener("input", () => {
      this.play(false);
      this.screen = (Number(scrubber.value) / 2000) * this.clock().length;
    });
    document.addEventListener("keydown", (e) => this.key(e));
    this.listenForces();
    this.listenTimeline();
    this.listenMap();
    this.listenFiles();
    find("theme").addEventListener("click", () => this.setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.setTheme(null));
  }

  private setTheme(choice: "light" | "dark" | null): void {
    const dark = choice ? choice === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    find("theme").setAttribute("aria-pressed", String(dark));
    this.theme = themeOf(document.documentElement);
    Object.assign(this.dirty, { plots: true, mapPicture: true, stage: true });
  }

  // Keys of the film work anywhere but in a control that uses them itself.
  private key(e: KeyboardEvent): void {
    const target = e.target as HTMLElement;
    if (e.ctrlKey || e.metaKey || e.altKey || !this.drop) return;
    if (target.closest("input, select, button, textarea, a, canvas[tabindex]")) return;
    const step = this.clock().length / 200;
    const actions: Record<string, () => void> = {
      " ": () => this.play(!this.playing),
      ArrowLeft: () => this.step(-step),
      ArrowRight: () => this.step(step),
      Home: () => this.step(-1e9),
      End: () => this.step(1e9),
      s: () => this.setSlow(!this.view.slow),
    };
    const action = actions[e.key.length === 1 ? e.key.toLowerCase() : e.key];
    if (!action) return;
    e.preventDefault();
    action();
  }

  private step(by: number): void {
    this.play(false);
    this.screen = Math.min(Math.max(this.screen + by, 0), this.clock().length);
  }

  private dragged(canvas: HTMLCanvasElement, move: (x: number, y: number) => void): void {
    canvas.addEventListener("pointerdown", (e) => {
      if (e.button !== 0) return;
      canvas.setPointerCapture(e.pointerId);
      move(e.offsetX, e.offsetY);
    });
    canvas.addEventListener("pointermove", (e) => {
      if (canvas.hasPointerCapture(e.pointerId)) move(e.offsetX, e.offsetY);
    });
  }

  private listenForces(): void {
    const { canvas } = this.forces;
    const choose = (time: number): void => {
      if (this.playing) this.play(false);
      this.seek(time);
      this.writeLink();
    };
    this.dragged(canvas, (x) => this.forcesLayout && choose(this.forcesLayout.x.value(x)));
    canvas.addEventListener("keydown", (e) => {
      const f = this.forcesLayout;
      if (!f) return;
      const span = f.x.high - f.x.low;
      const to: Record<string, number> = {
        ArrowLeft: this.time() - span / 200,
        ArrowRight: this.time() + span / 200,
        PageDown: this.time() - span / 20,
        PageUp: this.time() + span / 20,
        Home: f.x.low,
        End: f.x.high,
      };
      if (!(e.key in to)) return;
      e.preventDefault();
      choose(Math.min(Math.max(to[e.key], f.x.low), f.x.high));
    });
  }

  private listenTimeline(): void {
    const { canvas } = this.timelineSheet;
    const choose = (restitution: number): void => {
      this.scenario.restitution = clampTo(ranges.restitution, Number(restitution.toFixed(3)));
      this.edited();
    };
    this.dragged(canvas, (_, y) => this.timelineLayout && choose(this.timelineLayout.y.value(y)));
    canvas.addEventListener("keydown", (e) => {
      const by: Record<string, number> = { ArrowUp: 0.005, ArrowRight: 0.005, ArrowDown: -0.005, ArrowLeft: -0.005, PageUp: 0.05, PageDown: -0.05, Home: -1, End: 1 };
      if (!(e.key in by)) return;
      e.preventDefault();
      choose(this.scenario.restitution + by[e.key]);
    });
  }

  private chooseInMap(restitution: number, y: number): void {
    const s = this.scenario;
    s.restitution = clampTo(ranges.restitution, Number(restitution.toPrecision(4)));
    if (this.view.map.axis === "gap") s.gaps = s.gaps.map((gap, i) => (i < firstGap(s) ? gap : clampTo(ranges.gap, Number(y.toPrecision(4)))));
    else {
      const wanted = clampTo(ranges.radius, Number((y * s.balls[1].radius).toPrecision(6)));
      const before = s.balls[0].radius;
      s.balls[0].radius = wanted;
      if (s.height < lowestHeight(s)) s.balls[0].radius = before;
    }
    this.edited();
  }

  private zoom(factor: number, [e, y] = this.marked()): void {
    const { x, y: v } = this.mapBox();
    const limits = mapLimits(this.view.map.axis);
    const part = (low: number, high: number, at: number, least: number, most: number): [number, number] => {
      const inside = Math.min(Math.max(at, low), high);
      return [Math.max(inside - (inside - low) / factor, least), Math.min(inside + (high - inside) / factor, most)];
    };
    const [y0, y1] = part(Math.log(v[0]), Math.log(v[1]), Math.log(Math.max(y, v[0])), Math.log(limits.y[0]), Math.log(limits.y[1]));
    this.setZoom({ x: part(x[0], x[1], e, ...limits.x), y: [Math.exp(y0), Math.exp(y1)] });
  }

  private setZoom(box: Box | null): void {
    if (box && (box.x[1] - box.x[0] < 1e-6 || box.y[1] / box.y[0] < 1 + 1e-6)) return;
    // As many digits as the link keeps, so that the link shows the same.
    const keep = ([a, b]: [number, number]): [number, number] => [Number(a.toPrecision(6)), Number(b.toPrecision(6))];
    this.view.map.zoom = box && { x: keep(box.x), y: keep(box.y) };
    this.refreshMap();
    this.writeLink();
  }

  private listenMap(): void {
    const { canvas } = this.mapSheet;
    const rubber = find("map-box").querySelector<HTMLElement>(".rubber")!;
    let from: [number, number] | null = null;
    const there = (x: number, y: number): [number, number] => {
      const { frame } = this.mapLayout!;
      const clip = (v: number, low: number, size: number): number => Math.min(Math.max(v, low), low + size);
      return [clip(x, frame.left, frame.width), clip(y, frame.top, frame.height)];
    };
    const value = ([x, y]: [number, number]): [number, number] => [this.mapLayout!.x.value(x), this.mapLayout!.y.value(y)];
    canvas.addEventListener("pointerdown", (e) => {
      if (e.button !== 0 || !this.mapLayout) return;
      from = there(e.offsetX, e.offsetY);
      if (e.pointerType !== "touch") canvas.setPointerCapture(e.pointerId);
    });
    canvas.addEventListener("pointermove", (e) => {
      if (!this.mapLayout) return;
      const at = there(e.offsetX, e.offsetY);
      this.hover = e.pointerType === "touch" ? null : value(at);
      this.tellMap();
      const wide = from !== null && e.pointerType !== "touch" && Math.abs(at[0] - from[0]) > 6 && Math.abs(at[1] - from[1]) > 6;
      rubber.hidden = !wide;
      if (!from || !wide) return;
      rubber.style.transform = `translate(${Math.min(at[0], from[0])}px, ${Math.min(at[1], from[1])}px)`;
      rubber.style.width = `${Math.abs(at[0] - from[0])}px`;
      rubber.style.height = `${Math.abs(at[1] - from[1])}px`;
    });
    canvas.addEventListener("pointerup", (e) => {
      if (!from) return;
      const at = there(e.offsetX, e.offsetY);
      if (rubber.hidden) this.chooseInMap(...value(at));
      else {
        const [a, b] = [value(from), value(at)];
        this.setZoom({ x: [Math.min(a[0], b[0]), Math.max(a[0], b[0])], y: [Math.min(a[1], b[1]), Math.max(a[1], b[1])] });
      }
      rubber.hidden = true;
      from = null;
    });
    canvas.addEventListener("pointercancel", () => {
      from = null;
      rubber.hidden = true;
    });
    canvas.addEventListener("pointerleave", () => {
      this.hover = null;
      this.tellMap();
    });
    canvas.addEventListener(
      "wheel",
      (e) => {
        if (document.activeElement !== canvas || !this.mapLayout) return;
        e.preventDefault();
        this.zoom(e.deltaY < 0 ? 1.25 : 0.8, value(there(e.offsetX, e.offsetY)));
      },
      { passive: false },
    );
    canvas.addEventListener("keydown", (e) => {
      if (!this.mapLayout) return;
      const { x, y } = this.mapLayout;
      const [e0, y0] = this.marked();
      const dx = (x.high - x.low) / 100;
      const dy = (y.high / y.low) ** 0.01;
      const base = Math.max(y0, y.low);
      const actions: Record<string, () => void> = {
        ArrowLeft: () => this.chooseInMap(e0 - dx, base),
        ArrowRight: () => this.chooseInMap(e0 + dx, base),
        ArrowUp: () => this.chooseInMap(e0, base * dy),
        ArrowDown: () => this.chooseInMap(e0, base / dy),
        "+": () => this.zoom(1.6),
        "=": () => this.zoom(1.6),
        "-": () => this.zoom(1 / 1.6),
        "0": () => this.setZoom(null),
      };
      if (!actions[e.key]) return;
      e.preventDefault();
      actions[e.key]();
    });
    find("zoom-in").addEventListener("click", () => this.zoom(1.6));
    find("zoom-out").addEventListener("click", () => this.zoom(1 / 1.6));
    find("zoom-all").addEventListener("click", () => this.setZoom(null));
    find<HTMLSelectElement>("map-show").addEventListener("change", (e) => {
      this.view.map.show = (e.target as HTMLSelectElement).value as View["map"]["show"];
      this.map.setShow(this.view.map.show);
      this.dirty.mapPicture = true;
      this.writeLink();
    });
    find<HTMLSelectElement>("map-axis").addEventListener("change", (e) => {
      this.view.map.axis = (e.target as HTMLSelectElement).value as View["map"]["axis"];
      this.view.map.zoom = null;
      this.refreshMapChoices();
      this.refreshMap();
      this.writeLink();
    });
  }

  private listenFiles(): void {
    const say = (id: string, text: string): void => {
      const button = find(id);
      const before = button.dataset.name ?? button.textContent ?? "";
      button.dataset.name = before;
      button.textContent = text;
      setTimeout(() => (button.textContent = before), 1500);
    };
    find("copy").addEventListener("click", () => {
      history.replaceState(null, "", this.link());
      const done = navigator.clipboard?.writeText(this.link()) ?? Promise.reject(new Error("no clipboard"));
      done.then(() => say("copy", "Copied"), () => say("copy", "In address bar"));
    });
    find("toml").addEventListener("click", () => save("drop.toml", new Blob([toToml(this.scenario)], { type: "application/toml" })));
    find("csv").addEventListener("click", () => {
      if (this.drop) save("drop.csv", new Blob([csv(this.core, this.drop)], { type: "text/csv" }));
    });
    find("png").addEventListener("click", () => {
      const asked = performance.now();
      const attempt = (): void => {
        // The map is worth a short wait.
        if (this.map.elapsed === null && performance.now() - asked < 3000) setTimeout(attempt, 50);
        else if (this.drop) this.picture().toBlob((blob) => blob && save("drop.png", blob), "image/png");
      };
      attempt();
    });
  }

  // All pictures on one sheet, at twice the screen's resolution, with the parameters below.
  private picture(): HTMLCanvasElement {
    const canvas = document.createElement("canvas");
    const [width, height] = [1600, 1200];
    canvas.width = 2 * width;
    canvas.height = 2 * height;
    const g = canvas.getContext("2d")!;
    g.scale(2, 2);
    g.fillStyle = this.theme.ground;
    g.fillRect(0, 0, width, height);
    const d = this.drop!;
    const time = this.time();
    const part = (x: number, y: number, w: number, h: number, draw: (g: CanvasRenderingContext2D) => void): void => {
      const sheet = document.createElement("canvas");
      sheet.width = 2 * w;
      sheet.height = 2 * h;
      const own = sheet.getContext("2d")!;
      own.scale(2, 2);
      draw(own);
      g.drawImage(sheet, x, y, w, h);
    };
    const [newton] = this.core.sample(Model.newton, [time]);
    const [icm] = this.core.sample(Model.independent, [time]);
    const rate = this.view.slow ? d.clock.rate(time) : 1;
    part(20, 96, 770, 540, (own) => drawStage(own, 770, 540, d, { time, rate, newton, icm }, this.theme));
    part(820, 96, 760, 540, (own) => void drawForces(own, 760, 540, d, this.theme));
    part(20, 656, 770, 460, (own) => void this.timeline.draw(own, 770, 460, d, this.theme));
    part(820, 656, 760, 460, (own) => void this.map.draw(own, 760, 460, this.view.map.axis, this.marked(), this.theme));
    g.textBaseline = "alphabetic";
    g.font = `600 26px ${this.theme.font}`;
    const [said, saidByIcm] = verdict(d, this.core);
    g.fillStyle = this.theme.newton;
    g.fillText(said, 20, 36);
    g.fillStyle = this.theme.icm;
    g.fillText(saidByIcm, 20, 70);
    g.font = `400 17px ${this.theme.font}`;
    g.fillStyle = this.theme.muted;
    const s = this.scenario;
    const radii = s.balls.map((b) => withUnit(b.radius, "m")).join(", ");
    const gaps = s.gaps.map((x) => withUnit(x, "m")).join(", ");
    const law = constantsOf(s).map((name) => `${constants[name].symbol} = ${withUnit(s.constants[name], constants[name].range.unit)}`).join(", ");
    g.fillText(`ε = ${s.restitution}, radii ${radii}, gaps ${gaps}, ${s.cradle ? "cradle" : `height ${withUnit(s.height, "m")}`}, ${law}; pictured at t = ${clockText(time, d)}`, 20, 1150);
    g.fillText("hardlimit, after Müller & Pöschel, Phys. Rev. E 83, 041304 (2011)", 20, 1178);
    return canvas;
  }
}

// In the unit of the contacts while they last, in seconds before and after.
function clockText(time: number, d: Drop): string {
  const span = d.to - d.from;
  const near = time > d.from - 2 * span && time < d.to + 2 * span;
  if (!near) return `${(time - d.origin).toFixed(3).replace("-", "−")} s`;
  const [factor, unit] = span < 2e-6 ? [1e9, "ns"] : span < 2e-3 ? [1e6, "µs"] : [1e3, "ms"];
  const places = span * factor < 10 ? 3 : span * factor < 100 ? 2 : 1;
  return `${((time - d.origin) * factor).toFixed(places).replace("-", "−")} ${unit}`;
}

async function begin(): Promise<void> {
  const response = fetch(new URL("core.wasm", import.meta.url));
  const module = await WebAssembly.compileStreaming(response).catch(async () => WebAssembly.compile(await (await fetch(new URL("core.wasm", import.meta.url))).arrayBuffer()));
  new Page(new Core(module), module);
}

begin().catch((error: unknown) => {
  find("verdict").textContent = `The page could not start: ${String(error)}`;
  throw error;
});
