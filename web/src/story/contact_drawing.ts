// The first two steps through the contact: one ball alone on the floor, and when the contacts last.
import type { Drop } from "../core/drop";
import type { LoneBall } from "../core/lone_ball";
import { speed } from "../report/facts";
import { duration } from "../report/words";
import { nameOfBall } from "../scenario/measured";
import { capital, newton } from "../scenario/tables";
import type { Theme } from "../style/theme";
import { niceTicks } from "../support/format";
import { diamond, Pen, type Frame } from "../support/pen";
import { drawAxes, forceUnit, grown, Scale, timeTicks, timeUnit } from "../support/plot";
import { drawPush } from "../views/forces";

type Canvas = CanvasRenderingContext2D;

function drawTime(pen: Pen, f: Frame, x: Scale, y: Scale | null, title: string): void {
  const [factor, unit] = timeUnit(x.high - x.low);
  const peak = y?.high ?? 0;
  const [force, nameOfForce] = forceUnit(peak);
  drawAxes(
    pen,
    f,
    x,
    y ?? new Scale(0, 1, f.top + f.height, f.top),
    { ...timeTicks(x, 0, factor, f.width / (5.5 * pen.size)), title: `${title} (${unit})` },
    {
      ticks: y ? niceTicks(0, peak / 1.1, Math.max(2, f.height / (2.4 * pen.size))) : [],
      name: (v) => String(Number((v * force).toPrecision(6))),
      title: y ? `push of the floor (${nameOfForce})` : "",
    },
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
  const pen = new Pen(g, theme, size);
  drawTime(pen, f, x, y, "time after the first touch");
  drawPush(pen, x, y, lone.times, lone.force, theme.pairs[0]);
  const longest = 0.62 * f.height;
  const foot = f.top + f.height - 0.6 * size;
  drawSpeed(pen, x.at(-0.5 * margin), foot - longest, foot, speed(lone.arrives));
  const after = (longest * lone.leaves) / lone.arrives;
  drawSpeed(pen, x.at(lone.end + 0.5 * margin), foot, foot - after, speed(lone.leaves));
  pen.font(1, 650);
  const name = `contact: ${duration(lone.end)}`;
  pen.label(name, x.at(0.5 * lone.end), f.top + f.height - 0.5 * size, theme.ink, "center", "bottom");
}

function drawSpeed(pen: Pen, x: number, from: number, to: number, text: string): void {
  const { size } = pen;
  const color = pen.theme.newton;
  const head = Math.min(0.6 * size, 0.5 * Math.abs(to - from)) * Math.sign(to - from);
  pen.line(x, from, x, to - head, color, 0.3 * size);
  pen.area(
    [
      [x, to],
      [x - 0.45 * size, to - 1.5 * head],
      [x + 0.45 * size, to - 1.5 * head],
    ],
    color,
  );
  pen.font(1, 600);
  pen.label(text, x, Math.min(from, to) - 0.3 * size, color, "center", "bottom");
}

// A bar for each contact by Newton's equations, and a mark for each collision of the textbook.
export function drawOverlap(g: Canvas, w: number, h: number, d: Drop, theme: Theme, size: number): void {
  g.clearRect(0, 0, w, h);
  const pen = new Pen(g, theme, size);
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
  shadeBoth(pen, f, x, contacts);
  drawTime(pen, f, x, null, `time after the first ${cradle ? "contact" : "floor touch"}`);
  drawLegend(pen, f);
  pairs.forEach((pair, i) => {
    const middle = f.top + f.height - (i + 0.38) * row;
    const thick = Math.min(0.3 * row, 1.6 * size);
    for (const c of contacts.filter((c) => c.pair === pair)) {
      g.fillStyle = theme.pairs[pair];
      g.fillRect(x.at(c.begin), middle - 0.5 * thick, Math.max(x.at(c.end) - x.at(c.begin), 2), thick);
    }
    for (const c of d.icm.run.contacts.slice(0, 200))
      if (c.pair === pair && c.begin <= d.icm.run.last) drawInstant(pen, x, c.begin - d.origin, middle, f);
    pen.font(Math.min(1, (0.3 * row) / size), 600);
    const bottom = middle - 0.5 * thick - 0.15 * size;
    pen.label(nameOfPair(d, pair), f.left + 0.6 * size, bottom, theme.ink, "left", "bottom");
  });
}

function nameOfPair({ scenario: { balls } }: Drop, pair: number): string {
  const name = (i: number): string =>
    nameOfBall(balls[i], balls.length > 2 ? `ball ${i + 1}` : i === 0 ? "lowest ball" : "top ball");
  return capital(pair === 0 ? `floor and ${name(0)}` : `${name(pair - 1)} and ${name(pair)}`);
}

// Where two contacts last at the same time.
function shadeBoth(pen: Pen, f: Frame, x: Scale, contacts: { begin: number; end: number }[]): void {
  const { g, theme, size } = pen;
  let widest: [number, number] = [0, 0];
  g.fillStyle = theme.faint;
  for (const [i, a] of contacts.slice(0, 200).entries())
    for (const b of contacts.slice(0, i)) {
      const [from, to] = [Math.max(a.begin, b.begin), Math.min(a.end, b.end)].map((t) => x.at(t));
      if (!(to > from)) continue;
      g.fillRect(from, f.top, to - from, f.height);
      if (to - from > widest[1] - widest[0]) widest = [from, to];
    }
  pen.font(1, 650);
  const text = "at the same time";
  if (widest[1] - widest[0] < pen.widthOf(text) + size) return;
  pen.text(text, widest[1] - 0.5 * size, f.top + 0.4 * size, theme.muted, "right", "top");
}

function drawInstant(pen: Pen, x: Scale, t: number, y: number, f: Frame): void {
  const at = x.at(t);
  if (at < f.left || at > f.left + f.width) return;
  const { g, theme, size } = pen;
  diamond(g, at, y, 0.55 * size);
  g.fillStyle = theme.ground;
  g.fill();
  g.strokeStyle = theme.icm;
  g.lineWidth = 2.5 * grown(size);
  g.stroke();
}

function drawLegend(pen: Pen, f: Frame): void {
  pen.font(1, 650);
  const short = f.width < 26 * pen.size;
  pen.text(short ? newton.short : newton.label, f.left, f.top - 6, pen.theme.newton, "left", "bottom");
  const textbook = short ? "◇ textbook (ICM)" : "◇ textbook (ICM): an instant";
  pen.text(textbook, f.left + f.width, f.top - 6, pen.theme.icm, "right", "bottom");
}
