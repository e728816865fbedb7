// The rebound heights of both models as curves over the gap, ε or R1/R2, with measured ones.
import { logTicks, niceTicks, withUnit } from "../support/format";
import { diamond, Pen, type Frame } from "../support/pen";
import { drawAxes, fontSize, grown, Scale } from "../support/plot";
import { axisTitle, models, type CurveLayout, type CurvePicture } from "./rebound_layout";
import {
  dot,
  drawAlone,
  drawMeasured,
  drawPinned,
  drawPlace,
  drawRelease,
  nameAlone,
  nameMeasured,
  nameRelease,
  roomBeside,
} from "./rebound_marks";
import { independent, newton } from "../scenario/tables";
import type { Theme } from "../style/theme";

export function drawCurves(
  g: CanvasRenderingContext2D,
  w: number,
  h: number,
  p: CurvePicture,
  theme: Theme,
): CurveLayout {
  g.clearRect(0, 0, w, h);
  const size = fontSize(w);
  const pen = new Pen(g, theme, size);
  const left = 3.6 * size;
  const lane = p.axis === "gap" ? 4.6 * size : 0; // for gap 0, left of the logarithmic axis
  const unit = p.cradle ? "m/s" : "m";
  const title = p.cradle ? `last ball leaves with (${unit})` : `top ball rises to (${unit})`;
  const crowded = !namesFit(pen, w - left - 1.2 * size, title, p);
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
    pen,
    whole,
    x,
    y,
    {
      ticks: p.span.log ? logTicks(x.low, x.high) : niceTicks(x.low, x.high, Math.max(3, frame.width / (5 * size))),
      name: (t) => (p.axis === "gap" ? withUnit(t, "m", 4) : String(Number(t.toPrecision(4)))),
      title: axisTitle[p.axis],
      after: lane > 0 ? zero + size / 3 : undefined, // the name of gap 0
    },
    { ticks, name: (v) => v.toFixed(places).replace("-", "−"), title },
  );
  if (lane > 0) drawLane(pen, frame, zero);
  const layout: CurveLayout = { x, y, frame, zero };
  drawRelease(pen, whole, y, p);
  drawAlone(pen, whole, y, p);
  pen.within({ ...whole, top: whole.top - 2, height: whole.height + 4 }, () => {
    drawModels(pen, layout, p);
    drawMeasured(pen, layout, p);
  });
  drawPinned(pen, layout, p);
  const room = roomBeside(whole, layout, p);
  drawPlace(pen, layout, p, room);
  nameMeasured(pen, layout, p, room);
  nameRelease(pen, whole, y, p, room);
  nameAlone(pen, whole, y, p, room);
  drawNames(pen, whole, crowded, p);
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

// The position of gap 0 is left of the logarithmic axis.
function drawLane(pen: Pen, f: Frame, zero: number): void {
  const { line, muted } = pen.theme;
  const foot = f.top + f.height;
  pen.line(f.left, f.top, f.left, foot, line, 1, [3, 3]);
  pen.font();
  pen.text("touching", zero, foot + 7 + 1.3 * pen.size, muted, "center", "top");
  pen.text("0", zero, foot + 7, muted, "center", "top");
}

// Newton's curve is solid, that of independent collisions dashed; those of setting A are thin and pale.
function drawModels(pen: Pen, l: CurveLayout, p: CurvePicture): void {
  const thick = grown(pen.size);
  for (const pale of [true, false]) {
    const points = pale ? p.pinned : p.points;
    const touching = pale ? p.pinnedTouching : p.touching;
    pen.g.globalAlpha = pale ? 0.6 : 1;
    for (const model of models) {
      const color = pen.theme[model];
      const dash = model === "icm" ? [8 * thick, 5 * thick] : [];
      const places = points.map((q): [number, number] => [l.x.at(q.x), l.y.at(q[model])]);
      pen.curve(places, color, (pale ? 1.5 : 3) * thick, dash);
      if (touching && Number.isFinite(touching[model]) && Number.isFinite(l.zero))
        dot(pen, l.zero, l.y.at(touching[model]), (pale ? 3.5 : 5.5) * thick, color, model === "icm");
    }
    pen.g.globalAlpha = 1;
  }
}

type Name = [text: string, color: string, dash: number[] | null];

// Legend, from the right.
function namesOf(p: CurvePicture, width: number, { theme, size }: Pen): Name[] {
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
function namesFit(pen: Pen, width: number, title: string, p: CurvePicture): boolean {
  const { size } = pen;
  pen.font();
  let needed = pen.widthOf(title) - 2.6 * size;
  pen.font(1, 600);
  for (const name of namesOf(p, width, pen)) needed += pen.widthOf(name[0]) + 6 + lineOfName(name, size) + 0.9 * size;
  return needed < width;
}

// Above the frame; in a separate row if there is little room.
function drawNames(pen: Pen, f: Frame, crowded: boolean, p: CurvePicture): void {
  const { g, size } = pen;
  pen.font(1, 600);
  let at = f.left + f.width;
  const y = f.top - 5 - (crowded ? 1.6 * size : 0);
  for (const name of namesOf(p, f.width, pen)) {
    const [text, color, dash] = name;
    pen.text(text, at, y, color, "right", "bottom");
    at -= pen.widthOf(text) + 6;
    const line = lineOfName(name, size);
    if (dash) pen.line(at - line, y - 0.5 * size, at, y - 0.5 * size, color, 3 * grown(size), dash);
    else if (line > 0) {
      diamond(g, at - 6, y - 0.5 * size, 6);
      g.fill();
    }
    at -= line + 0.9 * size;
  }
}
