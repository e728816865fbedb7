// What the drawings of the balls share: colours and letters.
import type { State } from "../core/core";
import type { Drop, Track } from "../core/drop";
import { dashed, type Look } from "./ball";
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

  // Writes the first title that fits.
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
  protected look(ghost: boolean, ball: number, radius: number): Look {
    return ghost ? dashed(this.theme, this.size, radius) : { fill: this.theme.balls[ball] };
  }

  // Text with a halo, which is legible over other drawings.
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
