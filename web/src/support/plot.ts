// Axes of the plots: scales, ticks and labels. No library is used: uPlot 1.6.32 (51 kB minified) draws series over one
// x, but no bands, maps or labels beside curves; Observable Plot 0.6.17 (209 kB without D3) creates a new SVG at each
// change. This file, labels.ts and pen.ts take 4 kB.
import { niceTicks } from "./format";
import type { Frame, Pen } from "./pen";

export class Scale {
  constructor(
    readonly low: number,
    readonly high: number,
    readonly from: number, // pixel of low
    readonly to: number, // pixel of high
    readonly log = false,
  ) {}
  private f(x: number): number {
    return this.log ? Math.log(x) : x;
  }
  at(x: number): number {
    return (
      this.from + ((this.f(x) - this.f(this.low)) / (this.f(this.high) - this.f(this.low))) * (this.to - this.from)
    );
  }
  value(pixel: number): number {
    const y = this.f(this.low) + ((pixel - this.from) / (this.to - this.from)) * (this.f(this.high) - this.f(this.low));
    return this.log ? Math.exp(y) : y;
  }
}

// Size of text in pictures [px]: at least 13; in the story and in single panels that of the page. It grows with the
// plot.
export const lettering = { least: 13, story: false };

export const fontSize = (w: number): number =>
  lettering.story
    ? Math.min(lettering.least, Math.max(w / 26, 13))
    : Math.min(Math.max(w / 42, 13), Math.max(16, w / 50));

// Lines and marks grow with the text.
export const grown = (size: number): number => Math.max(1, size / 16);

export interface AxisText {
  ticks: number[];
  name: (tick: number) => string;
  title: string;
  after?: number; // pixel to the right of which the labels of ticks begin
}

// Ticks, grid and titles around a frame. The title of the vertical axis is horizontal and above the axis, for
// legibility.
export function drawAxes(
  pen: Pen,
  f: Frame,
  x: Scale,
  y: Scale,
  xText: AxisText | null,
  yText: AxisText,
  grid = true,
): void {
  const { theme, size } = pen;
  const [left, foot] = [Math.round(f.left) + 0.5, Math.round(f.top + f.height) + 0.5];
  pen.font();
  for (const tick of yText.ticks) {
    const at = Math.round(y.at(tick)) + 0.5;
    if (grid) pen.line(f.left, at, f.left + f.width, at, theme.faint);
    pen.line(f.left - 4, at, f.left, at, theme.muted);
    pen.text(yText.name(tick), f.left - 7, at, theme.muted, "right");
  }
  if (xText) {
    let right = xText.after ?? -Infinity;
    for (const tick of xText.ticks) {
      const at = Math.round(x.at(tick)) + 0.5;
      pen.line(at, f.top + f.height, at, f.top + f.height + 4, theme.muted);
      const text = xText.name(tick);
      const half = pen.widthOf(text) / 2;
      if (at - half < right + 8 || at + half > f.left + f.width + 1.4 * size) continue;
      right = at + half;
      pen.text(text, at, f.top + f.height + 7, theme.muted, "center", "top");
    }
    pen.text(xText.title, f.left + f.width, f.top + f.height + 7 + 1.3 * size, theme.ink, "right", "top");
  }
  const crowded = yText.ticks.some((tick) => Math.abs(y.at(tick) - f.top) < 0.9 * size);
  const above = f.top - (crowded ? 0.75 * size : 6);
  pen.text(yText.title, Math.max(f.left - 2.6 * size, 2), above, theme.ink, "left", "bottom");
  pen.line(left, f.top, left, foot, theme.muted);
  pen.line(left, foot, f.left + f.width, foot, theme.muted);
}

// Unit of time for a span: a power of 1000 and its name.
export function timeUnit(span: number): [number, string] {
  if (span < 2e-6) return [1e9, "ns"];
  if (span < 2e-3) return [1e6, "µs"];
  if (span < 2) return [1e3, "ms"];
  return [1, "s"];
}

// The same for a force.
export const forceUnit = (most: number): [number, string] =>
  most >= 1e3 ? [1e-3, "kN"] : most >= 1 ? [1, "N"] : [1e3, "mN"];

// Ticks of a time axis whose zero is at `origin`.
export function timeTicks(x: Scale, origin: number, factor: number, wanted: number): Pick<AxisText, "ticks" | "name"> {
  const low = (x.low - origin) * factor;
  const high = (x.high - origin) * factor;
  return {
    ticks: niceTicks(low, high, Math.max(3, wanted)).map((t) => origin + t / factor),
    name: (t) =>
      String(Number(((t - origin) * factor).toPrecision(6)) + 0)
        .replace(/^-?\d+\.?\d*e-.*/, "0")
        .replace("-", "−"),
  };
}
