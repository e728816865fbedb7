// The balls at true scale beside a ruler. The viewer's guess is a line; during the fall both models are side by side.
import type { State as Balls } from "../core/core";
import type { Drop } from "../core/drop";
import { Sheet } from "../support/dom";
import { metres, niceTicks, withUnit } from "../support/format";
import { drawBall, filled, Line, outlined } from "../views/ball";
import { Pen } from "../support/pen";
import { nameOfBall } from "../scenario/measured";
import { massOf, releaseHeight } from "../scenario/scenario";
import { independent, newton } from "../scenario/tables";
import type { Theme } from "../style/theme";

const leastRadius = 10; // of a ball [px]

export interface PredictionPicture {
  drop: Drop;
  newton: Balls;
  icm: Balls;
  falling: boolean; // shows both models; otherwise the balls at release
  guess: number | null; // m
  reached: [number, number]; // heights to mark for Newton and independent collisions [m]; NaN: not yet
}

export interface PredictionLayout {
  floor: number; // pixel
  scale: number; // pixels per metre
  left: number; // horizontal range of the ruler [pixels]
  right: number;
  promptHeight: number; // height of the line that asks for a guess [m]
}

// The ruler covers every possible guess and does not reveal the result.
export function rulerTop(d: Drop, guess: number | null, falling: boolean): number {
  const least = 5 * releaseHeight(d.scenario);
  const seen = falling ? Math.min(1.05 * d.top, 20 * releaseHeight(d.scenario)) : 0;
  return Math.max(least, seen, 1.1 * (guess ?? 0));
}

export function drawPrediction(
  g: CanvasRenderingContext2D,
  whole: number,
  h: number,
  t: PredictionPicture,
  size: number,
  theme: Theme,
): PredictionLayout {
  g.clearRect(0, 0, whole, h);
  const pen = new Pen(g, theme, size);
  const room = !t.falling && whole > 39 * size; // space for an enlarged picture of the balls
  const w = room ? 0.52 * whole : whole;
  if (room) drawPortrait(pen, t.drop, w + 2 * size, whole - w - 2 * size, h);
  const floor = h - 2.4 * size;
  const top = rulerTop(t.drop, t.guess, t.falling);
  const scale = (floor - 1.2 * size) / top;
  const left = 3.4 * size;
  const promptHeight = 0.55 * top;
  drawRuler(pen, left, w, floor, scale, top);
  const lanes = t.falling ? 2 : 1;
  const lane = (w - left) / lanes;
  const columns: ["newton" | "icm", string, Balls][] = [
    ["newton", newton.label, t.newton],
    ["icm", lane > 16 * size ? `Textbook: ${independent.label}` : "Textbook", t.icm],
  ];
  const release = releaseHeight(t.drop.scenario);
  const [narrow, tight] = [lane < 21 * size, t.falling && lane < 16 * size]; // the balls or the heights need the space
  const label = tight ? "" : `${narrow ? "" : "let go at "}${metres(release)}`;
  const level = floor - release * scale;
  // A mark of a height, with its number above, would cross the label.
  const crossed = t.reached.some((z) => Math.abs(floor - z * scale - level + 0.1 * size) < 1.7 * size);
  drawLevel(pen, left, w, level, label, theme.muted, [2, 5], 1.5, "left", crossed);
  columns.slice(0, lanes).forEach(([model, name, balls], k) => {
    const middle = left + (k + 0.5) * lane;
    if (t.falling) {
      pen.font(1.05, 650);
      pen.text(name, middle, floor + 1.3 * size, theme[model], "center");
    }
    const line = new Line(g, false, floor, middle);
    line.balls(t.drop.scenario.balls, balls.position, scale, leastRadius, (i) =>
      model === "icm" ? outlined(theme, Math.max(3, size / 7)) : filled(theme, i, 1),
    );
    const z = t.reached[k];
    if (t.falling && Number.isFinite(z)) {
      const y = floor - z * scale;
      pen.line(middle - 0.3 * lane, y, middle + 0.3 * lane, y, theme[model], Math.max(3, size / 6));
      pen.font(1.5, 700);
      const wide = pen.widthOf(metres(z)) + 0.6 * size; // covers the lines of the ruler behind the number
      // Beside the ball, where the lane has room for it; otherwise above the ball.
      const radius = Math.max(t.drop.scenario.balls.at(-1)!.radius * scale, leastRadius);
      const beside = radius + 0.6 * wide;
      const fits = beside + 0.5 * wide < 0.5 * lane;
      const at = fits ? middle - beside : middle;
      // Above the mark; below it where the line of the guess would cross the number.
      const lift = fits ? 0.3 * size : radius;
      const crossed = t.guess !== null && Math.abs(y - lift - 0.6 * size - (floor - t.guess * scale)) < 1.2 * size;
      const bottom = crossed ? y + lift + 2 * size : Math.max(y - lift, 1.8 * size);
      g.fillStyle = theme.ground;
      g.fillRect(at - 0.5 * wide, bottom - 1.45 * size, wide, 1.35 * size);
      pen.text(metres(z), at, bottom, theme[model], "center", "bottom");
    }
  });
  if (t.guess === null && !t.falling && !Sheet.printing) {
    const level = floor - promptHeight * scale;
    pen.line(left, level, w, level, theme.ink, 2, [7, 5]);
    pen.font(1.1, 650);
    pen.label("↕ drag: my guess", left + 0.5 * (w - left), level - 0.3 * pen.size, theme.ink, "center", "bottom");
  }
  if (t.guess !== null) {
    const level = floor - t.guess * scale;
    const marked = t.falling && t.reached.some((z) => Math.abs(level - size - (floor - z * scale)) < 1.1 * size);
    const name = `${t.falling ? "your guess" : "my guess"}: ${t.guess} m`;
    drawLevel(pen, left, w, level, name, theme.ink, [], 3, "right", marked);
  }
  return { floor, scale, left, right: w, promptHeight };
}

// The balls at a common scale, with their names.
function drawPortrait(pen: Pen, d: Drop, x: number, w: number, h: number): void {
  const { theme, size } = pen;
  const { balls, gaps } = d.scenario;
  const tall = balls.reduce((sum, b) => sum + 2 * b.radius, 0);
  const wide = Math.max(...balls.map((b) => b.radius));
  // The names beside the balls need 14 heights of letters.
  const scale = Math.min((0.72 * h) / tall, Math.max(0.5 * (w - 14 * size), 2 * size) / wide);
  let bottom = 0.5 * h + 0.5 * tall * scale;
  const middle = x + wide * scale;
  balls.forEach((b, i) => {
    const radius = b.radius * scale;
    const center = bottom - radius;
    drawBall(pen.g, middle, center, radius, filled(theme, i, 1.5));
    const name = nameOfBall(b, i === 0 ? "lowest ball" : i === balls.length - 1 ? "top ball" : `ball ${i + 1}`);
    const left = middle + wide * scale + 1.2 * size;
    pen.font(1.15, 650);
    pen.text(name[0].toUpperCase() + name.slice(1), left, center, theme.ink, "left", "bottom");
    pen.font();
    const about = `${withUnit(massOf(b), "kg")}, ${withUnit(2 * b.radius, "m")} across`;
    pen.text(about, left, center + 0.1 * size, theme.muted, "left", "top");
    bottom -= 2 * radius;
  });
  pen.font();
  const apart = gaps.every((gap) => gap === 0)
    ? "let go touching"
    : `let go ${[...new Set(gaps.map((gap) => withUnit(gap, "m")))].join(", ")} apart`;
  pen.text(apart, x, 0.5 * h + 0.5 * tall * scale + 0.8 * size, theme.muted, "left", "top");
}

function drawRuler(pen: Pen, left: number, w: number, floor: number, scale: number, top: number): void {
  const { theme, size } = pen;
  pen.font();
  const ticks = niceTicks(0, top, Math.min(8, (top * scale) / (2.4 * size)));
  for (const z of ticks) {
    const y = floor - z * scale;
    pen.line(left, y, w, y, theme.faint);
    const name = z === ticks[ticks.length - 1] ? `${z} m` : String(z);
    if (y > size) pen.text(name, left - 8, y, theme.muted, "right");
  }
  pen.line(left, floor + 1.5, w, floor + 1.5, theme.ink, Math.max(3, size / 7));
}

function drawLevel(
  pen: Pen,
  left: number,
  right: number,
  y: number,
  text: string,
  color: string,
  dash: number[],
  width: number,
  align: "left" | "right",
  below: boolean,
): void {
  const { size } = pen;
  pen.line(left, y, right, y, color, width * Math.max(1, size / 18), dash);
  pen.font(width > 2 ? 1.2 : 1, width > 2 ? 700 : 400);
  const edge = below ? y + 4 : Math.max(y - 4, 1.5 * size);
  pen.label(text, align === "left" ? left + 8 : right - 8, edge, color, align, below ? "top" : "bottom");
}
