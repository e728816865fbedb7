// The rebound heights of both models as curves over the gap, ε or R1/R2, with measured ones.
import { logTicks, niceTicks, withUnit } from "../support/format";
import { drawAxes, fontSize, grown, Scale, setFont, stroke, type Frame } from "../support/plot";
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
    g,
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
    theme,
    size,
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
  const room = roomBeside(whole, layout, p);
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

// The position of gap 0 is left of the logarithmic axis.
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
      if (touching && Number.isFinite(touching[model]) && Number.isFinite(l.zero))
        dot(g, l.zero, l.y.at(touching[model]), (pale ? 3.5 : 5.5) * thick, model === "icm", theme);
    }
    g.globalAlpha = 1;
  }
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
function namesFit(
  g: CanvasRenderingContext2D,
  width: number,
  title: string,
  p: CurvePicture,
  theme: Theme,
  size: number,
): boolean {
  setFont(g, theme, size);
  let needed = g.measureText(title).width - 2.6 * size;
  setFont(g, theme, size, 600);
  for (const name of namesOf(p, width, theme, size))
    needed += g.measureText(name[0]).width + 6 + lineOfName(name, size) + 0.9 * size;
  return needed < width;
}

// Above the frame; in a separate row if there is little room.
function drawNames(
  g: CanvasRenderingContext2D,
  f: Frame,
  crowded: boolean,
  p: CurvePicture,
  theme: Theme,
  size: number,
): void {
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
