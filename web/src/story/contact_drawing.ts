// The first two steps through the contact: one ball alone on the floor, and when the contacts last.
import type { Drop } from "../core/drop";
import type { LoneBall } from "../core/lone_ball";
import { speed } from "../report/facts";
import { duration } from "../report/words";
import { nameOfBall } from "../scenario/measured";
import { capital, newton } from "../scenario/tables";
import type { Theme } from "../style/theme";
import { niceTicks } from "../support/format";
import { halo } from "../support/labels";
import { drawAxes, grown, Scale, setFont, stroke, timeTicks, timeUnit, type Frame } from "../support/plot";

type Canvas = CanvasRenderingContext2D;

function drawTime(g: Canvas, f: Frame, x: Scale, y: Scale | null, title: string, theme: Theme, size: number): void {
  const [factor, unit] = timeUnit(x.high - x.low);
  const peak = y?.high ?? 0;
  const [force, forceUnit] = peak >= 1e3 ? [1e-3, "kN"] : peak >= 1 ? [1, "N"] : [1e3, "mN"];
  drawAxes(
    g,
    f,
    x,
    y ?? new Scale(0, 1, f.top + f.height, f.top),
    { ...timeTicks(x, 0, factor, f.width / (5.5 * size)), title: `${title} (${unit})` },
    {
      ticks: y ? niceTicks(0, peak / 1.1, Math.max(2, f.height / (2.4 * size))) : [],
      name: (v) => String(Number((v * force).toPrecision(6))),
      title: y ? `push of the floor (${forceUnit})` : "",
    },
    theme,
    size,
  );
}

// The push of the floor over time; arrows show the speeds before and after, their ratio ε.
export function drawLone(g: Canvas, w: number, h: number, lone: LoneBall | null, theme: Theme, size: number): void {
  g.clearRect(0, 0, w, h);
  if (!lone) return;
  const f: Frame = { left: 3.4 * size, top: 2 * size, width: w - 4.2 * size, height: h - 5.2 * size };
  const margin = 0.45 * lone.end;
  const x = new Scale(-margin, lone.end + margin, f.left, f.left + f.width);
  const most = lone.force.reduce((a, b) => Math.max(a, b), 0);
  const y = new Scale(0, 1.1 * most, f.top + f.height, f.top);
  drawTime(g, f, x, y, "time after the first touch", theme, size);
  g.beginPath();
  g.moveTo(x.at(0), y.at(0));
  lone.times.forEach((t, i) => g.lineTo(x.at(t), y.at(lone.force[i])));
  g.lineTo(x.at(lone.end), y.at(0));
  g.globalAlpha = 0.16;
  g.fillStyle = theme.pairs[0];
  g.fill();
  g.globalAlpha = 1;
  g.strokeStyle = theme.pairs[0];
  g.lineWidth = Math.max(2.5, size / 7);
  g.stroke();
  const longest = 0.62 * f.height;
  const foot = f.top + f.height - 0.6 * size;
  drawSpeed(g, x.at(-0.5 * margin), foot - longest, foot, speed(lone.arrives), theme, size);
  const after = (longest * lone.leaves) / lone.arrives;
  drawSpeed(g, x.at(lone.end + 0.5 * margin), foot, foot - after, speed(lone.leaves), theme, size);
  setFont(g, theme, size, 650);
  g.textAlign = "center";
  g.textBaseline = "bottom";
  halo(g, `contact: ${duration(lone.end)}`, x.at(0.5 * lone.end), f.top + f.height - 0.5 * size, theme.ink, theme);
}

function drawSpeed(g: Canvas, x: number, from: number, to: number, text: string, theme: Theme, size: number): void {
  const head = Math.min(0.6 * size, 0.5 * Math.abs(to - from)) * Math.sign(to - from);
  g.strokeStyle = g.fillStyle = theme.newton;
  g.lineWidth = 0.3 * size;
  stroke(g, x, from, x, to - head);
  g.beginPath();
  g.moveTo(x, to);
  g.lineTo(x - 0.45 * size, to - 1.5 * head);
  g.lineTo(x + 0.45 * size, to - 1.5 * head);
  g.fill();
  setFont(g, theme, size, 600);
  g.textAlign = "center";
  g.textBaseline = "bottom";
  halo(g, text, x, Math.min(from, to) - 0.3 * size, theme.newton, theme);
}

// A bar for each contact by Newton's equations, and a mark for each collision of the textbook.
export function drawOverlap(g: Canvas, w: number, h: number, d: Drop, theme: Theme, size: number): void {
  g.clearRect(0, 0, w, h);
  const { balls, cradle } = d.scenario;
  const pairs = balls.map((_, j) => j).slice(cradle ? 1 : 0);
  const f: Frame = { left: 0.8 * size, top: 2 * size, width: w - 1.8 * size, height: h - 5.2 * size };
  const [low, high] = [d.times[0], d.times[d.times.length - 1]].map((t) => t - d.origin);
  const x = new Scale(low, high, f.left, f.left + f.width);
  const last = d.newton.run.last;
  const contacts = d.newton.run.contacts
    .filter((c) => c.begin <= last)
    .map((c) => ({ ...c, begin: c.begin - d.origin, end: (Number.isFinite(c.end) ? c.end : d.to) - d.origin }));
  const row = (f.height - 1.4 * size) / pairs.length; // below the words “at the same time”
  shadeBoth(g, f, x, contacts, theme, size);
  drawTime(g, f, x, null, `time after the first ${cradle ? "contact" : "floor touch"}`, theme, size);
  drawLegend(g, f, theme, size);
  pairs.forEach((pair, i) => {
    const middle = f.top + f.height - (i + 0.38) * row;
    const thick = Math.min(0.3 * row, 1.6 * size);
    for (const c of contacts.filter((c) => c.pair === pair)) {
      g.fillStyle = theme.pairs[pair];
      g.fillRect(x.at(c.begin), middle - 0.5 * thick, Math.max(x.at(c.end) - x.at(c.begin), 2), thick);
    }
    for (const c of d.icm.run.contacts.slice(0, 200))
      if (c.pair === pair && c.begin <= d.icm.run.last) drawInstant(g, x, c.begin - d.origin, middle, size, theme, f);
    setFont(g, theme, Math.min(size, 0.3 * row), 600);
    g.textAlign = "left";
    g.textBaseline = "bottom";
    halo(g, nameOfPair(d, pair), f.left + 0.6 * size, middle - 0.5 * thick - 0.15 * size, theme.ink, theme);
  });
}

function nameOfPair({ scenario: { balls } }: Drop, pair: number): string {
  const name = (i: number): string =>
    nameOfBall(balls[i], balls.length > 2 ? `ball ${i + 1}` : i === 0 ? "lowest ball" : "top ball");
  return capital(pair === 0 ? `floor and ${name(0)}` : `${name(pair - 1)} and ${name(pair)}`);
}

// Where two contacts last at the same time.
function shadeBoth(
  g: Canvas,
  f: Frame,
  x: Scale,
  contacts: { begin: number; end: number }[],
  theme: Theme,
  size: number,
): void {
  let widest: [number, number] = [0, 0];
  g.fillStyle = theme.faint;
  for (const [i, a] of contacts.slice(0, 200).entries())
    for (const b of contacts.slice(0, i)) {
      const [from, to] = [Math.max(a.begin, b.begin), Math.min(a.end, b.end)].map((t) => x.at(t));
      if (!(to > from)) continue;
      g.fillRect(from, f.top, to - from, f.height);
      if (to - from > widest[1] - widest[0]) widest = [from, to];
    }
  setFont(g, theme, size, 650);
  const text = "at the same time";
  if (widest[1] - widest[0] < g.measureText(text).width + size) return;
  g.fillStyle = theme.muted;
  g.textAlign = "right";
  g.textBaseline = "top";
  g.fillText(text, widest[1] - 0.5 * size, f.top + 0.4 * size);
}

function drawInstant(g: Canvas, x: Scale, t: number, y: number, size: number, theme: Theme, f: Frame): void {
  const at = x.at(t);
  if (at < f.left || at > f.left + f.width) return;
  const half = 0.55 * size;
  g.beginPath();
  g.moveTo(at, y - half);
  g.lineTo(at + half, y);
  g.lineTo(at, y + half);
  g.lineTo(at - half, y);
  g.closePath();
  g.fillStyle = theme.ground;
  g.fill();
  g.strokeStyle = theme.icm;
  g.lineWidth = 2.5 * grown(size);
  g.stroke();
}

function drawLegend(g: Canvas, f: Frame, theme: Theme, size: number): void {
  setFont(g, theme, size, 650);
  g.textBaseline = "bottom";
  g.textAlign = "left";
  g.fillStyle = theme.newton;
  const short = f.width < 26 * size;
  g.fillText(short ? newton.short : newton.label, f.left, f.top - 6);
  g.textAlign = "right";
  g.fillStyle = theme.icm;
  g.fillText(short ? "◇ textbook (ICM)" : "◇ textbook (ICM): an instant", f.left + f.width, f.top - 6);
}
