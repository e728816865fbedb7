// The panel of the map: drawing, reading values, pointer, zoom.
import { find, type Sheet } from "../support/dom";
import { digits, withUnit } from "../support/format";
import { ContactMap } from "./map";
import type { MapLayout } from "./map_drawing";
import { linked, panned, tooSmall, zoomed } from "./map_box";
import { Agreement } from "./trust";
import { subscripted } from "../views/numbers";
import type { Pool } from "../core/pool";
import { clampTo, columnOf, copyOf, firstGap, lowestHeight, ranges } from "../scenario/scenario";
import type { State } from "../app/state";
import { moved } from "../support/touch";
import { mapLimits, wholeMap, type Box, type View } from "../app/view";

type Point = [number, number]; // ε, and gap [m] or R1/R2; or a position in pixels

export class MapPanel {
  readonly map: ContactMap;
  private readonly agreement: Agreement;
  private layout: MapLayout | null = null;
  private key = "";
  private drawn = 0;
  private hover: Point | null = null; // parameters that a click would choose
  private read = { place: "", text: "" }; // value of the map there
  private reading = false;
  private later = 0; // timer of the next refresh
  private moving = false; // the picture moves before new points are computed

  constructor(
    private readonly state: State,
    private readonly sheet: Sheet,
    private readonly pool: Pool,
  ) {
    this.map = new ContactMap(pool, () => (state.dirty.mapPicture = true), sheet.wanted);
    this.agreement = new Agreement(pool, () => (state.dirty.mapPicture = true));
    this.map.setShow(state.view.map.show);
    this.listenPointer();
    this.listenKeys();
    this.listenChoices();
  }

  // ---- what is shown ----------------------------------------------------------------------------------

  // Maps available for this scenario.
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

  // The map of ε_eff/ε over the gap, if available.
  showTrusted(): void {
    const { view, scenario } = this.state;
    const pair = scenario.balls.length === 2 && !scenario.cradle;
    Object.assign(view.map, { axis: "gap", zoom: null, show: pair ? "effective" : "count" });
    const { x, y } = this.box();
    this.showAs({ ...view.map, zoom: { x, y: [y[0], Number((3 * y[1]).toPrecision(6))] } }); // extended towards the region of agreement
  }

  showAs(map: View["map"]): void {
    Object.assign(this.state.view.map, map);
    this.map.setShow(map.show);
    this.refreshChoices();
    this.refresh();
    this.state.dirty.mapPicture = true;
  }

  // Gap above which both models agree for the present ε; infinite: none in the map, null: no map yet.
  trusted(): number | null {
    const { view, scenario } = this.state;
    if (view.map.show === "count" || view.map.axis !== "gap") return null;
    const { points } = this.agreement;
    if (points.length === 0) return null;
    return points.reduce((a, b) => (Math.abs(b.restitution - scenario.restitution) < Math.abs(a.restitution - scenario.restitution) ? b : a)).gap;
  }

  // Restarts if the map does not show this scenario.
  refresh(): void {
    const { drop, scenario, view } = this.state;
    if (!drop) return;
    this.read.place = "";
    this.moving = false;
    this.state.dirty.mapPicture = true;
    const box = this.box();
    const { axis } = view.map;
    const s = copyOf(scenario);
    s.restitution = 0;
    if (axis === "gap") s.gaps = s.gaps.map((gap, i) => (i < firstGap(s) ? gap : 0));
    else s.balls[0].radius = 0;
    const key = JSON.stringify([s, axis]);
    if (key + JSON.stringify(box) === this.key) return;
    const keep = this.key.startsWith(key); // the same map, elsewhere
    this.key = key + JSON.stringify(box);
    this.map.start(scenario, axis, box, keep);
    this.state.dirty.mapPicture = true;
  }

  // Draws if necessary, less often while the workers compute.
  drawIfDue(now: number): void {
    const { dirty, drop } = this.state;
    const due = this.map.elapsed !== null || this.map.fresh || now - this.drawn > 80;
    if (!dirty.mapPicture || !drop || !due) return;
    if (!this.sheet.shown()) return this.findAgreement();
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

  // Where the models agree, once the map is complete.
  private findAgreement(): void {
    const { scenario, view } = this.state;
    if (this.map.elapsed !== null && view.map.axis === "gap" && view.map.show !== "count") this.agreement.refresh(scenario, this.box(), view.tolerance);
  }

  private draw(): void {
    const { sheet, state, map } = this;
    const { axis, show } = state.view.map;
    const agreement = axis === "gap" && show !== "count" ? this.agreement : null;
    this.findAgreement();
    this.layout = map.draw(sheet.g, sheet.width, sheet.height, axis, this.marked(), state.theme, agreement, this.box());
    this.tell();
    const { dataset } = sheet.canvas;
    dataset.computing = String(Math.round(map.computing));
    dataset.resolution = String(map.resolution);
    if (map.elapsed !== null && !this.moving) dataset.ms = String(Math.round(map.elapsed));
    else delete dataset.ms;
    find("map-state").textContent =
      map.elapsed === null ? `${Math.floor(100 * map.progress)} % computed` : `${map.resolution} × ${map.resolution} points in ${digits(map.elapsed / 1000, 2)} s`;
  }

  // The result at a point, computed with the parameters that a click would set.
  private reader(): void {
    const { scenario, view } = this.state;
    if (this.reading || !this.hover) return;
    const [e, y] = this.hover;
    const place = `${e} ${y}`;
    if (place === this.read.place) return;
    this.reading = true;
    const { show, axis } = view.map;
    const ask = { column: columnOf(scenario), axis: axis === "gap" ? 0 : 1, points: Float64Array.of(e, y) };
    this.pool.ask("points", ask).then(
      ([count, effective, separation]) => {
        this.reading = false;
        this.read = { place, text: Number.isNaN(count) ? "cannot fall" : counted(count, show === "separation" ? separation : effective) };
        this.tell();
      },
      () => (this.reading = false),
    );
  }

  // The value under the pointer, or that of the present scenario.
  private tell(): void {
    const { view, drop } = this.state;
    const [e, y] = this.hover ?? this.marked();
    const where = `ε = ${digits(e)}, ${view.map.axis === "gap" ? `Δh = ${y > 0 ? withUnit(y, "m") : "0"}` : `R₁/R₂ = ${digits(y)}`}`;
    let what = "…";
    if (this.hover) {
      this.reader();
      if (this.read.place === `${e} ${y}`) what = this.read.text;
    } else if (drop) {
      const { nContacts, effective, effectiveSeparation } = drop.newton.run;
      what = counted(nContacts, (view.map.show === "separation" ? effectiveSeparation : effective) / drop.scenario.restitution);
      if (!this.map.shows(e, y)) what += y > 0 ? " (outside the map)" : " (touching: below the map)";
    }
    const text = `${where}: ${what}`;
    const out = find("map-reading");
    if (out.dataset.text === text) return;
    out.dataset.text = text;
    out.replaceChildren(...subscripted(text));
  }

  // ---- changes ----------------------------------------------------------------------------------------

  // The point of the map as parameters: rounded and within their ranges.
  private rounded(restitution: number, y: number): Point {
    const { scenario: s, view } = this.state;
    const e = clampTo(ranges.restitution, Number(restitution.toPrecision(4)));
    if (view.map.axis === "gap") return [e, clampTo(ranges.gap, Number(y.toPrecision(4)))];
    return [e, clampTo(ranges.radius, Number((y * s.balls[1].radius).toPrecision(6))) / s.balls[1].radius];
  }

  private choose(restitution: number, at: number): void {
    const { scenario: s, view } = this.state;
    const [e, y] = this.rounded(restitution, at);
    s.restitution = e;
    if (view.map.axis === "gap") s.gaps = s.gaps.map((gap, i) => (i < firstGap(s) ? gap : y));
    else {
      const before = s.balls[0].radius;
      s.balls[0].radius = y * s.balls[1].radius;
      if (s.height < lowestHeight(s)) s.balls[0].radius = before;
    }
    this.state.edited();
  }

  private zoom(factor: number, at = this.marked()): void {
    this.setZoom(zoomed(this.box(), mapLimits(this.state.view.map.axis), factor, at));
  }

  // By fractions of the frame.
  private pan(right: number, up: number): void {
    this.setZoom(panned(this.box(), mapLimits(this.state.view.map.axis), right, up));
  }

  // The picture moves at once; new points are computed when the pointer rests.
  private setZoom(box: Box | null): void {
    if (box && tooSmall(box)) return;
    this.state.view.map.zoom = box && linked(box);
    this.state.dirty.mapPicture = this.map.fresh = true;
    this.moving = true;
    clearTimeout(this.later);
    this.later = window.setTimeout(() => this.refresh(), 120);
    this.state.writeLink();
  }

  // ---- pointer and keys -------------------------------------------------------------------------------

  private listenPointer(): void {
    const rubber = find("map-box").querySelector<HTMLElement>(".rubber")!;
    const there = (x: number, y: number): Point => {
      const { frame } = this.layout!;
      const clip = (v: number, low: number, size: number): number => Math.min(Math.max(v, low), low + size);
      return [clip(x, frame.left, frame.width), clip(y, frame.top, frame.height)];
    };
    const value = (x: number, y: number): Point => {
      const [px, py] = there(x, y);
      return [this.layout!.x.value(px), this.layout!.y.value(py)];
    };
    moved(this.sheet.canvas, {
      choose: (x, y) => this.layout && this.choose(...value(x, y)),
      pan: (dx, dy) => this.layout && this.pan(dx / this.layout.frame.width, -dy / this.layout.frame.height),
      zoom: (factor, x, y) => this.layout && this.zoom(factor, value(x, y)),
      hover: (at) => {
        this.hover = at && this.layout ? this.rounded(...value(...at)) : null;
        this.tell();
      },
      frame: (from, to, done) => {
        if (!this.layout) return;
        const [[x0, y0], [x1, y1]] = [there(...from), there(...to)];
        const wide = Math.abs(x1 - x0) > 6 && Math.abs(y1 - y0) > 6;
        rubber.hidden = done || !wide;
        rubber.style.transform = `translate(${Math.min(x0, x1)}px, ${Math.min(y0, y1)}px)`;
        rubber.style.width = `${Math.abs(x1 - x0)}px`;
        rubber.style.height = `${Math.abs(y1 - y0)}px`;
        if (!done || !wide) return;
        const [a, b] = [value(...from), value(...to)];
        this.setZoom({ x: [Math.min(a[0], b[0]), Math.max(a[0], b[0])], y: [Math.min(a[1], b[1]), Math.max(a[1], b[1])] });
      },
    });
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
      this.read.place = "";
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

const counted = (contacts: number, ratio: number): string =>
  `${contacts === 1 ? "1 contact" : `${contacts} contacts`}${Number.isNaN(ratio) ? "" : `, ε_eff/ε = ${digits(ratio)}`}`;
