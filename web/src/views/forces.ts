// Forces over time (Fig. 2): between the balls above, on the floor below.
import type { Drop } from "../core/drop";
import { digits, forceName, niceTicks, withUnit } from "../support/format";
import { drawAxes, fontSize, grown, Scale, setFont, stroke, timeTicks, timeUnit, type Frame } from "../support/plot";
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
  shadeContacts(g, d, x, upper, floor ? lower : null, theme, size);
  drawGroup(g, d, x, upper, pairs, theme, size, !floor);
  if (floor) drawGroup(g, d, x, lower, [0], theme, size, true);
  const taken = markIndependent(g, d, x, frames, theme, size);
  nameGroup(g, upper, pairs, right - left - taken - size, theme, size);
  if (floor) nameGroup(g, lower, [0], right - left, theme, size);
  return { x, frames };
}

function drawGroup(
  g: CanvasRenderingContext2D,
  d: Drop,
  x: Scale,
  f: Frame,
  pairs: number[],
  theme: Theme,
  size: number,
  last: boolean,
): void {
  const peak = Math.max(...pairs.map((j) => d.peakForce[j]), 1e-12);
  const y = new Scale(0, (pairs[0] === 0 ? 1.1 : 1.28) * peak, f.top + f.height, f.top);
  const [factor, unit] = peak >= 1e3 ? [1e-3, "kN"] : peak >= 1 ? [1, "N"] : [1e3, "mN"];
  const [timeFactor, timeName] = timeUnit(x.high - x.low);
  drawAxes(
    g,
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
    theme,
    size,
  );
  g.save();
  g.beginPath();
  g.rect(f.left, f.top, f.width, f.height + 1);
  g.clip();
  for (const j of pairs) {
    g.beginPath();
    g.moveTo(x.at(d.times[0]), y.at(0));
    d.times.forEach((t, i) => g.lineTo(x.at(t), y.at(d.forces[j][i])));
    g.lineTo(x.at(d.times[d.times.length - 1]), y.at(0));
    g.globalAlpha = 0.16;
    g.fillStyle = theme.pairs[j];
    g.fill();
    g.globalAlpha = 1;
    g.strokeStyle = theme.pairs[j];
    g.lineWidth = Math.max(2.5, size / 7);
    g.lineJoin = "round";
    g.stroke();
  }
  g.restore();
}

// Legend beside the title of the axis; long labels only where they fit.
function nameGroup(
  g: CanvasRenderingContext2D,
  f: Frame,
  pairs: number[],
  room: number,
  theme: Theme,
  size: number,
): void {
  setFont(g, theme, size * 1.05, 700);
  g.textBaseline = "bottom";
  g.textAlign = "left";
  let at = f.left + 0.4 * size;
  for (const j of pairs) {
    g.fillStyle = theme.pairs[j];
    const long = `${forceName(j)}  ${j === 0 ? "floor on lowest ball" : "between the balls"}`;
    const label = pairs.length === 1 && g.measureText(long).width < room ? long : forceName(j);
    g.fillText(label, at, f.top - 5);
    at += g.measureText(label).width + size;
  }
}

function shadeContacts(
  g: CanvasRenderingContext2D,
  d: Drop,
  x: Scale,
  upper: Frame,
  lower: Frame | null,
  theme: Theme,
  size: number,
): void {
  if (d.scenario.balls.length !== 2) return;
  const contacts = d.newton.run.contacts.filter((c) => c.pair === 1 && c.begin <= d.newton.run.last);
  setFont(g, theme, size, 600);
  g.textAlign = "center";
  g.textBaseline = "top";
  let right = -Infinity;
  contacts.forEach((c, i) => {
    const from = x.at(c.begin);
    const to = x.at(Number.isFinite(c.end) ? c.end : d.to);
    g.fillStyle = theme.faint;
    g.fillRect(from, upper.top, Math.max(to - from, 1), upper.height);
    if (lower) g.fillRect(from, lower.top, Math.max(to - from, 1), lower.height);
    const name = String(i + 1);
    const half = g.measureText(name).width / 2;
    // The cursor of the film often stands in the middle of a long contact.
    const middle = Math.min((from + to) / 2, from + size);
    if (middle - half < right + 4) return;
    right = middle + half;
    g.fillStyle = theme.muted;
    g.fillText(name, middle, upper.top + 3);
  });
}

function markIndependent(
  g: CanvasRenderingContext2D,
  d: Drop,
  x: Scale,
  frames: Frame[],
  theme: Theme,
  size: number,
): number {
  const times = d.icm.run.contacts
    .filter((c) => c.pair > 0)
    .map((c) => c.begin)
    .filter((t) => t >= x.low && t <= x.high);
  if (times.length === 0) return 0;
  g.strokeStyle = theme.icm;
  g.lineWidth = 2 * grown(size);
  g.setLineDash([5 * grown(size), 4 * grown(size)]);
  for (const t of times.slice(0, 12)) for (const f of frames) stroke(g, x.at(t), f.top, x.at(t), f.top + f.height);
  g.setLineDash([]);
  setFont(g, theme, size, 600);
  g.fillStyle = theme.icm;
  g.textBaseline = "bottom";
  g.textAlign = "right";
  const text = `${independent.short}: ${times.length === 1 ? "one instant" : `${times.length} instants`}`;
  g.fillText(text, frames[0].left + frames[0].width, frames[0].top - 5);
  return g.measureText(text).width;
}

export const forcesSummary = (d: Drop): string =>
  `Forces over time. ${d.forces
    .map((_, j) => (j === 0 && d.scenario.cradle ? "" : `${forceName(j)} up to ${withUnit(d.peakForce[j], "N")}`))
    .filter(Boolean)
    .join(", ")}; ` + `${counted(d.newton.run.nContacts, "contact")} between balls.`;
