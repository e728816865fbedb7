// View settings: map, zoom, film. Stored in the link with the scenario.
import { inPercent, usualTolerance } from "./tolerance";
import { choiceOf } from "../support/choice";
import { axes, mapAxes, type Limits, type MapAxis } from "./axes";
import { firstGap, paper, type Scenario } from "./scenario";

export type { MapAxis };
export const mapShows = ["count", "effective", "separation", "verdict"] as const;
export type MapShow = (typeof mapShows)[number];

export interface Box {
  x: Limits; // of the axis across
  y: Limits;
}

export interface MapView {
  axis: MapAxis; // upwards
  across: MapAxis;
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
  map: { axis: "gap", across: "e", show: "count", zoom: null },
  tolerance: usualTolerance,
  slow: true,
  time: null,
});

// Range of the whole map.
export function wholeMap(s: Scenario, axis: MapAxis, floorContact: number, speed: number, across: MapAxis = "e"): Box {
  return {
    x: wholeAxis(s, across, axis, floorContact, speed),
    y: wholeAxis(s, axis, across, floorContact, speed),
  };
}

// It does not depend on the value of the setting on the other axis, so that a click does not change the map.
function wholeAxis(s: Scenario, axis: MapAxis, other: MapAxis, floorContact: number, speed: number): Limits {
  if (axis === "gap") return other === "e" ? wholeGap(s, floorContact, speed) : [1e-7, 1];
  if (axis === "e") return [0.05, 1];
  if (axis !== "ratio") return axes[axis].limits(s);
  const high = Math.min(30, s.cradle || other === "h" ? 30 : (0.95 * s.height) / s.balls[1].radius);
  return [Math.min(0.5, high / 4), high];
}

// The decades around the gap above which collisions are independent and around the present gap.
function wholeGap(s: Scenario, floorContact: number, speed: number): Limits {
  const independent = Math.min(Math.max(floorContact * speed, 1e-7), 1);
  const top = Math.ceil(Math.log10(independent) - 0.15);
  const gap = Math.log10(Math.max(s.gaps[firstGap(s)], 1e-9));
  const present = gap > -9 ? [Math.floor(gap), Math.ceil(gap)] : [top, top];
  return [10 ** Math.min(top - 4, present[0]), 10 ** Math.max(top, present[1])];
}

// The range of the gap over ε, extended towards the region of agreement.
export function widened(s: Scenario, floorContact: number, speed: number): Box {
  const { x, y } = wholeMap(s, "gap", floorContact, speed);
  return { x, y: [y[0], Number((3 * y[1]).toPrecision(6))] };
}

export const mapLimits = (axis: MapAxis, across: MapAxis = "e", s = paper()): Box => ({
  x: axes[across].limits(s),
  y: axes[axis].limits(s),
});

export function viewToQuery(v: View, q: URLSearchParams): void {
  if (v.map.axis !== "gap") q.set("map", v.map.axis);
  if (v.map.across !== "e") q.set("across", v.map.across);
  if (v.map.show !== "count") q.set("show", v.map.show);
  if (v.map.zoom) q.set("zoom", [...v.map.zoom.x, ...v.map.zoom.y].map((x) => Number(x.toPrecision(6))).join());
  if (v.tolerance !== usualTolerance) q.set("tol", String(v.tolerance));
  if (!v.slow) q.set("film", "real");
  if (v.time !== null) q.set("t", String(Number(v.time.toPrecision(9))));
}

function readAxes(map: MapView, q: URLSearchParams, notes: string[]): void {
  map.axis = choiceOf(q, notes, "map", mapAxes, map.axis);
  map.across = choiceOf(q, notes, "across", mapAxes, map.across);
  if (map.axis !== map.across) return;
  map.across = map.axis === "e" ? "gap" : "e";
  if (q.has("across")) notes.push(`across = ${map.axis} is the other axis of the map too: ${map.across} used`);
}

// `s`: the setting of the link.
export function viewFromQuery(v: View, q: URLSearchParams, notes: string[], s: Scenario): void {
  readAxes(v.map, q, notes);
  v.map.show = choiceOf(q, notes, "show", mapShows, v.map.show);
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
    const { x, y } = mapLimits(v.map.axis, v.map.across, s);
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
