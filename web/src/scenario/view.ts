// View settings: map, zoom, film. Stored in the link with the scenario.
import { inPercent, usualTolerance } from "./tolerance";
import { choiceOf } from "../support/choice";
import { firstGap, ranges, type Scenario } from "./scenario";

export type MapAxis = "gap" | "ratio";
export type MapShow = "count" | "effective" | "separation";

export interface Box {
  x: [number, number]; // ε
  y: [number, number]; // gap [m] or R1/R2
}

export interface MapView {
  axis: MapAxis;
  show: MapShow;
  zoom: Box | null; // null: the whole map
}

export interface View {
  map: MapView;
  tolerance: number; // largest relative difference of the models that counts as agreement
  slow: boolean;
  time: number | null; // cursor [s]; null: at the start, running
}

export const firstView = (): View => ({
  map: { axis: "gap", show: "count", zoom: null },
  tolerance: usualTolerance,
  slow: true,
  time: null,
});

// Range of the whole map: ε, and the decades around the gap above which collisions are independent and around the
// present gap.
export function wholeMap(s: Scenario, axis: MapAxis, floorContact: number, speed: number): Box {
  const x: [number, number] = [0.05, 1];
  if (axis === "ratio") {
    const high = Math.min(30, s.cradle ? 30 : (0.95 * s.height) / s.balls[1].radius);
    return { x, y: [Math.min(0.5, high / 4), high] };
  }
  const independent = Math.min(Math.max(floorContact * speed, 1e-7), 1);
  const top = Math.ceil(Math.log10(independent) - 0.15);
  const gap = Math.log10(Math.max(s.gaps[firstGap(s)], 1e-9));
  const present = gap > -9 ? [Math.floor(gap), Math.ceil(gap)] : [top, top];
  return { x, y: [10 ** Math.min(top - 4, present[0]), 10 ** Math.max(top, present[1])] };
}

export const mapLimits = (axis: MapAxis): Box => ({
  x: [ranges.restitution.low, 1],
  y: axis === "gap" ? [1e-9, 10] : [0.02, 500],
});

export function viewToQuery(v: View, q: URLSearchParams): void {
  if (v.map.axis !== "gap") q.set("map", v.map.axis);
  if (v.map.show !== "count") q.set("show", v.map.show);
  if (v.map.zoom) q.set("zoom", [...v.map.zoom.x, ...v.map.zoom.y].map((x) => Number(x.toPrecision(6))).join());
  if (v.tolerance !== usualTolerance) q.set("tol", String(v.tolerance));
  if (!v.slow) q.set("film", "real");
  if (v.time !== null) q.set("t", String(Number(v.time.toPrecision(9))));
}

export function viewFromQuery(v: View, q: URLSearchParams, notes: string[]): void {
  v.map.axis = choiceOf(q, notes, "map", ["gap", "ratio"], v.map.axis);
  v.map.show = choiceOf(q, notes, "show", ["count", "effective", "separation"], v.map.show);
  v.slow = choiceOf(q, notes, "film", ["slow", "real"], v.slow ? "slow" : "real") === "slow";
  const tolerance = q.get("tol");
  if (tolerance !== null) {
    const x = tolerance.trim() === "" ? NaN : Number(tolerance);
    if (x > 0 && x < 1) v.tolerance = x;
    else notes.push(`tol = “${tolerance.slice(0, 20)}” is not a share between 0 and 1: ${inPercent(v.tolerance)} used`);
  }
  const zoom = q.get("zoom");
  if (zoom !== null) {
    const [x0, x1, y0, y1] = zoom.split(",").map(Number);
    const { x, y } = mapLimits(v.map.axis);
    if (x0 >= x[0] && x0 < x1 && x1 <= x[1] && y0 >= y[0] && y0 < y1 && y1 <= y[1])
      v.map.zoom = { x: [x0, x1], y: [y0, y1] };
    else notes.push("zoom is no part of the map: the whole map is shown");
  }
  const time = q.get("t");
  if (time !== null) {
    if (time.trim() !== "" && Number.isFinite(Number(time))) v.time = Number(time);
    else notes.push(`t = “${time.slice(0, 20)}” is not a time: the film starts at the release`);
  }
}
