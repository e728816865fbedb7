// The panel of the map: what it shows, its drawing, its choices.
import { find, setText, type Sheet } from "../support/dom";
import { digits } from "../support/format";
import { ContactMap } from "./map";
import type { MapLayout } from "./map_drawing";
import { linked, panned, tooSmall, zoomed } from "./map_box";
import { Agreement } from "./trust";
import { listen, type Point } from "./map_input";
import { MapReading } from "./map_reading";
import type { Pool } from "../core/pool";
import type { Trusted } from "../report/facts";
import { clampTo, copyOf, firstGap, lowestHeight, ranges } from "../scenario/scenario";
import { observed, type Drawing } from "../state/signals";
import type { State } from "../state/state";
import { mapLimits, wholeMap, type Box, type View } from "../scenario/view";

export class MapPanel {
  readonly map: ContactMap;
  private readonly agreement: Agreement;
  private layout: MapLayout | null = null;
  private key = "";
  private drawn = -Infinity; // time of the last drawing [ms]; −∞: draw at once
  private readonly picture: Drawing;
  private readonly reading: MapReading;
  private later = 0; // timer of the next refresh
  private moving = false; // the picture moves before new points are computed

  constructor(
    private readonly state: State,
    private readonly sheet: Sheet,
    pool: Pool,
  ) {
    this.map = new ContactMap(pool, sheet.wanted);
    this.agreement = new Agreement(pool);
    observed(this, ["moving"]);
    this.picture = state.drawing(() => this.draw());
    this.map.setShow(state.view.map.show);
    this.reading = new MapReading(state, pool, this.map, () => this.marked());
    listen(sheet.canvas, find("map-box").querySelector<HTMLElement>(".rubber")!, {
      layout: () => this.layout,
      marked: () => this.marked(),
      choose: (point) => this.choose(...point),
      pan: (right, up) => this.pan(right, up),
      zoom: (factor, at) => this.zoom(factor, at),
      frame: (box) => this.setZoom(box),
      hover: (point) => this.reading.hover(point && this.rounded(...point)),
    });
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
    if (axis.value !== view.map.axis) axis.value = view.map.axis;
    if (show.value !== view.map.show) show.value = view.map.show;
    setText(
      find("map-title"),
      view.map.axis === "gap" ? "Every ε and every gap" : "Every ε and every size of the lower ball",
    );
  }

  // The map of ε_eff/ε over the gap, if available.
  showTrusted(): void {
    const { view, scenario } = this.state;
    const pair = scenario.balls.length === 2 && !scenario.cradle;
    Object.assign(view.map, { axis: "gap", zoom: null, show: pair ? "effective" : "count" });
    const { x, y } = this.box();
    // Extended towards the region of agreement.
    this.showAs({ ...view.map, zoom: { x, y: [y[0], Number((3 * y[1]).toPrecision(6))] } });
  }

  showAs(map: View["map"]): void {
    Object.assign(this.state.view.map, map);
    this.map.setShow(map.show);
    this.refreshChoices();
    this.refresh();
  }

  // Gap above which both models agree for the present ε; null: not computed.
  trusted(): Trusted | null {
    const { view } = this.state;
    if (view.map.show === "count" || view.map.axis !== "gap" || !this.agreement.present) return null;
    return { gap: this.agreement.present.gap, widest: this.box().y[1] };
  }

  // Restarts if the map does not show this scenario.
  refresh(): void {
    const { drop, scenario, view } = this.state;
    if (!drop) return;
    this.reading.forget();
    this.moving = false;
    const box = this.box();
    const { axis } = view.map;
    const s = copyOf(scenario);
    s.restitution = 0;
    if (axis === "gap") s.gaps = s.gaps.map((gap, i) => (i < firstGap(s) ? gap : 0));
    else s.balls[0].radius = 0;
    const key = JSON.stringify([s, axis]);
    if (key + JSON.stringify(box) === this.key) return;
    const keep = this.key.startsWith(key); // another part of the same map
    this.key = key + JSON.stringify(box);
    this.map.start(scenario, axis, box, keep);
    this.drawn = -Infinity;
    delete this.sheet.canvas.dataset.ms;
  }

  // Draws if necessary, less often while the workers compute.
  drawIfDue(now: number): void {
    if (!this.state.drop || (this.map.elapsed === null && now - this.drawn <= 80)) return;
    if (!this.sheet.shown()) return this.findAgreement();
    if (!this.sheet.seen && this.map.elapsed === null) return this.tellState();
    if (this.picture.refresh()) this.drawn = now;
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

  // Computes the region of agreement after the map.
  private findAgreement(): void {
    const { scenario, view } = this.state;
    if (this.map.elapsed !== null && view.map.axis === "gap" && view.map.show !== "count")
      this.agreement.refresh(scenario, this.box(), view.tolerance);
  }

  private draw(): void {
    const { sheet, state, map } = this;
    const { axis, show } = state.view.map;
    const agreement = axis === "gap" && show !== "count" ? this.agreement : null;
    this.findAgreement();
    this.layout = map.draw(sheet.g, sheet.width, sheet.height, axis, this.marked(), state.theme, agreement, this.box());
    this.reading.write();
    const { dataset } = sheet.canvas;
    dataset.computing = String(Math.round(map.computing));
    dataset.resolution = String(map.resolution);
    if (map.elapsed !== null && !this.moving) dataset.ms = String(Math.round(map.elapsed));
    else delete dataset.ms;
    this.tellState();
  }

  private tellState(): void {
    const { elapsed, progress, resolution } = this.map;
    setText(
      find("map-state"),
      elapsed === null
        ? `${Math.floor(100 * progress)} % computed`
        : `${resolution} × ${resolution} points in ${digits(elapsed / 1000, 2)} s`,
    );
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

  // The picture moves at once; new points are computed when the pointer stops.
  private setZoom(box: Box | null): void {
    if (box && tooSmall(box)) return;
    this.state.view.map.zoom = box && linked(box);
    this.drawn = -Infinity;
    this.moving = true;
    clearTimeout(this.later);
    this.later = window.setTimeout(() => this.refresh(), 120);
    this.state.writeLink();
  }

  private listenChoices(): void {
    const { view } = this.state;
    find("zoom-in").addEventListener("click", () => this.zoom(1.6));
    find("zoom-out").addEventListener("click", () => this.zoom(1 / 1.6));
    find("zoom-all").addEventListener("click", () => this.setZoom(null));
    find<HTMLSelectElement>("map-show").addEventListener("change", (e) => {
      view.map.show = (e.target as HTMLSelectElement).value as View["map"]["show"];
      this.map.setShow(view.map.show);
      this.reading.forget();
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
