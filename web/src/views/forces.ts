// Forces over time (Fig. 2): between the balls above, on the floor below.
import type { Drop } from "../core/drop";
import { digits, forceName, niceTicks, withUnit } from "../support/format";
import { Pen, type Frame } from "../support/pen";
import { drawAxes, fontSize, forceUnit, grown, Scale, timeTicks, timeUnit } from "../support/plot";
import { independent } from "../scenario/tables";
import { counted } from "../report/words";
import type { Theme } from "../style/theme";

export interface ForcesLayout {
  x: Scale;
  frames: Frame[];
}

export function drawForces(g: CanvasRenderingContext2D, w: number, h: number, d: Drop, theme: Theme): ForcesLayout {
  g.clearRect(0, 0, w, h);
  const size = fontSize(w);
  const pen = new Pen(g, theme, size);
  const left = 3.9 * size;
  const right = w - 0.8 * size;
  const low = d.times[0];
  const high = d.times[d.times.length - 1];
  const x = new Scale(low, high, left, right);
  const floor = !d.scenario.cradle;
  const head = 1.9 * size;
  const foot = 3.3 * size;
  const between = floor ? 2.2 * size : 0;
  const each = (h - head - foot - between) / (floor ? 2 : 1);
  const upper: Frame = { left, top: head, width: right - left, height: each };
  const lower: Frame = { left, top: head + each + between, width: right - left, height: each };
  const frames = floor ? [upper, lower] : [upper];
  const pairs = d.forces.map((_, j) => j).slice(1);
  shadeContacts(pen, d, x, frames);
  drawGroup(pen, d, x, upper, pairs, !floor);
  if (floor) drawGroup(pen, d, x, lower, [0], true);
  const taken = markIndependent(pen, d, x, frames);
  nameGroup(pen, upper, pairs, right - left - taken - size);
  if (floor) nameGroup(pen, lower, [0], right - left);
  return { x, frames };
}

function drawGroup(pen: Pen, d: Drop, x: Scale, f: Frame, pairs: number[], last: boolean): void {
  const { g, theme, size } = pen;
  const peak = Math.max(...pairs.map((j) => d.peakForce[j]), 1e-12);
  const y = new Scale(0, (pairs[0] === 0 ? 1.1 : 1.28) * peak, f.top + f.height, f.top);
  const [factor, unit] = forceUnit(peak);
  const [timeFactor, timeName] = timeUnit(x.high - x.low);
  drawAxes(
    pen,
    f,
    x,
    y,
    last
      ? {
          ...timeTicks(x, d.origin, timeFactor, f.width / (5.5 * size)),
          title: `time after the first ${d.scenario.cradle ? "contact" : "floor touch"} (${timeName})`,
        }
      : null,
    {
      ticks: niceTicks(0, peak, Math.max(2, f.height / (2.4 * size))),
      name: (v) => (v * factor < 0.01 && v > 0 ? digits(v * factor) : String(Number((v * factor).toPrecision(6)))),
      title: unit,
    },
  );
  pen.within({ ...f, height: f.height + 1 }, () => {
    g.lineJoin = "round";
    for (const j of pairs) drawPush(pen, x, y, d.times, d.forces[j], theme.pairs[j]);
  });
}

// A force over time, from zero to zero.
export function drawPush(
  pen: Pen,
  x: Scale,
  y: Scale,
  times: ArrayLike<number>,
  force: ArrayLike<number>,
  color: string,
): void {
  const points = Array.from(times, (t, i): [number, number] => [x.at(t), y.at(force[i])]);
  points.unshift([points[0][0], y.at(0)]);
  points.push([points[points.length - 1][0], y.at(0)]);
  pen.area(points, color, 0.16);
  pen.curve(points, color, Math.max(2.5, pen.size / 7));
}

// Legend beside the title of the axis; long labels only where they fit.
function nameGroup(pen: Pen, f: Frame, pairs: number[], room: number): void {
  pen.font(1.05, 700);
  let at = f.left + 0.4 * pen.size;
  for (const j of pairs) {
    const long = `${forceName(j)}  ${j === 0 ? "floor on lowest ball" : "between the balls"}`;
    const label = pairs.length === 1 && pen.widthOf(long) < room ? long : forceName(j);
    pen.text(label, at, f.top - 5, pen.theme.pairs[j], "left", "bottom");
    at += pen.widthOf(label) + pen.size;
  }
}

function shadeContacts(pen: Pen, d: Drop, x: Scale, frames: Frame[]): void {
  if (d.scenario.balls.length !== 2) return;
  const { g, theme, size } = pen;
  const contacts = d.newton.run.contacts.filter((c) => c.pair === 1 && c.begin <= d.newton.run.last);
  pen.font(1, 600);
  let right = -Infinity;
  contacts.forEach((c, i) => {
    const from = x.at(c.begin);
    const to = x.at(Number.isFinite(c.end) ? c.end : d.to);
    g.fillStyle = theme.faint;
    for (const f of frames) g.fillRect(from, f.top, Math.max(to - from, 1), f.height);
    const name = String(i + 1);
    const half = pen.widthOf(name) / 2;
    // The cursor of the film often stands in the middle of a long contact.
    const middle = Math.min((from + to) / 2, from + size);
    if (middle - half < right + 4) return;
    right = middle + half;
    pen.text(name, middle, frames[0].top + 3, theme.muted, "center", "top");
  });
}

// Returns the width of the legend.
function markIndependent(pen: Pen, d: Drop, x: Scale, frames: Frame[]): number {
  const times = d.icm.run.contacts
    .filter((c) => c.pair > 0)
    .map((c) => c.begin)
    .filter((t) => t >= x.low && t <= x.high);
  if (times.length === 0) return 0;
  const { icm } = pen.theme;
  const thick = grown(pen.size);
  for (const t of times.slice(0, 12))
    for (const f of frames) pen.line(x.at(t), f.top, x.at(t), f.top + f.height, icm, 2 * thick, [5 * thick, 4 * thick]);
  pen.font(1, 600);
  const text = `${independent.short}: ${times.length === 1 ? "one instant" : `${times.length} instants`}`;
  pen.text(text, frames[0].left + frames[0].width, frames[0].top - 5, icm, "right", "bottom");
  return pen.widthOf(text);
}

export const forcesSummary = (d: Drop): string =>
  `Forces over time. ${d.forces
    .map((_, j) => (j === 0 && d.scenario.cradle ? "" : `${forceName(j)} up to ${withUnit(d.peakForce[j], "N")}`))
    .filter(Boolean)
    .join(", ")}; ` + `${counted(d.newton.run.nContacts, "contact")} between balls.`;
