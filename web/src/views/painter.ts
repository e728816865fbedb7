// What the drawings of the balls share.
import type { State } from "../core/core";
import type { Drop, Track } from "../core/drop";
import { Pen } from "../support/pen";
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

export class Painter extends Pen {
  constructor(
    g: CanvasRenderingContext2D,
    protected readonly d: Drop,
    protected readonly m: Moment,
    theme: Theme,
    size: number,
  ) {
    super(g, theme, size);
  }

  // Writes the first title that fits.
  protected header(r: Rect, ...titles: string[]): void {
    this.font(1, 600);
    const title = titles.find((x) => this.widthOf(x) < r.w) ?? titles[titles.length - 1];
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

  protected floor(x0: number, x1: number, y: number): void {
    this.line(x0, y + 1, x1, y + 1, this.theme.ink, 2.5);
  }
}
