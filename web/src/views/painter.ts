// What the drawings of the balls share: colours, letters, a line of balls that may be pressed flat.
import type { State } from "../core/core";
import type { Drop, Track } from "../core/drop";
import { grown } from "../support/plot";
import { independent, newton } from "../scenario/tables";
import type { Theme } from "../style/theme";

export interface Rect {
  x: number;
  y: number;
  w: number;
  h: number;
}

export interface Moment {
  time: number;
  rate: number; // physical seconds per screen second
  newton: State;
  icm: State;
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
  // A ball, cut off outside [low, high] where it is pressed flat.
  ball(along: number, radius: number, low: number, high: number, paint: (g: CanvasRenderingContext2D) => void): void {
    const { g } = this;
    const [x, y] = this.at(along);
    const whole = low <= along - radius && high >= along + radius;
    if (whole) {
      g.beginPath();
      g.arc(x, y, radius, 0, 2 * Math.PI);
      return paint(g);
    }
    g.save();
    g.beginPath();
    const wide = radius + 4;
    g.moveTo(...this.at(low, -wide));
    g.lineTo(...this.at(low, wide));
    g.lineTo(...this.at(high, wide));
    g.lineTo(...this.at(high, -wide));
    g.clip();
    g.beginPath();
    g.arc(x, y, radius, 0, 2 * Math.PI);
    paint(g);
    g.restore();
    for (const plane of [low, high]) {
      const half = radius * radius - (plane - along) ** 2;
      if (half > 0) this.segment(plane, -Math.sqrt(half), plane, Math.sqrt(half));
    }
  }
}

export class Painter {
  constructor(
    protected readonly g: CanvasRenderingContext2D,
    protected readonly d: Drop,
    protected readonly m: Moment,
    protected readonly theme: Theme,
    protected readonly size: number,
  ) {}

  protected font(scale = 1, weight = 400): void {
    this.g.font = `${weight} ${Math.round(this.size * scale)}px ${this.theme.font}`;
  }

  protected text(text: string, x: number, y: number, color: string, align: CanvasTextAlign = "left"): void {
    this.g.textAlign = align;
    this.g.fillStyle = color;
    this.g.fillText(text, x, y);
  }

  // The first of the titles that fits.
  protected header(r: Rect, ...titles: string[]): void {
    this.g.textBaseline = "middle";
    this.font(1, 600);
    const title = titles.find((x) => this.g.measureText(x).width < r.w) ?? titles[titles.length - 1];
    this.text(title, r.x, r.y + this.size * 0.9, this.theme.ink);
  }

  protected models(): [string, string, State, Track, boolean][] {
    return [
      [newton.short, this.theme.newton, this.m.newton, this.d.newton, false],
      [independent.short, this.theme.icm, this.m.icm, this.d.icm, true],
    ];
  }

  // Newton's balls are filled, those of the independent-collisions model outlined.
  protected style(ghost: boolean, ball: number, radius: number): (g: CanvasRenderingContext2D) => void {
    const { theme } = this;
    return (g) => {
      g.fillStyle = ghost ? theme.ground : theme.balls[ball];
      g.fill();
      const thick = Math.min(grown(this.size), Math.max(radius / 6, 1));
      g.lineWidth = ghost ? 2.5 * thick : 1;
      g.strokeStyle = ghost ? theme.icm : theme.ink;
      g.setLineDash(ghost && radius > 7 ? [5 * thick, 3.5 * thick] : []);
      if (ghost) g.stroke();
      g.setLineDash([]);
    };
  }

  // Text with a halo, for places where something may lie behind.
  protected label(text: string, x: number, y: number, color: string, align: CanvasTextAlign = "center"): void {
    this.g.textAlign = align;
    this.g.lineWidth = 4;
    this.g.strokeStyle = this.theme.ground;
    this.g.lineJoin = "round";
    this.g.strokeText(text, x, y);
    this.g.fillStyle = color;
    this.g.fillText(text, x, y);
  }

  protected line(x0: number, y0: number, x1: number, y1: number): void {
    this.g.beginPath();
    this.g.moveTo(x0, y0);
    this.g.lineTo(x1, y1);
    this.g.stroke();
  }

  protected floor(x0: number, x1: number, y: number): void {
    this.g.strokeStyle = this.theme.ink;
    this.g.lineWidth = 2.5;
    this.line(x0, y + 1, x1, y + 1);
  }
}
