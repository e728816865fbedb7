// The map beside its choices: drawn, read, pointed at, zoomed.
import { find, type Sheet } from "./dom";
import { digits, withUnit } from "./format";
import { ContactMap, type MapLayout } from "./map";
import { subscripted } from "./numbers";
import { clampTo, copyOf, firstGap, lowestHeight, ranges } from "./scenario";
import type { State } from "./state";
import { mapLimits, wholeMap, type Box, type View } from "./view";

type Point = [number, number]; // ε, and gap [m] or R1/R2; or a place in pixels

export class MapPanel {
  readonly map: ContactMap;
  private layout: MapLayout | null = null;
  private key = "";
  private drawn = 0;
  private hover: Point | null = null;

  constructor(
    private readonly state: State,
    private readonly sheet: Sheet,
    module: WebAssembly.Module,
  ) {
    this.map = new ContactMap(module, new URL("worker.js", import.meta.url).href, () => {
      state.dirty.mapPicture = true;
    });
    this.map.setShow(state.view.map.show);
    this.listenPointer();
    this.listenKeys();
    this.listenChoices();
  }

  // ---- what is shown ----------------------------------------------------------------------------------

  // Which maps there are for this scenario.
  refreshChoices(): void {
    const { scenario: s, view } = this.state;
    const axis = find<HTMLSelectElement>("map-axis");
    axis.options[1].disabled = s.cradle;
    if (s.cradle) view.map.axis = "gap";
    const show = find<HTMLSelectElement>("map-show");
    const pairOnly = s.balls.length !== 2 || s.cradle;
    for (const i of [1, 2]) show.options[i].disabled = pairOnly;
    if (pairOnly && view.map.show !== "count") {
      view.map.show = "count";
      this.map.setShow("count");
    }
    axis.value = view.map.axis;
    show.value = view.map.show;
    find("map-title").textContent = view.map.axis === "gap" ? "Every ε and every gap" : "Every ε and every size of the lower ball";
  }

  // Begins anew where the map does not show this scenario yet.
  refresh(): void {
    const { drop, scenario, view } = this.state;
    if (!drop) return;
    const box = this.box();
    const { axis } = view.map;
    const s = copyOf(scenario);
    s.restitution = 0;
    if (axis === "gap") s.gaps = s.gaps.map((gap, i) => (i < firstGap(s) ? gap : 0));
    else s.balls[0].radius = 0;
    const key = JSON.stringify([s, axis, box]);
    if (key === this.key) return;
    this.key = key;
    this.map.start(scenario, axis, box);
    this.state.dirty.mapPicture = true;
  }

  // Draws if it is due: seldom while the workers need the processor.
  drawIfDue(now: number): void {
    const { dirty, drop } = this.state;
    const due = this.map.elapsed !== null || this.map.fresh || now - this.drawn > 80;
    if (!dirty.mapPicture || !drop || !due) return;
    dirty.mapPicture = this.map.fresh = false;
    this.drawn = now;
    this.draw();
  }

  marked(): Point {
    const { scenario: s, view } = this.state;
    return [s.restitution, view.map.axis === "gap" ? s.gaps[firstGap(s)] : s.balls[0].radius / s.balls[1].radius];
  }

  private box(): Box {
    const { scenario, view, drop } = this.state;
    const { run } = drop!.newton;
    const floor = Number.isFinite(run.tFloorEnd) ? run.tFloorEnd : drop!.to - drop!.from;
    const speed = scenario.cradle ? Math.max(...scenario.velocities.map(Math.abs)) : run.impactSpeed;
    return view.map.zoom ?? wholeMap(scenario, view.map.axis, floor, speed);
  }

  private draw(): void {
    const { sheet, state, map } = this;
    this.layout = map.draw(sheet.g, sheet.width, sheet.height, state.view.map.axis, this.marked(), state.theme);
    this.tell();
    sheet.canvas.dataset.computing = String(Math.round(map.computing));
    sheet.canvas.dataset.resolution = String(map.resolution);
    if (map.elapsed !== null) sheet.canvas.dataset.ms = String(Math.round(map.elapsed));
    else delete sheet.canvas.dataset.ms;
  }

  // The reading under the pointer, else of the present scenario.
  private tell(): void {
    const { map: shown } = this.state.view;
    const [e, y] = this.hover ?? this.marked();
    const r = this.map.read(e, y);
    const where = `ε = ${digits(e)}, ${shown.axis === "gap" ? `Δh = ${y > 0 ? withUnit(y, "m") : "0"}` : `R₁/R₂ = ${digits(y)}`}`;
    let what = y > 0 ? "outside the map" : "touching, below the map";
    if (r) {
      what = Number.isNaN(r.count) ? "cannot fall" : r.count === 1 ? "1 contact" : `${r.count} contacts`;
      const value = shown.show === "separation" ? r.separation : r.effective;
      if (!Number.isNaN(value)) what += `, ε_eff/ε = ${digits(value)}`;
    }
    const text = `${where}: ${what}`;
    const out = find("map-reading");
    if (out.dataset.text === text) return;
    out.dataset.text = text;
    out.replaceChildren(...subscripted(text));
  }

  // ---- what changes it --------------------------------------------------------------------------------

  private choose(restitution: number, y: number): void {
    const { scenario: s, view } = this.state;
    s.restitution = clampTo(ranges.restitution, Number(restitution.toPrecision(4)));
    if (view.map.axis === "gap") s.gaps = s.gaps.map((gap, i) => (i < firstGap(s) ? gap : clampTo(ranges.gap, Number(y.toPrecision(4)))));
    else {
      const wanted = clampTo(ranges.radius, Number((y * s.balls[1].radius).toPrecision(6)));
      const before = s.balls[0].radius;
      s.balls[0].radius = wanted;
      if (s.height < lowestHeight(s)) s.balls[0].radius = before;
    }
    this.state.edited();
  }

  private zoom(factor: number, [e, y] = this.marked()): void {
    const { x, y: v } = this.box();
    const limits = mapLimits(this.state.view.map.axis);
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
    this.state.view.map.zoom = box && { x: keep(box.x), y: keep(box.y) };
    this.refresh();
    this.state.writeLink();
  }

  // ---- pointer and keys -------------------------------------------------------------------------------

  private listenPointer(): void {
    const { canvas } = this.sheet;
    const rubber = find("map-box").querySelector<HTMLElement>(".rubber")!;
    let from: Point | null = null;
    const there = (x: number, y: number): Point => {
      const { frame } = this.layout!;
      const clip = (v: number, low: number, size: number): number => Math.min(Math.max(v, low), low + size);
      return [clip(x, frame.left, frame.width), clip(y, frame.top, frame.height)];
    };
    const value = ([x, y]: Point): Point => [this.layout!.x.value(x), this.layout!.y.value(y)];
    canvas.addEventListener("pointerdown", (e) => {
      if (e.button !== 0 || !this.layout) return;
      from = there(e.offsetX, e.offsetY);
      if (e.pointerType !== "touch") canvas.setPointerCapture(e.pointerId);
    });
    canvas.addEventListener("pointermove", (e) => {
      if (!this.layout) return;
      const at = there(e.offsetX, e.offsetY);
      this.hover = e.pointerType === "touch" ? null : value(at);
      this.tell();
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
      if (rubber.hidden) this.choose(...value(at));
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
      this.tell();
    });
    canvas.addEventListener(
      "wheel",
      (e) => {
        if (document.activeElement !== canvas || !this.layout) return;
        e.preventDefault();
        this.zoom(e.deltaY < 0 ? 1.25 : 0.8, value(there(e.offsetX, e.offsetY)));
      },
      { passive: false },
    );
  }

  private listenKeys(): void {
    this.sheet.canvas.addEventListener("keydown", (e) => {
      if (!this.layout) return;
      const { x, y } = this.layout;
      const [e0, y0] = this.marked();
      const dx = (x.high - x.low) / 100;
      const dy = (y.high / y.low) ** 0.01;
      const base = Math.max(y0, y.low);
      const actions: Record<string, () => void> = {
        ArrowLeft: () => this.choose(e0 - dx, base),
        ArrowRight: () => this.choose(e0 + dx, base),
        ArrowUp: () => this.choose(e0, base * dy),
        ArrowDown: () => this.choose(e0, base / dy),
        "+": () => this.zoom(1.6),
        "=": () => this.zoom(1.6),
        "-": () => this.zoom(1 / 1.6),
        "0": () => this.setZoom(null),
      };
      if (!actions[e.key]) return;
      e.preventDefault();
      actions[e.key]();
    });
  }

  private listenChoices(): void {
    const { view, dirty } = this.state;
    find("zoom-in").addEventListener("click", () => this.zoom(1.6));
    find("zoom-out").addEventListener("click", () => this.zoom(1 / 1.6));
    find("zoom-all").addEventListener("click", () => this.setZoom(null));
    find<HTMLSelectElement>("map-show").addEventListener("change", (e) => {
      view.map.show = (e.target as HTMLSelectElement).value as View["map"]["show"];
      this.map.setShow(view.map.show);
      dirty.mapPicture = true;
      this.state.writeLink();
    });
    find<HTMLSelectElement>("map-axis").addEventListener("change", (e) => {
      view.map.axis = (e.target as HTMLSelectElement).value as View["map"]["axis"];
      view.map.zoom = null;
      this.refreshChoices();
      this.refresh();
      this.state.writeLink();
    });
  }
}
