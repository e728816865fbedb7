// The panel of the map: what it shows, its drawing, its choices.
import { changes, find, setText, type Sheet } from "../support/dom";
import { digits } from "../support/format";
import { ContactMap } from "./map";
import type { MapLayout } from "./map_drawing";
import { linked, panned, tooSmall, zoomed } from "./map_box";
import { Agreement } from "./trust";
import { listen, type Point } from "./map_input";
import { MapReading } from "./map_reading";
import type { Pool } from "../core/pool";
import type { Trusted } from "../report/facts";
import { axes, hasAxis, mapAxes, placed, type MapAxis } from "../scenario/axes";
import { lowestHeight, type Scenario } from "../scenario/scenario";
import { scaleOf } from "../views/rebound";
import { observed, type Drawing } from "../state/signals";
import type { State } from "../state/state";
import type { Theme } from "../style/theme";
import { mapLimits, wholeMap, widened, type Box, type View } from "../scenario/view";

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
    if (!hasAxis(s, view.map.axis)) view.map.axis = view.map.across === "gap" ? "e" : "gap";
    if (!hasAxis(s, view.map.across)) view.map.across = view.map.axis === "e" ? "gap" : "e";
    for (const key of ["axis", "across"] as const) this.fillAxes(find(`map-${key}`), view.map[key]);
    const show = find<HTMLSelectElement>("map-show");
    const pairOnly = s.balls.length !== 2 || s.cradle;
    for (const i of [1, 2]) show.options[i].disabled = pairOnly;
    if (pairOnly && show.querySelector(`[value=${view.map.show}]:disabled`)) {
      view.map.show = "count";
      this.map.setShow("count");
    }
    if (show.value !== view.map.show) show.value = view.map.show;
    setText(find("map-title"), `Every ${axes[view.map.across].noun} and every ${axes[view.map.axis].noun}`);
  }

  // The names of axes depend on the contact law.
  private fillAxes(select: HTMLSelectElement, chosen: MapAxis): void {
    const { scenario: s } = this.state;
    const options = mapAxes.map((axis) => [axes[axis].title(s), axis, hasAxis(s, axis)] as const);
    if (changes(select, JSON.stringify(options)))
      select.replaceChildren(
        ...options.map(([title, axis, has]) => Object.assign(new Option(title, axis), { disabled: !has })),
      );
    if (select.value !== chosen) select.value = chosen;
  }

  // The map of ε_eff/ε over the gap, if available.
  showTrusted(): void {
    const { view, scenario, drop } = this.state;
    const pair = scenario.balls.length === 2 && !scenario.cradle;
    Object.assign(view.map, { axis: "gap", across: "e", zoom: null, show: pair ? "effective" : "count" });
    this.showAs({ ...view.map, zoom: widened(scenario, ...scaleOf(drop!)) });
  }

  showAs(map: View["map"]): void {
    Object.assign(this.state.view.map, map);
    this.map.setShow(map.show);
    this.refreshChoices();
    this.refresh();
  }

  // Gap above which both models agree for the present ε; null: not computed.
  trusted(): Trusted | null {
    if (!this.hasLine || !this.agreement.present) return null;
    return { gap: this.agreement.present.gap, widest: this.box().y[1] };
  }

  // Restarts if the map does not show this scenario.
  refresh(): void {
    const { drop, scenario, view } = this.state;
    if (!drop) return;
    this.reading.forget();
    this.moving = false;
    const box = this.box();
    const { axis, across, show } = view.map;
    const tolerance = show === "verdict" ? view.tolerance : null;
    const key = JSON.stringify([this.rest(), across, axis, tolerance], rounded);
    if (key + JSON.stringify(box) === this.key) return;
    const keep = this.key.startsWith(key); // another part of the same map
    this.key = key + JSON.stringify(box);
    this.map.start(scenario, this.axes, tolerance, box, keep);
    this.drawn = -Infinity;
    delete this.sheet.canvas.dataset.ms;
  }

  // The setting without what the axes change.
  private rest(): object {
    const { scenario: s } = this.state;
    const names = this.axes;
    const own = Object.entries(s.own).map(([name, values]) => values.map((x) => x / s.constants[name]));
    const rest = placed(
      { ...s, height: Infinity },
      names.map((name) => [name, 1]),
    );
    return { ...rest, own: names.includes("k") ? own : s.own, height: names.includes("h") ? 0 : s.height };
  }

  // Draws if necessary, less often while the workers compute.
  drawIfDue(now: number): void {
    if (!this.state.drop || (this.map.elapsed === null && now - this.drawn <= 80)) return;
    if (!this.sheet.shown()) return this.findAgreement();
    if (!this.sheet.seen && this.map.elapsed === null) return this.tellState();
    if (this.picture.refresh()) this.drawn = now;
  }

  marked(): Point {
    const { scenario } = this.state;
    const [x, y] = this.axes;
    return [axes[x].get(scenario), axes[y].get(scenario)];
  }

  private get axes(): [MapAxis, MapAxis] {
    const { across, axis } = this.state.view.map;
    return [across, axis];
  }
  private get logs(): [boolean, boolean] {
    const [x, y] = this.axes;
    return [axes[x].log, axes[y].log];
  }
  // The line of agreement belongs to the gap over ε.
  private get hasLine(): boolean {
    const { axis, across, show } = this.state.view.map;
    return axis === "gap" && across === "e" && show !== "count" && show !== "verdict";
  }

  private get lineShown(): Agreement | null {
    return this.hasLine ? this.agreement : null;
  }

  private box(): Box {
    const { scenario, view, drop } = this.state;
    return view.map.zoom ?? wholeMap(scenario, view.map.axis, ...scaleOf(drop!), view.map.across);
  }

  // Computes the region of agreement after the map.
  private findAgreement(): void {
    const { scenario, view } = this.state;
    if (this.map.elapsed !== null && this.hasLine) this.agreement.refresh(scenario, this.box(), view.tolerance);
  }

  private draw(): void {
    const { sheet, state, map } = this;
    this.findAgreement();
    this.layout = this.paint(sheet.g, sheet.width, sheet.height, state.theme);
    this.reading.write();
    setText(find("map-words"), map.inWords(state.view.map.show, this.lineShown));
    const { dataset } = sheet.canvas;
    dataset.computing = String(Math.round(map.computing));
    dataset.resolution = String(map.resolution);
    if (map.elapsed !== null && !this.moving) dataset.ms = String(Math.round(map.elapsed));
    else delete dataset.ms;
    this.tellState();
  }

  // The picture in any size and theme.
  paint(g: CanvasRenderingContext2D, width: number, height: number, theme: Theme): MapLayout {
    const { map } = this.state.view;
    const { state, lineShown } = this;
    return this.map.draw(g, width, height, state.scenario, map, this.marked(), theme, lineShown, this.box());
  }

  // The setting, the axes, the tolerance of the verdict, and all computed points.
  table(): [Scenario, MapAxis, MapAxis, number | null, number[][]] {
    const { scenario, view } = this.state;
    return [scenario, ...this.axes, view.map.show === "verdict" ? view.tolerance : null, this.map.rows()];
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
  private rounded(x: number, y: number): Point {
    const { scenario } = this.state;
    const [across, axis] = this.axes;
    return [axes[across].rounded(scenario, x), axes[axis].rounded(scenario, y)];
  }

  // Where the lowest ball cannot fall, nothing is chosen.
  private choose(x: number, y: number): void {
    const { scenario: s } = this.state;
    const [across, axis] = this.axes;
    const [right, up] = this.rounded(x, y);
    const moved = placed(s, [
      [across, right],
      [axis, up],
    ]);
    if (!moved || (!s.cradle && moved.height < lowestHeight(moved))) return;
    Object.assign(s, moved);
    this.state.edited();
  }

  private zoom(factor: number, at = this.marked()): void {
    this.setZoom(zoomed(this.box(), this.limits(), factor, at, this.logs));
  }

  // By fractions of the frame.
  private pan(right: number, up: number): void {
    this.setZoom(panned(this.box(), this.limits(), right, up, this.logs));
  }

  private limits(): Box {
    const { scenario, view } = this.state;
    return mapLimits(view.map.axis, view.map.across, scenario);
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
      this.refresh(); // the verdict needs both models
      this.state.writeLink();
    });
    for (const [key, other] of [
      ["axis", "across"],
      ["across", "axis"],
    ] as const)
      find<HTMLSelectElement>(`map-${key}`).addEventListener("change", (e) => {
        const chosen = (e.target as HTMLSelectElement).value as MapAxis;
        if (chosen === view.map[other]) view.map[other] = view.map[key]; // both axes change places
        view.map[key] = chosen;
        view.map.zoom = null;
        this.refreshChoices();
        this.refresh();
        this.state.writeLink();
      });
  }
}

// Numbers of a key, without the last digits that an axis may change.
const rounded = (_: string, x: unknown): unknown => (typeof x === "number" ? Number(x.toPrecision(9)) : x);
