// The rebound heights of both models as curves over the gap, ε or R1/R2, with measured ones.
import { digits, logTicks, metres, niceTicks, withUnit } from "../support/format";
import type { CurveAxis } from "../story/lecture_view";
import type { Measurements } from "./measurements";
import { drawAxes, fontSize, grown, Scale, setFont, stroke, type Frame } from "../support/plot";
import type { CurvePoint, Span } from "./rebound";
import { independent, newton } from "../core/tables";
import type { Theme } from "../style/theme";

export interface CurvePicture {
  axis: CurveAxis;
  span: Span;
  points: CurvePoint[];
  touching: CurvePoint | null;
  pinned: CurvePoint[]; // curves of setting A
  pinnedTouching: CurvePoint | null;
  pinnedAt: number | null; // x of setting A
  released: number; // height of the top ball's centre at release [m]; NaN on a cradle
  alone: { low: number; high: number; by: string } | null; // heights to which the top ball comes back by itself [m]
  measured: Measurements | null;
  marked: CurvePoint; // the present setting
  hovered: number | null;
  cradle: boolean;
}

export interface CurveLayout {
  x: Scale;
  y: Scale;
  frame: Frame;
  zero: number; // pixel of gap 0; NaN where there is no such place
}

export const axisTitle: Record<CurveAxis, string> = { gap: "gap Δh", e: "coefficient of restitution ε", ratio: "R₁/R₂" };

export const nameOf = (axis: CurveAxis, x: number): string =>
  axis === "gap" ? (x > 0 ? `Δh = ${withUnit(x, "m")}` : "touching") : axis === "e" ? `ε = ${digits(x)}` : `R₁/R₂ = ${digits(x)}`;

// The point computed nearest to x, and gap 0 by itself.
export function nearest(p: Pick<CurvePicture, "points" | "touching" | "axis" | "span">, x: number): CurvePoint | null {
  if (p.axis === "gap" && x < 0.75 * p.span.low) return p.touching;
  const place = (v: number): number => (p.span.log ? Math.log(v) : v);
  let best: CurvePoint | null = null;
  for (const point of p.points) if (!best || Math.abs(place(point.x) - place(x)) < Math.abs(place(best.x) - place(x))) best = point;
  return best;
}

export function drawCurves(g: CanvasRenderingContext2D, w: number, h: number, p: CurvePicture, theme: Theme): CurveLayout {
  g.clearRect(0, 0, w, h);
  const size = fontSize(w);
  const left = 3.6 * size;
  const lane = p.axis === "gap" ? 4.6 * size : 0; // for gap 0, left of the logarithmic axis
  const unit = p.cradle ? "m/s" : "m";
  const title = p.cradle ? `last ball leaves with (${unit})` : `top ball rises to (${unit})`;
  const crowded = !namesFit(g, w - left - 1.2 * size, title, p, theme, size);
  const top = (crowded ? 3.6 : 2.1) * size;
  const frame: Frame = { left: left + lane, top, width: w - left - lane - 1.2 * size, height: h - 3.4 * size - top };
  const zero = lane > 0 ? left + 0.5 * lane : NaN;
  const [low, high] = extent(p);
  const x = new Scale(p.span.low, p.span.high, frame.left, frame.left + frame.width, p.span.log);
  const y = new Scale(low, high, frame.top + frame.height, frame.top);
  const ticks = niceTicks(low, high, Math.max(3, frame.height / (3.2 * size)));
  const places = Math.max(0, -Math.floor(Math.log10(ticks[1] - ticks[0]) + 1e-9));
  const whole: Frame = { ...frame, left, width: frame.width + lane };
  drawAxes(
    g, whole, x, y,
    {
      ticks: p.span.log ? logTicks(x.low, x.high) : niceTicks(x.low, x.high, Math.max(3, frame.width / (5 * size))),
      name: (t) => (p.axis === "gap" ? withUnit(t, "m", 4) : String(Number(t.toPrecision(4)))),
      title: axisTitle[p.axis],
      after: lane > 0 ? zero + size / 3 : undefined, // the name of gap 0
    },
    { ticks, name: (v) => v.toFixed(places).replace("-", "−"), title },
    theme, size,
  );
  if (lane > 0) drawLane(g, frame, zero, theme, size);
  const layout: CurveLayout = { x, y, frame, zero };
  drawRelease(g, whole, y, p, theme);
  drawAlone(g, whole, y, p, theme);
  g.save();
  g.beginPath();
  g.rect(whole.left, whole.top - 2, whole.width, whole.height + 4);
  g.clip();
  drawModels(g, layout, p, theme, size);
  drawMeasured(g, layout, p, theme);
  g.restore();
  drawPinned(g, layout, p, theme, size);
  const room = new Room(whole, layout, p);
  drawPlace(g, layout, p, room, theme, size);
  nameMeasured(g, layout, p, room, theme, size);
  nameRelease(g, whole, y, p, room, theme, size);
  nameAlone(g, whole, y, p, room, theme, size);
  drawNames(g, whole, crowded, p, theme, size);
  return layout;
}

function extent(p: CurvePicture): [number, number] {
  const all = [...p.points, ...p.pinned, p.touching, p.pinnedTouching].flatMap((q) => (q ? [q.newton, q.icm] : []));
  if (p.measured?.axis === p.axis) all.push(...p.measured.list.map((m) => m.height + m.uncertainty));
  const known = all.filter(Number.isFinite);
  if (Number.isFinite(p.released)) known.push(p.released);
  const high = Math.max(...known, 1e-9);
  return [Math.min(0, 1.1 * Math.min(...known, 0)), 1.12 * high];
}

// A separate position for gap 0.
function drawLane(g: CanvasRenderingContext2D, f: Frame, zero: number, theme: Theme, size: number): void {
  g.strokeStyle = theme.line;
  g.lineWidth = 1;
  g.setLineDash([3, 3]);
  stroke(g, f.left, f.top, f.left, f.top + f.height);
  g.setLineDash([]);
  setFont(g, theme, size);
  g.fillStyle = theme.muted;
  g.textAlign = "center";
  g.textBaseline = "top";
  g.fillText("touching", zero, f.top + f.height + 7 + 1.3 * size);
  g.fillText("0", zero, f.top + f.height + 7);
}

function drawRelease(g: CanvasRenderingContext2D, f: Frame, y: Scale, p: CurvePicture, theme: Theme): void {
  if (!Number.isFinite(p.released)) return;
  const at = y.at(p.released);
  g.strokeStyle = theme.muted;
  g.lineWidth = 1.5;
  g.setLineDash([2, 4]);
  stroke(g, f.left, at, f.left + f.width, at);
  g.setLineDash([]);
}

// The heights that the rules of the top ball allow it, let go alone.
function drawAlone(g: CanvasRenderingContext2D, f: Frame, y: Scale, p: CurvePicture, theme: Theme): void {
  if (!p.alone) return;
  const top = y.at(p.alone.high);
  g.fillStyle = theme.muted;
  g.globalAlpha = 0.35;
  g.fillRect(f.left, top, f.width, Math.max(y.at(p.alone.low) - top, 2));
  g.globalAlpha = 1;
}

function nameAlone(g: CanvasRenderingContext2D, f: Frame, y: Scale, p: CurvePicture, room: Room, theme: Theme, size: number): void {
  if (p.alone) nameLevel(g, f, [y.at(p.alone.high), y.at(p.alone.low)], ["alone, by the rules", "alone"].map((begin) => `${begin} (${p.alone!.by}): ${metres(p.alone!.low)} to ${metres(p.alone!.high)}`), room, theme, size);
}

function nameRelease(g: CanvasRenderingContext2D, f: Frame, y: Scale, p: CurvePicture, room: Room, theme: Theme, size: number): void {
  if (Number.isFinite(p.released)) nameLevel(g, f, [y.at(p.released), y.at(p.released)], [`let go at ${metres(p.released)}`], room, theme, size);
}

// Above or below a line or a band, depending on the room; the first text that fits into the frame.
function nameLevel(g: CanvasRenderingContext2D, f: Frame, [top, bottom]: [number, number], texts: string[], room: Room, theme: Theme, size: number): void {
  setFont(g, theme, 0.92 * size);
  const text = texts.find((x) => g.measureText(x).width < f.width - 12);
  if (text === undefined) return;
  const width = g.measureText(text).width;
  const places: Box[] = [];
  for (const middle of [top - 0.5 * size - 3, bottom + 0.5 * size + 4])
    for (let left = f.left + f.width - 6 - width; left > f.left + 4; left -= 0.5 * size) places.push({ left, middle, width, height: size });
  write(g, text, room.take(places), theme.muted, theme);
}

// ---- room for text ------------------------------------------------------------------------------------------

interface Box {
  left: number;
  middle: number;
  width: number;
  height: number;
}

// Places labels within the frame, clear of the curves, the marker lines and other labels.
class Room {
  private readonly points: [number, number][] = [];
  private readonly lines: number[];
  private readonly taken: Box[] = [];

  constructor(
    private readonly frame: Frame,
    layout: CurveLayout,
    p: CurvePicture,
  ) {
    for (const model of models) this.trace(p.points.map((q): [number, number] => [layout.x.at(q.x), layout.y.at(q[model])]));
    for (const q of [p.touching, p.marked]) if (q) for (const model of models) this.points.push([pixelOf(layout, q.x), layout.y.at(q[model])]);
    this.lines = [pixelOf(layout, p.marked.x), p.pinnedAt === null ? NaN : pixelOf(layout, p.pinnedAt)];
  }

  // A point every two pixels.
  private trace(corners: [number, number][]): void {
    corners.forEach(([x, y], i) => {
      const [x0, y0] = corners[i - 1] ?? [x, y];
      const parts = Math.min(Math.ceil(Math.hypot(x - x0, y - y0) / 2), 500); // NaN where a model has no height
      for (let k = 1; k <= parts; k++) this.points.push([x0 + (k / parts) * (x - x0), y0 + (k / parts) * (y - y0)]);
    });
  }

  private cost({ left, middle, width, height }: Box): number {
    const [right, top, bottom] = [left + width, middle - 0.5 * height, middle + 0.5 * height];
    const { frame } = this;
    const outside = left < frame.left || right > frame.left + frame.width || top < frame.top || bottom > frame.top + frame.height;
    const over = this.taken.some((b) => left < b.left + b.width && b.left < right && Math.abs(middle - b.middle) < 0.5 * (height + b.height));
    const crossed = this.points.filter(([x, y]) => x > left - 2 && x < right + 2 && y > top - 1 && y < bottom + 1).length;
    return (outside ? 1e6 : 0) + (over ? 1e4 : 0) + crossed + 20 * this.lines.filter((x) => x > left - 5 && x < right + 5).length;
  }

  // The first of the best positions, which is then reserved.
  take(places: Box[]): Box {
    let best = places[0];
    for (const place of places) if (this.cost(place) < this.cost(best)) best = place;
    this.taken.push(best);
    return best;
  }
}

function write(g: CanvasRenderingContext2D, text: string, { left, middle }: Box, color: string, theme: Theme): void {
  g.textAlign = "left";
  g.textBaseline = "middle";
  halo(g, text, left, middle, color, theme);
}

function halo(g: CanvasRenderingContext2D, text: string, x: number, y: number, color: string, theme: Theme): void {
  g.lineWidth = 5;
  g.lineJoin = "round";
  g.strokeStyle = theme.ground;
  g.strokeText(text, x, y);
  g.fillStyle = color;
  g.fillText(text, x, y);
}

const models = ["icm", "newton"] as const;

// Newton's curve is solid, that of independent collisions dashed; those of setting A are thin and pale.
function drawModels(g: CanvasRenderingContext2D, l: CurveLayout, p: CurvePicture, theme: Theme, size: number): void {
  const thick = grown(size);
  for (const pale of [true, false]) {
    const points = pale ? p.pinned : p.points;
    const touching = pale ? p.pinnedTouching : p.touching;
    g.globalAlpha = pale ? 0.6 : 1;
    for (const model of models) {
      g.strokeStyle = g.fillStyle = theme[model];
      g.lineWidth = (pale ? 1.5 : 3) * thick;
      g.setLineDash(model === "icm" ? [8 * thick, 5 * thick] : []);
      g.beginPath();
      let open = false;
      for (const q of points) {
        if (!Number.isFinite(q[model])) {
          open = false;
          continue;
        }
        if (open) g.lineTo(l.x.at(q.x), l.y.at(q[model]));
        else g.moveTo(l.x.at(q.x), l.y.at(q[model]));
        open = true;
      }
      g.stroke();
      g.setLineDash([]);
      if (touching && Number.isFinite(touching[model]) && Number.isFinite(l.zero)) dot(g, l.zero, l.y.at(touching[model]), (pale ? 3.5 : 5.5) * thick, model === "icm", theme);
    }
    g.globalAlpha = 1;
  }
}

function dot(g: CanvasRenderingContext2D, x: number, y: number, radius: number, hollow: boolean, theme: Theme): void {
  g.beginPath();
  g.arc(x, y, radius, 0, 2 * Math.PI);
  const color = g.fillStyle;
  if (hollow) g.fillStyle = theme.ground;
  g.fill();
  g.fillStyle = color;
  g.lineWidth = 2.5;
  g.stroke();
}

function drawMeasured(g: CanvasRenderingContext2D, l: CurveLayout, p: CurvePicture, theme: Theme): void {
  if (p.measured?.axis !== p.axis) return;
  g.strokeStyle = g.fillStyle = theme.ink;
  g.lineWidth = 2;
  for (const m of p.measured.list) {
    const x = p.axis === "gap" && m.x < l.x.low ? l.zero : l.x.at(m.x);
    const y = l.y.at(m.height);
    if (m.uncertainty > 0) {
      const [a, b] = [l.y.at(m.height - m.uncertainty), l.y.at(m.height + m.uncertainty)];
      stroke(g, x, a, x, b);
      for (const end of [a, b]) stroke(g, x - 5, end, x + 5, end);
    }
    g.beginPath();
    g.moveTo(x, y - 6);
    g.lineTo(x + 6, y);
    g.lineTo(x, y + 6);
    g.lineTo(x - 6, y);
    g.closePath();
    g.fill();
  }
}

// The measured heights as numbers, as long as there are not too many to be read.
function nameMeasured(g: CanvasRenderingContext2D, l: CurveLayout, p: CurvePicture, room: Room, theme: Theme, size: number): void {
  if (p.measured?.axis !== p.axis || p.measured.list.length > 24) return;
  setFont(g, theme, 0.92 * size, 650);
  for (const m of p.measured.list) {
    const [x, y] = [pixelOf(l, m.x), l.y.at(m.height)];
    if (!Number.isFinite(x)) continue;
    const text = metres(m.height);
    const width = g.measureText(text).width;
    const places = [1, -1].flatMap((side) => [0, -1, 1, -2, 2].map((down) => ({ left: side > 0 ? x + 10 : x - 10 - width, middle: y + down * 0.9 * size, width, height: size })));
    write(g, text, room.take(places), theme.ink, theme);
  }
}

// Pixel of a value of x, including gap 0; NaN outside.
export function pixelOf(l: CurveLayout, x: number): number {
  if (Number.isFinite(l.zero) && x < 0.75 * l.x.low) return l.zero;
  return x >= l.x.low * 0.999 && x <= l.x.high * 1.001 ? l.x.at(x) : NaN;
}

export const valueAt = (l: CurveLayout, pixel: number): number =>
  Number.isFinite(l.zero) && pixel < l.frame.left - 2 ? 0 : Math.min(Math.max(l.x.value(pixel), l.x.low), l.x.high);

// A line at setting A.
function drawPinned(g: CanvasRenderingContext2D, l: CurveLayout, p: CurvePicture, theme: Theme, size: number): void {
  const at = p.pinnedAt === null ? NaN : pixelOf(l, p.pinnedAt);
  if (!Number.isFinite(at)) return;
  g.strokeStyle = theme.muted;
  g.lineWidth = 2;
  g.setLineDash([6, 4]);
  stroke(g, at, l.frame.top, at, l.frame.top + l.frame.height);
  g.setLineDash([]);
  setFont(g, theme, 1.05 * size, 700);
  g.textAlign = "left";
  g.textBaseline = "bottom";
  halo(g, "A", at + 5, l.frame.top + l.frame.height - 4, theme.muted, theme);
}

// A line at the present setting, one under the pointer, and dots where they meet the curves.
function drawPlace(g: CanvasRenderingContext2D, l: CurveLayout, p: CurvePicture, room: Room, theme: Theme, size: number): void {
  for (const thick of [false, true]) {
    const point = thick ? p.marked : p.hovered === null ? null : nearest(p, p.hovered);
    const at = point ? pixelOf(l, point.x) : NaN;
    if (!point || !Number.isFinite(at)) continue;
    g.strokeStyle = theme.ink;
    g.lineWidth = (thick ? 2 : 1) * grown(size);
    stroke(g, at, l.frame.top, at, l.frame.top + l.frame.height);
    for (const model of models) {
      if (!Number.isFinite(point[model])) continue;
      g.strokeStyle = g.fillStyle = theme[model];
      dot(g, at, l.y.at(point[model]), (thick ? 6.5 : 4.5) * grown(size), model === "icm", theme);
      if (thick) nameValue(g, l, p, model, at, room, theme, size);
    }
  }
}

// The value beside its dot, where there is room; of two that are close the greater one above.
function nameValue(g: CanvasRenderingContext2D, l: CurveLayout, p: CurvePicture, model: "newton" | "icm", at: number, room: Room, theme: Theme, size: number): void {
  const point = p.marked;
  const right = at < l.frame.left + 0.6 * l.frame.width;
  const other = point[model === "newton" ? "icm" : "newton"];
  const close = Math.abs(l.y.at(point.newton) - l.y.at(point.icm)) < 2.2 * size;
  const below = point[model] < other || (point[model] === other && model === "newton");
  setFont(g, theme, 1.05 * size, 700);
  const text = p.cradle ? withUnit(point[model], "m/s") : metres(point[model]);
  const width = g.measureText(text).width;
  const places: Box[] = [];
  for (const down of close ? [below ? 1 : -1] : [-1, 1])
    for (const far of [1, 1.7, 2.4])
      for (const side of right ? [1, -1] : [-1, 1])
        places.push({ left: side > 0 ? at + 0.8 * size : at - 0.8 * size - width, middle: l.y.at(point[model]) + down * far * size, width, height: 1.05 * size });
  write(g, text, room.take(places), theme[model], theme);
}

type Name = [text: string, color: string, dash: number[] | null];

// Legend, from the right.
function namesOf(p: CurvePicture, width: number, theme: Theme, size: number): Name[] {
  const short = width < (p.pinned.length > 0 || p.measured ? 48 : 34) * size;
  const names: Name[] = [
    [short ? independent.short : independent.label, theme.icm, [8, 5]],
    [newton.short, theme.newton, []],
  ];
  if (p.measured?.axis === p.axis) names.push(["measured", theme.ink, null]);
  if (p.pinned.length > 0) names.push(["thin: A", theme.muted, null]);
  return names;
}
const lineOfName = (name: Name, size: number): number => (name[2] ? 1.7 * size : name[0] === "measured" ? 14 : 0);

// Whether the legend fits beside the title of the vertical axis.
function namesFit(g: CanvasRenderingContext2D, width: number, title: string, p: CurvePicture, theme: Theme, size: number): boolean {
  setFont(g, theme, size);
  let needed = g.measureText(title).width - 2.6 * size;
  setFont(g, theme, size, 600);
  for (const name of namesOf(p, width, theme, size)) needed += g.measureText(name[0]).width + 6 + lineOfName(name, size) + 0.9 * size;
  return needed < width;
}

// Above the frame; in a separate row if there is little room.
function drawNames(g: CanvasRenderingContext2D, f: Frame, crowded: boolean, p: CurvePicture, theme: Theme, size: number): void {
  setFont(g, theme, size, 600);
  g.textBaseline = "bottom";
  g.textAlign = "right";
  let at = f.left + f.width;
  const y = f.top - 5 - (crowded ? 1.6 * size : 0);
  for (const name of namesOf(p, f.width, theme, size)) {
    const [text, color, dash] = name;
    g.fillStyle = color;
    g.fillText(text, at, y);
    at -= g.measureText(text).width + 6;
    const line = lineOfName(name, size);
    if (dash) {
      g.strokeStyle = color;
      g.lineWidth = 3 * grown(size);
      g.setLineDash(dash);
      stroke(g, at - line, y - 0.5 * size, at, y - 0.5 * size);
      g.setLineDash([]);
    } else if (line > 0) {
      g.beginPath();
      g.moveTo(at - 6, y - 0.5 * size - 6);
      g.lineTo(at, y - 0.5 * size);
      g.lineTo(at - 6, y - 0.5 * size + 6);
      g.lineTo(at - 12, y - 0.5 * size);
      g.closePath();
      g.fill();
    }
    at -= line + 0.9 * size;
  }
}
