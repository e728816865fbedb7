// The balls at true scale: Newton's (filled) beside those of the independent-collisions model (outlined).
import type { Drop, Track } from "../core/drop";
import { digits, lengths, niceTicks, withUnit } from "../support/format";
import { laterHeight } from "../report/table";
import { grown, lettering } from "../support/plot";
import { Line } from "./ball";
import { Painter, type Moment, type Rect } from "./painter";
import type { Theme } from "../style/theme";

// Draws the balls at true scale as a picture of its own; an empty title is omitted.
export function drawTrueScale(
  g: CanvasRenderingContext2D,
  r: Rect,
  d: Drop,
  m: Moment,
  theme: Theme,
  title: string,
): void {
  const size = Math.min(Math.max(r.w / 34, lettering.least), r.w / 12, Math.max(lettering.least, 18));
  new TrueScale(g, d, m, theme, size).draw(r, title);
}

export class TrueScale extends Painter {
  draw(r: Rect, ...titles: string[]): void {
    this.header(r, ...titles);
    if (this.d.scenario.cradle) this.trueCradle(r);
    else this.trueDrop(r);
  }

  private trueDrop(r: Rect): void {
    const { g, d, theme, size } = this;
    const floor = r.y + r.h - 2.1 * size;
    const top = r.y + 2.2 * size;
    const left = r.x + 3.6 * size;
    const lane = (r.x + r.w - left) / 2;
    const largest = Math.max(...d.scenario.balls.map((b) => b.radius));
    const scale = Math.min((floor - top) / (1.03 * d.top), (0.84 * lane) / (2 * largest));
    const height = (floor - top) / scale;
    this.font(0.88);
    const ticks = niceTicks(0, height, Math.min(6, (floor - top) / (2.6 * size)));
    for (const z of ticks) {
      const y = floor - z * scale;
      this.line(left, y, r.x + r.w, y, theme.faint);
      this.text(digitsOf(z, ticks), left - 8, y, theme.muted, "right");
    }
    this.floor(left, r.x + r.w, floor);
    const nameSize = Math.min(1, lane / (3 * size));
    this.font(nameSize, 600);
    const needed = 0.5 * this.models().reduce((sum, [name]) => sum + this.widthOf(name), size);
    const aside = 0.5 * Math.max(needed - lane, 0); // shifts the names apart if a lane is narrower than its name
    this.models().forEach(([name, color, state, track, ghost], k) => {
      const line = new Line(g, false, floor, left + (k + 0.5) * lane);
      this.font(nameSize, 600);
      this.text(name, line.center + (k === 0 ? -aside : aside), floor + 1.15 * size, color, "center");
      line.balls(d.scenario.balls, state.position, scale, 10, (i, radius) => this.look(ghost, i, radius));
      if (this.m.time > track.known) this.label("not resolved", line.center, floor - 0.5 * (floor - top), color);
      else if (this.m.time > track.run.last) this.peaks(line, track, scale, lane, color);
    });
  }

  // Marks the rebound height of the top ball, and a greater height after the next floor contact.
  private peaks(line: Line, track: Track, scale: number, lane: number, color: string): void {
    const { d, g, size } = this;
    const n = d.scenario.balls.length - 1;
    const both = [d.newton, d.icm];
    const k = both.indexOf(track);
    const mark = (z: number, text: string): void => {
      line.segment(z * scale, -0.42 * lane, z * scale, 0.42 * lane);
      const [x, y] = line.at(z * scale);
      this.label(text, x, Math.max(y - 0.9 * size, 1.9 * size), color);
    };
    g.strokeStyle = color;
    g.lineWidth = 2 * grown(size);
    this.font(0.95, 600);
    const height = track.peaks[n];
    if (!Number.isFinite(height)) return;
    mark(height, lengths(d.newton.peaks[n], d.icm.peaks[n])[k]);
    const later = laterHeight(track, n);
    if (later === null || (later - height) * scale < 2 * size) return;
    g.strokeStyle = color;
    g.lineWidth = 1.5;
    g.setLineDash([4, 4]);
    this.font(0.88, 400);
    mark(later, `later ${withUnit(later, "m", 3, true)}`);
    g.setLineDash([]);
  }

  private trueCradle(r: Rect): void {
    const { g, d, theme, size } = this;
    const left = r.x + 4.6 * size;
    const right = r.x + r.w - 8;
    const top = r.y + 2.2 * size;
    const bottom = r.y + r.h - 2.2 * size;
    const row = (bottom - top) / 2;
    const scale = Math.min(
      (right - left) / (1.02 * (d.top - d.bottom)),
      (0.8 * row) / (2 * Math.max(...d.scenario.balls.map((b) => b.radius))),
    );
    const origin = left - d.bottom * scale + (right - left - (d.top - d.bottom) * scale) / 2;
    this.font(0.88);
    const ticks = niceTicks(d.bottom, d.top, Math.min(6, ((d.top - d.bottom) * scale) / (4 * size)));
    for (const z of ticks) {
      this.line(origin + z * scale, top, origin + z * scale, bottom, theme.faint);
      this.text(digitsOf(z, ticks), origin + z * scale, bottom + size, theme.muted, "center");
    }
    this.models().forEach(([name, color, state, , ghost], k) => {
      const line = new Line(g, true, origin, top + (k + 0.5) * row);
      this.font(1, 600);
      this.text(name, r.x, line.center, color);
      line.balls(d.scenario.balls, state.position, scale, 3, (i, radius) => this.look(ghost, i, radius));
    });
  }
}

function digitsOf(x: number, ticks: number[]): string {
  const step = ticks.length > 1 ? ticks[1] - ticks[0] : 1;
  return step >= 1e-4 ? x.toFixed(Math.max(0, -Math.floor(Math.log10(step) + 1e-9))).replace("-", "−") : digits(x);
}
