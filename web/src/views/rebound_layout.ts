// Contents and coordinates of the plot of rebound heights.
import { digits, withUnit } from "../support/format";
import type { CurveAxis } from "../scenario/story_view";
import type { Measurements } from "./measurements";
import type { Frame } from "../support/pen";
import type { Scale } from "../support/plot";
import type { CurvePoint, Span } from "./rebound";

export const models = ["icm", "newton"] as const;

export interface CurvePicture {
  axis: CurveAxis;
  span: Span;
  points: CurvePoint[];
  touching: CurvePoint | null;
  pinned: CurvePoint[]; // curves of setting A
  pinnedTouching: CurvePoint | null;
  pinnedAt: number | null; // x of setting A
  released: number; // height of the top ball's centre at release [m]; NaN on a cradle
  // Rebound heights of the top ball when it is dropped alone [m].
  alone: { low: number; high: number; by: string } | null;
  measured: Measurements | null;
  marked: CurvePoint; // the present setting
  hovered: number | null;
  cradle: boolean;
}

export interface CurveLayout {
  x: Scale;
  y: Scale;
  frame: Frame;
  zero: number; // pixel of gap 0; NaN if the axis has none
}

export const axisTitle: Record<CurveAxis, string> = {
  gap: "gap Δh",
  e: "coefficient of restitution ε",
  ratio: "R₁/R₂",
};

export const nameOf = (axis: CurveAxis, x: number): string =>
  axis === "gap"
    ? x > 0
      ? `Δh = ${withUnit(x, "m")}`
      : "touching"
    : axis === "e"
      ? `ε = ${digits(x)}`
      : `R₁/R₂ = ${digits(x)}`;

// The computed point nearest to x; gap 0 is separate.
export function nearest(p: Pick<CurvePicture, "points" | "touching" | "axis" | "span">, x: number): CurvePoint | null {
  if (p.axis === "gap" && x < 0.75 * p.span.low) return p.touching;
  const place = (v: number): number => (p.span.log ? Math.log(v) : v);
  let best: CurvePoint | null = null;
  for (const point of p.points)
    if (!best || Math.abs(place(point.x) - place(x)) < Math.abs(place(best.x) - place(x))) best = point;
  return best;
}

// Pixel of a value of x, including gap 0; NaN outside.
export function pixelOf(l: CurveLayout, x: number): number {
  if (Number.isFinite(l.zero) && x < 0.75 * l.x.low) return l.zero;
  return x >= l.x.low * 0.999 && x <= l.x.high * 1.001 ? l.x.at(x) : NaN;
}

export const valueAt = (l: CurveLayout, pixel: number): number =>
  Number.isFinite(l.zero) && pixel < l.frame.left - 2 ? 0 : Math.min(Math.max(l.x.value(pixel), l.x.low), l.x.high);
