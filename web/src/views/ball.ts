// The drawing of a ball, for all pictures: filled by Newton's equations, outlined by independent collisions, or shaded.
import { grown } from "../support/plot";
import type { Ball } from "../scenario/scenario";
import type { Theme } from "../style/theme";

export interface Look {
  fill: string | CanvasGradient;
  edge?: { color: string; width: number; dash?: number[] };
}

// `height`: the vertical half axis of a ball that is pressed flat.
export function drawBall(
  g: CanvasRenderingContext2D,
  x: number,
  y: number,
  radius: number,
  { fill, edge }: Look,
  height = radius,
): void {
  g.beginPath();
  if (height === radius) g.arc(x, y, radius, 0, 2 * Math.PI);
  else g.ellipse(x, y, radius, height, 0, 0, 2 * Math.PI);
  g.fillStyle = fill;
  g.fill();
  if (!edge) return;
  g.strokeStyle = edge.color;
  g.lineWidth = edge.width;
  g.setLineDash(edge.dash ?? []);
  g.stroke();
  g.setLineDash([]);
}

export const filled = (theme: Theme, ball: number, width: number): Look => ({
  fill: theme.balls[ball],
  edge: { color: theme.ink, width },
});

export const outlined = (theme: Theme, width: number): Look => ({
  fill: theme.ground,
  edge: { color: theme.icm, width },
});

// Dashed where the ball is large enough.
export function dashed(theme: Theme, size: number, radius: number): Look {
  const thick = Math.min(grown(size), Math.max(radius / 6, 1));
  const dash = radius > 7 ? [5 * thick, 3.5 * thick] : [];
  return { fill: theme.ground, edge: { color: theme.icm, width: 2.5 * thick, dash } };
}

const channels = (color: string): number[] => [1, 3, 5].map((i) => parseInt(color.slice(i, i + 2), 16));

// Two colours #rrggbb; `share` of the second.
function mixed(a: string, b: string, share: number): string {
  const [x, y] = [channels(a), channels(b)];
  return `rgb(${x.map((v, i) => Math.round(v + (y[i] - v) * share)).join(" ")})`;
}

// Lit from the upper left; every second ball of a column is lighter.
export function shaded(
  g: CanvasRenderingContext2D,
  x: number,
  y: number,
  radius: number,
  height: number,
  color: string,
  ball: number,
): Look {
  const fill = g.createRadialGradient(x - 0.35 * radius, y - 0.4 * height, 0.1 * radius, x, y, 1.15 * radius);
  fill.addColorStop(0, mixed(color, "#ffffff", 0.55));
  fill.addColorStop(0.55, mixed(color, "#ffffff", 0.12 * (ball % 2)));
  fill.addColorStop(1, mixed(color, "#000000", 0.35));
  return { fill, edge: { color: mixed(color, "#000000", 0.5), width: 1.5 } };
}

// A line of balls: `along` grows from the floor upwards, or to the right for a cradle.
export class Line {
  constructor(
    readonly g: CanvasRenderingContext2D,
    readonly horizontal: boolean,
    readonly origin: number, // pixel at along = 0
    readonly center: number, // pixel across
  ) {}
  at(along: number, across = 0): [number, number] {
    return this.horizontal ? [this.origin + along, this.center + across] : [this.center + across, this.origin - along];
  }
  segment(a0: number, c0: number, a1: number, c1: number): void {
    this.g.beginPath();
    this.g.moveTo(...this.at(a0, c0));
    this.g.lineTo(...this.at(a1, c1));
    this.g.stroke();
  }

  // Balls at their positions, none with a radius below `least` [pixels] or below the floor. Enlarged ones stand on the
  // next one.
  balls(
    balls: readonly Ball[],
    position: ArrayLike<number>,
    scale: number,
    least: number,
    look: (ball: number, radius: number) => Look,
  ): void {
    let below = 0; // top of the ball below
    balls.forEach((b, i) => {
      const radius = Math.max(b.radius * scale, least);
      const lowest = b.radius * scale < least ? below + radius : radius;
      const along = this.horizontal ? position[i] * scale : Math.max(position[i] * scale, lowest);
      below = along + radius;
      drawBall(this.g, ...this.at(along), radius, look(i, radius));
    });
  }

  // A ball that is cut off outside [low, high], where it is pressed flat.
  cutBall(along: number, radius: number, low: number, high: number, look: Look): void {
    const { g } = this;
    const place = this.at(along);
    if (low <= along - radius && high >= along + radius) return drawBall(g, ...place, radius, look);
    g.save();
    g.beginPath();
    const wide = radius + 4;
    g.moveTo(...this.at(low, -wide));
    g.lineTo(...this.at(low, wide));
    g.lineTo(...this.at(high, wide));
    g.lineTo(...this.at(high, -wide));
    g.clip();
    drawBall(g, ...place, radius, look);
    g.restore();
    for (const plane of [low, high]) {
      const half = radius * radius - (plane - along) ** 2;
      if (half > 0) this.segment(plane, -Math.sqrt(half), plane, Math.sqrt(half));
    }
  }
}
