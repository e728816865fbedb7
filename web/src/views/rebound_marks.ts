// Marks and labels in the plot of rebound heights: levels, measured heights, setting A, the present setting.
import { metres, withUnit } from "../support/format";
import { Room, type Box } from "../support/labels";
import { diamond, type Frame, type Pen } from "../support/pen";
import { grown, type Scale } from "../support/plot";
import { models, nearest, pixelOf, type CurveLayout, type CurvePicture } from "./rebound_layout";

// Free space for labels beside both curves and the present setting.
export function roomBeside(frame: Frame, l: CurveLayout, p: CurvePicture): Room {
  const curves = models.map((model) => p.points.map((q): [number, number] => [l.x.at(q.x), l.y.at(q[model])]));
  const points = [p.touching, p.marked].flatMap((q) =>
    q ? models.map((model): [number, number] => [pixelOf(l, q.x), l.y.at(q[model])]) : [],
  );
  return new Room(frame, curves, points, [pixelOf(l, p.marked.x), p.pinnedAt === null ? NaN : pixelOf(l, p.pinnedAt)]);
}

// Writes a text at the best of these places.
function write(pen: Pen, text: string, room: Room, places: Box[], color: string): void {
  const { left, middle } = room.take(places);
  pen.label(text, left, middle, color, "left");
}

export function drawRelease(pen: Pen, f: Frame, y: Scale, p: CurvePicture): void {
  if (!Number.isFinite(p.released)) return;
  const at = y.at(p.released);
  pen.line(f.left, at, f.left + f.width, at, pen.theme.muted, 1.5, [2, 4]);
}

// Band of the rebound heights of the top ball when it is dropped alone, from the rules of its sport.
export function drawAlone(pen: Pen, f: Frame, y: Scale, p: CurvePicture): void {
  if (!p.alone) return;
  const top = y.at(p.alone.high);
  pen.veil(f.left, top, f.width, Math.max(y.at(p.alone.low) - top, 2), pen.theme.muted, 0.35);
}

export function nameAlone(pen: Pen, f: Frame, y: Scale, { alone }: CurvePicture, room: Room): void {
  if (!alone) return;
  const heights = `(${alone.by}): ${metres(alone.low)} to ${metres(alone.high)}`;
  const texts = ["alone, by the rules", "alone"].map((begin) => `${begin} ${heights}`);
  nameLevel(pen, f, [y.at(alone.high), y.at(alone.low)], texts, room);
}

export function nameRelease(pen: Pen, f: Frame, y: Scale, { released }: CurvePicture, room: Room): void {
  if (Number.isFinite(released))
    nameLevel(pen, f, [y.at(released), y.at(released)], [`let go at ${metres(released)}`], room);
}

// Writes the first text that fits into the frame above or below a line or a band, where there is space.
function nameLevel(pen: Pen, f: Frame, [top, bottom]: [number, number], texts: string[], room: Room): void {
  const { size } = pen;
  pen.font(0.92);
  const text = texts.find((x) => pen.widthOf(x) < f.width - 12);
  if (text === undefined) return;
  const width = pen.widthOf(text);
  const places: Box[] = [];
  for (const middle of [top - 0.5 * size - 3, bottom + 0.5 * size + 4])
    for (let left = f.left + f.width - 6 - width; left > f.left + 4; left -= 0.5 * size)
      places.push({ left, middle, width, height: size });
  write(pen, text, room, places, pen.theme.muted);
}

export function dot({ g, theme }: Pen, x: number, y: number, radius: number, color: string, hollow: boolean): void {
  g.beginPath();
  g.arc(x, y, radius, 0, 2 * Math.PI);
  g.fillStyle = hollow ? theme.ground : color;
  g.fill();
  g.strokeStyle = color;
  g.lineWidth = 2.5;
  g.stroke();
}

export function drawMeasured(pen: Pen, l: CurveLayout, p: CurvePicture): void {
  if (p.measured?.axis !== p.axis) return;
  const { g } = pen;
  const { ink } = pen.theme;
  for (const m of p.measured.list) {
    const x = p.axis === "gap" && m.x < l.x.low ? l.zero : l.x.at(m.x);
    const y = l.y.at(m.height);
    if (m.uncertainty > 0) {
      const [a, b] = [l.y.at(m.height - m.uncertainty), l.y.at(m.height + m.uncertainty)];
      pen.line(x, a, x, b, ink, 2);
      for (const end of [a, b]) pen.line(x - 5, end, x + 5, end, ink, 2);
    }
    diamond(g, x, y, 6);
    g.fillStyle = ink;
    g.fill();
  }
}

// Writes the measured heights as numbers if there are few enough to be legible.
export function nameMeasured(pen: Pen, l: CurveLayout, p: CurvePicture, room: Room): void {
  if (p.measured?.axis !== p.axis || p.measured.list.length > 24) return;
  const { size } = pen;
  pen.font(0.92, 650);
  for (const m of p.measured.list) {
    const [x, y] = [pixelOf(l, m.x), l.y.at(m.height)];
    if (!Number.isFinite(x)) continue;
    const text = metres(m.height);
    const width = pen.widthOf(text);
    const places = [1, -1].flatMap((side) =>
      [0, -1, 1, -2, 2].map((down) => ({
        left: side > 0 ? x + 10 : x - 10 - width,
        middle: y + down * 0.9 * size,
        width,
        height: size,
      })),
    );
    write(pen, text, room, places, pen.theme.ink);
  }
}

// A line at setting A.
export function drawPinned(pen: Pen, l: CurveLayout, p: CurvePicture): void {
  const at = p.pinnedAt === null ? NaN : pixelOf(l, p.pinnedAt);
  if (!Number.isFinite(at)) return;
  const bottom = l.frame.top + l.frame.height;
  pen.line(at, l.frame.top, at, bottom, pen.theme.muted, 2, [6, 4]);
  pen.font(1.05, 700);
  pen.label("A", at + 5, bottom - 4, pen.theme.muted, "left", "bottom");
}

// Lines at the present setting and under the pointer, with dots at their intersections with the curves.
export function drawPlace(pen: Pen, l: CurveLayout, p: CurvePicture, room: Room): void {
  const { top, height } = l.frame;
  const grow = grown(pen.size);
  for (const thick of [false, true]) {
    const point = thick ? p.marked : p.hovered === null ? null : nearest(p, p.hovered);
    const at = point ? pixelOf(l, point.x) : NaN;
    if (!point || !Number.isFinite(at)) continue;
    pen.line(at, top, at, top + height, pen.theme.ink, (thick ? 2 : 1) * grow);
    for (const model of models) {
      if (!Number.isFinite(point[model])) continue;
      dot(pen, at, l.y.at(point[model]), (thick ? 6.5 : 4.5) * grow, pen.theme[model], model === "icm");
      if (thick) nameValue(pen, l, p, model, at, room);
    }
  }
}

// Writes the value beside its dot where there is space. If both values are close, the greater one is written above.
function nameValue(pen: Pen, l: CurveLayout, p: CurvePicture, model: "newton" | "icm", at: number, room: Room): void {
  const { size } = pen;
  const point = p.marked;
  const right = at < l.frame.left + 0.6 * l.frame.width;
  const other = point[model === "newton" ? "icm" : "newton"];
  const close = Math.abs(l.y.at(point.newton) - l.y.at(point.icm)) < 2.2 * size;
  const below = point[model] < other || (point[model] === other && model === "newton");
  pen.font(1.05, 700);
  const text = p.cradle ? withUnit(point[model], "m/s") : metres(point[model]);
  const width = pen.widthOf(text);
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
  write(pen, text, room, places, pen.theme[model]);
}
