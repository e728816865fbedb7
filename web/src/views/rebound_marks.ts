// Marks and labels in the plot of rebound heights: levels, measured heights, setting A, the present setting.
import { metres, withUnit } from "../support/format";
import { halo, Room, write, type Box } from "../support/labels";
import { grown, setFont, stroke, type Frame, type Scale } from "../support/plot";
import { models, nearest, pixelOf, type CurveLayout, type CurvePicture } from "./rebound_layout";
import type { Theme } from "../style/theme";

// Free space for labels beside both curves and the present setting.
export function roomBeside(frame: Frame, l: CurveLayout, p: CurvePicture): Room {
  const curves = models.map((model) => p.points.map((q): [number, number] => [l.x.at(q.x), l.y.at(q[model])]));
  const points = [p.touching, p.marked].flatMap((q) =>
    q ? models.map((model): [number, number] => [pixelOf(l, q.x), l.y.at(q[model])]) : [],
  );
  return new Room(frame, curves, points, [pixelOf(l, p.marked.x), p.pinnedAt === null ? NaN : pixelOf(l, p.pinnedAt)]);
}

export function drawRelease(g: CanvasRenderingContext2D, f: Frame, y: Scale, p: CurvePicture, theme: Theme): void {
  if (!Number.isFinite(p.released)) return;
  const at = y.at(p.released);
  g.strokeStyle = theme.muted;
  g.lineWidth = 1.5;
  g.setLineDash([2, 4]);
  stroke(g, f.left, at, f.left + f.width, at);
  g.setLineDash([]);
}

// Band of the rebound heights of the top ball when it is dropped alone, from the rules of its sport.
export function drawAlone(g: CanvasRenderingContext2D, f: Frame, y: Scale, p: CurvePicture, theme: Theme): void {
  if (!p.alone) return;
  const top = y.at(p.alone.high);
  g.fillStyle = theme.muted;
  g.globalAlpha = 0.35;
  g.fillRect(f.left, top, f.width, Math.max(y.at(p.alone.low) - top, 2));
  g.globalAlpha = 1;
}

export function nameAlone(
  g: CanvasRenderingContext2D,
  f: Frame,
  y: Scale,
  p: CurvePicture,
  room: Room,
  theme: Theme,
  size: number,
): void {
  if (p.alone)
    nameLevel(
      g,
      f,
      [y.at(p.alone.high), y.at(p.alone.low)],
      ["alone, by the rules", "alone"].map(
        (begin) => `${begin} (${p.alone!.by}): ${metres(p.alone!.low)} to ${metres(p.alone!.high)}`,
      ),
      room,
      theme,
      size,
    );
}

export function nameRelease(
  g: CanvasRenderingContext2D,
  f: Frame,
  y: Scale,
  p: CurvePicture,
  room: Room,
  theme: Theme,
  size: number,
): void {
  if (Number.isFinite(p.released))
    nameLevel(g, f, [y.at(p.released), y.at(p.released)], [`let go at ${metres(p.released)}`], room, theme, size);
}

// Writes the first text that fits into the frame above or below a line or a band, where there is space.
function nameLevel(
  g: CanvasRenderingContext2D,
  f: Frame,
  [top, bottom]: [number, number],
  texts: string[],
  room: Room,
  theme: Theme,
  size: number,
): void {
  setFont(g, theme, 0.92 * size);
  const text = texts.find((x) => g.measureText(x).width < f.width - 12);
  if (text === undefined) return;
  const width = g.measureText(text).width;
  const places: Box[] = [];
  for (const middle of [top - 0.5 * size - 3, bottom + 0.5 * size + 4])
    for (let left = f.left + f.width - 6 - width; left > f.left + 4; left -= 0.5 * size)
      places.push({ left, middle, width, height: size });
  write(g, text, room.take(places), theme.muted, theme);
}

export function dot(
  g: CanvasRenderingContext2D,
  x: number,
  y: number,
  radius: number,
  hollow: boolean,
  theme: Theme,
): void {
  g.beginPath();
  g.arc(x, y, radius, 0, 2 * Math.PI);
  const color = g.fillStyle;
  if (hollow) g.fillStyle = theme.ground;
  g.fill();
  g.fillStyle = color;
  g.lineWidth = 2.5;
  g.stroke();
}

export function drawMeasured(g: CanvasRenderingContext2D, l: CurveLayout, p: CurvePicture, theme: Theme): void {
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

// Writes the measured heights as numbers if there are few enough to be legible.
export function nameMeasured(
  g: CanvasRenderingContext2D,
  l: CurveLayout,
  p: CurvePicture,
  room: Room,
  theme: Theme,
  size: number,
): void {
  if (p.measured?.axis !== p.axis || p.measured.list.length > 24) return;
  setFont(g, theme, 0.92 * size, 650);
  for (const m of p.measured.list) {
    const [x, y] = [pixelOf(l, m.x), l.y.at(m.height)];
    if (!Number.isFinite(x)) continue;
    const text = metres(m.height);
    const width = g.measureText(text).width;
    const places = [1, -1].flatMap((side) =>
      [0, -1, 1, -2, 2].map((down) => ({
        left: side > 0 ? x + 10 : x - 10 - width,
        middle: y + down * 0.9 * size,
        width,
        height: size,
      })),
    );
    write(g, text, room.take(places), theme.ink, theme);
  }
}

// A line at setting A.
export function drawPinned(
  g: CanvasRenderingContext2D,
  l: CurveLayout,
  p: CurvePicture,
  theme: Theme,
  size: number,
): void {
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

// Lines at the present setting and under the pointer, with dots at their intersections with the curves.
export function drawPlace(
  g: CanvasRenderingContext2D,
  l: CurveLayout,
  p: CurvePicture,
  room: Room,
  theme: Theme,
  size: number,
): void {
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

// Writes the value beside its dot where there is space. If both values are close, the greater one is written above.
function nameValue(
  g: CanvasRenderingContext2D,
  l: CurveLayout,
  p: CurvePicture,
  model: "newton" | "icm",
  at: number,
  room: Room,
  theme: Theme,
  size: number,
): void {
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
        places.push({
          left: side > 0 ? at + 0.8 * size : at - 0.8 * size - width,
          middle: l.y.at(point[model]) + down * far * size,
          width,
          height: 1.05 * size,
        });
  write(g, text, room.take(places), theme[model], theme);
}
