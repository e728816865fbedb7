// The first screen: both models side by side. The picture is enlarged while the film is slow, and reduced to show how
// high the balls rise.
import type { State as Balls } from "../core/core";
import type { Drop, Track } from "../core/drop";
import { drawBall, shaded } from "./ball";
import { capital, independent, newton } from "../scenario/tables";
import type { Theme } from "../style/theme";
import { metres, niceTicks, withUnit } from "../support/format";
import { Pen } from "../support/pen";

export interface DuelMoment {
  time: number;
  screen: number; // time in the film [s on the screen]
  rate: number; // physical seconds per screen second
  newton: Balls;
  icm: Balls;
  dragged: { ball: number; text: string } | null; // what is being dragged, and its value
}

interface Place {
  x: number; // middle [px]
  y: number;
  width: number;
  height: number;
}

// Coordinates for the pointer.
export interface DuelLayout {
  scale: number; // pixels per metre
  worlds: { top: Place; lowest: Place }[];
}

const least = 10; // radius of a ball [px]
const flash = 0.45; // s on the screen for which a collision is shown

export function drawDuel(
  g: CanvasRenderingContext2D,
  w: number,
  h: number,
  d: Drop,
  m: DuelMoment,
  toScreen: (t: number) => number,
  theme: Theme,
  size: number,
): DuelLayout {
  g.clearRect(0, 0, w, h);
  const pen = new Pen(g, theme, size);
  const floor = h - 2.2 * size;
  const room = floor - 3.4 * size;
  const scale = scaleAt(d, m, room, 0.5 * w - 2 * size);
  const half = 0.5 * w;
  drawRuler(pen, w, floor, scale, room);
  const worlds: [Track, Balls, string, string][] = [
    [d.newton, m.newton, theme.newton, half > 15 * size ? newton.label : newton.short],
    [d.icm, m.icm, theme.icm, half > 18 * size ? capital(independent.label) : independent.short],
  ];
  const places = worlds.map(([track, balls, color, name], k) => {
    const world = new World(
      pen,
      d,
      m,
      k * half + 0.5 * half + (k === 0 ? 1 : -0.4) * size,
      floor,
      scale,
      color,
      (k + 1) * half,
    );
    world.shadow(balls);
    world.balls(balls);
    if (k === 0) {
      world.forces(balls);
      if (m.dragged) world.note(balls, m.dragged.ball, m.dragged.text);
    } else {
      const frame = { left: half, top: 0, width: half, height: floor };
      pen.within(frame, () => world.flashes(track, balls, toScreen));
    }
    world.height(track, balls, 0.36 * half);
    pen.font(1.1, 650);
    pen.text(name, world.x, 1.1 * size, color, "center");
    return world.places(balls);
  });
  g.fillStyle = theme.line;
  g.fillRect(half - 0.5, 0.4 * size, 1, floor - 0.4 * size);
  pen.line(0, floor + 1, w, floor + 1, theme.ink, Math.max(2, size / 8));
  return { scale, worlds: places };
}

// Pixels per metre: large while the film is slow, to show the contacts; otherwise small, to show the whole flight.
function scaleAt(d: Drop, m: DuelMoment, room: number, width: number): number {
  const { balls, gaps } = d.scenario;
  const tall = balls.reduce((sum, b) => sum + 2 * b.radius, 0) + gaps.reduce((a, b) => a + b, 0);
  const wide = Math.max(...balls.map((b) => b.radius));
  const near = Math.min(room / (1.3 * tall), width / (3.2 * wide));
  const far = Math.min(room / (1.06 * d.top), near);
  const slowest = d.windows.reduce((a, v) => Math.min(a, v.rate), 1);
  const close = slowest < 1 ? Math.min(Math.max(Math.log(m.rate) / Math.log(slowest), 0), 1) : 0;
  const eased = close * close * (3 - 2 * close);
  return far * (near / far) ** eased;
}

function drawRuler(pen: Pen, w: number, floor: number, scale: number, room: number): void {
  pen.font(0.9);
  for (const z of niceTicks(0, room / scale, room / (4.5 * pen.size))) {
    if (z === 0) continue;
    const y = floor - z * scale;
    pen.line(0, y, w, y, pen.theme.faint);
    pen.text(withUnit(z, "m"), 2, y - 1, pen.theme.muted, "left", "bottom");
  }
}

// The picture of one model.
class World {
  constructor(
    private readonly pen: Pen,
    private readonly d: Drop,
    private readonly m: DuelMoment,
    readonly x: number,
    private readonly floor: number,
    private readonly scale: number,
    private readonly color: string,
    private readonly right: number, // its right edge
  ) {}

  private y(z: number): number {
    return this.floor - z * this.scale;
  }
  private radius(i: number): number {
    return Math.max(this.d.scenario.balls[i].radius * this.scale, least);
  }

  // Areas in which the top and the lowest ball can be dragged. They are large enough for a finger and do not overlap.
  places(balls: Balls): { top: Place; lowest: Place } {
    const n = this.d.scenario.balls.length - 1;
    const [high, low] = [this.y(balls.position[n]), this.y(balls.position[0])];
    const [above, below] = [Math.max(this.radius(n), 22), Math.max(this.radius(0), 22)];
    const middle = 0.5 * (high + this.radius(n) + low - this.radius(0));
    const between = (from: number, to: number, width: number): Place => ({
      x: this.x,
      y: 0.5 * (from + to),
      width,
      height: to - from,
    });
    return {
      top: between(high - above, Math.min(high + above, middle), 2 * above),
      lowest: between(Math.max(low - below, middle), low + below, 2 * below),
    };
  }

  note(balls: Balls, i: number, text: string): void {
    const { pen } = this;
    pen.font(1.1, 650);
    const left = Math.min(this.x + this.radius(i) + pen.size, this.right - pen.widthOf(text) - 4);
    pen.label(text, left, this.y(balls.position[i]), pen.theme.ink, "left");
  }

  shadow(balls: Balls): void {
    const { d, floor } = this;
    const { g, theme, size } = this.pen;
    const above = Math.max(balls.position[0] - d.scenario.balls[0].radius, 0) * this.scale;
    const wide = this.radius(0) * (1 + 0.15 * Math.min(above / (4 * this.radius(0)), 1));
    g.globalAlpha = (theme.dark ? 0.7 : 0.22) / (1 + above / (2 * this.radius(0)));
    g.fillStyle = "#000000";
    g.beginPath();
    g.ellipse(this.x, floor + 0.35 * size, wide, Math.max(0.16 * wide, 2), 0, 0, 2 * Math.PI);
    g.fill();
    g.globalAlpha = 1;
  }

  // A ball is flattened where it overlaps a neighbour or the floor, and becomes wider. An enlarged one stands on the
  // next one.
  balls(balls: Balls): void {
    const { d } = this;
    const { g } = this.pen;
    let below = this.floor; // top of the ball below
    d.scenario.balls.forEach((b, i) => {
      const pressed = (pair: number): number =>
        pair < d.scenario.balls.length ? Math.max(-balls.gap[pair], 0) * (pair === 0 ? 1 : 0.5) : 0;
      const [low, high] = [balls.position[i] - b.radius + pressed(i), balls.position[i] + b.radius - pressed(i + 1)];
      const enlarged = this.radius(i) / b.radius;
      const ry = Math.max(0.5 * (high - low) * enlarged, 0.3 * this.radius(i));
      const rx = this.radius(i) * Math.sqrt(Math.max(this.radius(i) / ry, 0.5));
      const y = Math.min(this.y(0.5 * (low + high)), (enlarged > 1.001 * this.scale ? below : this.floor) - ry);
      below = y - ry;
      drawBall(g, this.x, y, rx, shaded(g, this.x, y, rx, ry, this.color, i), ry);
    });
  }

  // Arrows of the contact forces, beside the balls.
  forces(balls: Balls): void {
    const { pen, d } = this;
    const { theme, size } = pen;
    const most = Math.max(...d.peakForce, 1e-300);
    const longest = 5.5 * size;
    const n = d.scenario.balls.length;
    pen.font(0.85, 600);
    for (let pair = 0; pair < n; pair++) {
      const force = balls.force[pair];
      if (!(force > 0.004 * most)) continue;
      const length = Math.max((longest * force) / most, 0.7 * size);
      const way = n > 2 && pair % 2 === 1 ? -1 : 1; // arrows of neighbouring contacts are on different sides
      const side = this.x + way * (this.radius(Math.max(pair - 1, 0)) + 1.3 * size);
      const y = pair === 0 ? this.floor : this.y(balls.position[pair - 1] + d.scenario.balls[pair - 1].radius);
      arrow(pen, side, y, y - length, 0.45 * size);
      if (pair > 0) arrow(pen, side, y, y + length, 0.45 * size);
      const text = withUnit(force, "N", 2);
      const end = side + way * (0.7 * size + pen.widthOf(text));
      if (end < this.right && end > this.right - 2 * this.x)
        pen.text(text, side + way * 0.7 * size, y - 0.5 * length, theme.ink, way > 0 ? "left" : "right");
    }
  }

  // Collisions are instantaneous. Each is shown as a ring that grows and fades.
  flashes(track: Track, balls: Balls, toScreen: (t: number) => number): void {
    const { d, m, pen } = this;
    for (const c of track.run.contacts.slice(0, 400)) {
      if (c.begin > track.run.last) break;
      const since = m.screen - toScreen(c.begin);
      if (!(since >= 0 && since < flash)) continue;
      const i = Math.max(c.pair - 1, 0);
      const y = c.pair === 0 ? this.floor : this.y(balls.position[i] + d.scenario.balls[i].radius);
      pen.g.globalAlpha = 1 - since / flash;
      const radius = pen.size * (0.5 + (5 * since) / flash);
      pen.stroked(this.color, 0.22 * pen.size, [], () => pen.g.arc(this.x, y, radius, 0, 2 * Math.PI));
      pen.g.globalAlpha = 1;
    }
  }

  // Writes the rebound height of the top ball once the ball has reached it.
  height(track: Track, balls: Balls, wide: number): void {
    const { pen, d } = this;
    const { size } = pen;
    const top = d.scenario.balls.length - 1;
    const peak = track.peaks[top];
    if (!Number.isFinite(peak) || this.m.time < track.run.last || d.scenario.cradle) return;
    const reached = balls.velocity[top] <= 0 || balls.position[top] > 0.985 * peak;
    if (!reached) return;
    const y = this.y(peak);
    pen.line(this.x - wide, y, this.x + wide, y, this.color, Math.max(2, size / 8));
    // Beside the ball, smaller where there is little room.
    const room = Math.max(wide - this.radius(top) - 0.4 * size, 1);
    pen.font(1.5, 700);
    const fits = Math.min(1, room / pen.widthOf(metres(peak)));
    pen.font(Math.max(1.5 * fits, 0.9), 700);
    pen.label(metres(peak), this.x - wide, y - 0.2 * size, this.color, "left", "bottom");
  }
}

function arrow(pen: Pen, x: number, from: number, to: number, head: number): void {
  const way = Math.sign(to - from);
  const { ink } = pen.theme;
  pen.line(x, from, x, to - way * head, ink, 0.4 * head + 1);
  pen.area(
    [
      [x, to],
      [x - 0.7 * head, to - way * 1.4 * head],
      [x + 0.7 * head, to - way * 1.4 * head],
    ],
    ink,
  );
}
