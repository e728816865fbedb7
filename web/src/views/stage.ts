// The animation: the balls at true scale, and a close-up in which gaps and compressions are magnified. Each shows Newton's
// equations (filled) and the independent-collisions model (outlined) at the same time on the same scale.
import type { State } from "../core/core";
import type { Drop, Track } from "../core/drop";
import { digits, forceName, lengths, niceBelow, niceTicks, withUnit } from "../support/format";
import { laterHeight } from "./numbers";
import { grown, lettering } from "../support/plot";
import { independent, newton } from "../core/tables";
import type { Theme } from "../style/theme";

interface Rect {
  x: number;
  y: number;
  w: number;
  h: number;
}

// A line of balls: `along` grows from the floor upwards, or to the right for a cradle.
class Line {
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
    g.save();
    g.beginPath();
    const wide = radius + 4;
    g.moveTo(...this.at(low, -wide));
    g.lineTo(...this.at(low, wide));
    g.lineTo(...this.at(high, wide));
    g.lineTo(...this.at(high, -wide));
    g.clip();
    g.beginPath();
    const [x, y] = this.at(along);
    g.arc(x, y, radius, 0, 2 * Math.PI);
    paint(g);
    g.restore();
    for (const plane of [low, high]) {
      const half = radius * radius - (plane - along) ** 2;
      if (half > 0) this.segment(plane, -Math.sqrt(half), plane, Math.sqrt(half));
    }
  }
}

// Label at a contact.
interface Tag {
  along: number; // position of the contact
  radius: number; // of the larger of its balls
  text: string;
  color: string;
  weight: number;
}

// The positions nearest to the wanted ones, ascending, at least a distance apart, within [low, high] if possible.
export function apart(wanted: number[], distance: number, low: number, high: number): number[] {
  const places = [...wanted];
  for (let i = 0; i < places.length; i++) places[i] = Math.max(places[i], i > 0 ? places[i - 1] + distance : low);
  for (let i = places.length - 1; i >= 0; i--) places[i] = Math.min(places[i], i + 1 < places.length ? places[i + 1] - distance : high);
  for (let i = 0; i < places.length; i++) places[i] = Math.max(places[i], i > 0 ? places[i - 1] + distance : low);
  return places;
}

export interface Moment {
  time: number;
  rate: number; // physical seconds per screen second
  newton: State;
  icm: State;
}

export function drawStage(g: CanvasRenderingContext2D, w: number, h: number, d: Drop, m: Moment, theme: Theme): void {
  g.clearRect(0, 0, w, h);
  const size = Math.max(Math.min(Math.max(w / 42, 14), Math.max(18, Math.min(w / 52, h / 26))), Math.min(lettering.least, w / 38, h / 20));
  const pad = 6;
  const stacked = d.scenario.cradle || w < 480;
  const trueShare = d.scenario.cradle ? 0.42 : stacked ? 0.47 : 0.37;
  const first: Rect = stacked ? { x: pad, y: 0, w: w - 2 * pad, h: h * trueShare } : { x: pad, y: 0, w: w * trueShare, h };
  const second: Rect = stacked
    ? { x: pad, y: h * trueShare + 6, w: w - 2 * pad, h: h * (1 - trueShare) - 6 }
    : { x: first.x + first.w + 18, y: 0, w: w - first.x - first.w - 24, h };
  const paint = new Painter(g, d, m, theme, size);
  paint.trueScale(first);
  paint.closeUp(second);
}

// The balls at true scale alone, with a title unless that is empty.
export function drawTrueScale(g: CanvasRenderingContext2D, r: Rect, d: Drop, m: Moment, theme: Theme, title: string): void {
  const size = Math.min(Math.max(r.w / 34, lettering.least), r.w / 12, Math.max(lettering.least, 18));
  new Painter(g, d, m, theme, size).trueScale(r, title);
}

class Painter {
  constructor(
    private readonly g: CanvasRenderingContext2D,
    private readonly d: Drop,
    private readonly m: Moment,
    private readonly theme: Theme,
    private readonly size: number,
  ) {}

  private font(scale = 1, weight = 400): void {
    this.g.font = `${weight} ${Math.round(this.size * scale)}px ${this.theme.font}`;
  }

  private text(text: string, x: number, y: number, color: string, align: CanvasTextAlign = "left"): void {
    this.g.textAlign = align;
    this.g.fillStyle = color;
    this.g.fillText(text, x, y);
  }

  private header(r: Rect, title: string): void {
    this.g.textBaseline = "middle";
    this.font(1, 600);
    this.text(title, r.x, r.y + this.size * 0.9, this.theme.ink);
  }

  private models(): [string, string, State, Track, boolean][] {
    return [
      [newton.short, this.theme.newton, this.m.newton, this.d.newton, false],
      [independent.short, this.theme.icm, this.m.icm, this.d.icm, true],
    ];
  }

  // Newton's balls are filled, those of the independent-collisions model outlined.
  private style(ghost: boolean, ball: number, radius: number): (g: CanvasRenderingContext2D) => void {
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

  // ---- true scale ---------------------------------------------------------------------------------------

  trueScale(r: Rect, title = "True scale, metres"): void {
    this.header(r, title);
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
    g.lineWidth = 1;
    const ticks = niceTicks(0, height, Math.min(6, (floor - top) / (2.6 * size)));
    for (const z of ticks) {
      const y = floor - z * scale;
      g.strokeStyle = theme.faint;
      this.line(left, y, r.x + r.w, y);
      this.text(digitsOf(z, ticks), left - 8, y, theme.muted, "right");
    }
    this.floor(left, r.x + r.w, floor);
    this.models().forEach(([name, color, state, track, ghost], k) => {
      const line = new Line(g, false, floor, left + (k + 0.5) * lane);
      this.font(1, 600);
      this.text(name, line.center, floor + 1.15 * size, color, "center");
      d.scenario.balls.forEach((b, i) => {
        const radius = Math.max(b.radius * scale, 3);
        line.ball(Math.max(state.position[i] * scale, radius), radius, -1e4, 1e4, this.style(ghost, i, radius));
      });
      if (this.m.time > track.known) this.label("not resolved", line.center, floor - 0.5 * (floor - top), color);
      else if (this.m.time > track.run.last) this.peaks(line, track, scale, lane, color);
    });
  }

  // The rebound height of the top ball, and where it comes higher after the next floor contact, that.
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

  // Text with a halo, for places where something may lie behind.
  private label(text: string, x: number, y: number, color: string, align: CanvasTextAlign = "center"): void {
    this.g.textAlign = align;
    this.g.lineWidth = 4;
    this.g.strokeStyle = this.theme.ground;
    this.g.lineJoin = "round";
    this.g.strokeText(text, x, y);
    this.g.fillStyle = color;
    this.g.fillText(text, x, y);
  }

  private trueCradle(r: Rect): void {
    const { g, d, theme, size } = this;
    const left = r.x + 4.6 * size;
    const right = r.x + r.w - 8;
    const top = r.y + 2.2 * size;
    const bottom = r.y + r.h - 2.2 * size;
    const row = (bottom - top) / 2;
    const scale = Math.min((right - left) / (1.02 * (d.top - d.bottom)), (0.8 * row) / (2 * Math.max(...d.scenario.balls.map((b) => b.radius))));
    const origin = left - d.bottom * scale + ((right - left) - (d.top - d.bottom) * scale) / 2;
    this.font(0.88);
    const ticks = niceTicks(d.bottom, d.top, 6);
    for (const z of ticks) {
      g.strokeStyle = theme.faint;
      g.lineWidth = 1;
      this.line(origin + z * scale, top, origin + z * scale, bottom);
      this.text(digitsOf(z, ticks), origin + z * scale, bottom + size, theme.muted, "center");
    }
    this.models().forEach(([name, color, state, , ghost], k) => {
      const line = new Line(g, true, origin, top + (k + 0.5) * row);
      this.font(1, 600);
      this.text(name, r.x, line.center, color);
      d.scenario.balls.forEach((b, i) =>
        line.ball(state.position[i] * scale, Math.max(b.radius * scale, 3), -1e4, 1e4, this.style(ghost, i, b.radius * scale)),
      );
    });
  }

  private line(x0: number, y0: number, x1: number, y1: number): void {
    this.g.beginPath();
    this.g.moveTo(x0, y0);
    this.g.lineTo(x1, y1);
    this.g.stroke();
  }

  private floor(x0: number, x1: number, y: number): void {
    this.g.strokeStyle = this.theme.ink;
    this.g.lineWidth = 2.5;
    this.line(x0, y + 1, x1, y + 1);
  }

  // ---- close-up -----------------------------------------------------------------------------------------

  closeUp(r: Rect): void {
    this.header(r, "Close-up");
    const cradle = this.d.scenario.cradle;
    const { size } = this;
    this.sizesSaid(r);
    const begin = cradle ? r.y + 3.4 * size : r.x;
    const width = (cradle ? r.h - 3.6 * size : r.w) / 2;
    const length = cradle ? r.w - 5.6 * size : r.h - 6.4 * size;
    const open = Math.min(2.1 * size, (0.4 * length) / this.d.scenario.balls.length); // room for a gap
    const radii = this.schematicRadii(length, cradle ? Math.min(0.34 * width, 0.62 * width - 3.2 * size) : width * Math.min(0.27, Math.max(0.16, 0.5 - (3.1 * size) / width)), open); // leaves room for the forces
    const pairs = Math.max(...this.d.compression.slice(1), 1e-15);
    const magnify = this.d.compression.map((c, j) => (1.1 * size) / Math.max(j === 0 ? c : pairs, 1e-15));
    this.scales(r, magnify);
    if (!cradle) this.floor(r.x, r.x + r.w, r.y + r.h - 2.1 * size);
    this.models().forEach(([name, color, state, track, ghost], k) => {
      const middle = begin + (k + (cradle ? 0.62 : 0.31)) * width;
      const line = new Line(this.g, cradle, cradle ? r.x + 5.2 * size : r.y + r.h - 2.1 * size, middle);
      this.font(1, 600);
      if (cradle) this.text(name, r.x, middle, color);
      else this.text(name, middle, r.y + r.h - 0.95 * size, color, "center");
      this.stack(line, state, track, radii, magnify, 0.9 * open, ghost, r.x + r.w);
    });
  }

  private sizesSaid(r: Rect): void {
    const { size, theme } = this;
    const begin = r.x + this.g.measureText("Close-up").width + 0.8 * size;
    this.font(0.88);
    this.text("sizes ∝ R⁰·⁴, gaps magnified", begin, r.y + 0.9 * size, theme.muted);
  }

  // Sizes that show all balls: ratios are compressed to their power 0.4.
  private schematicRadii(length: number, widest: number, open: number): number[] {
    const raw = this.d.scenario.balls.map((b) => b.radius ** 0.4);
    const free = length - raw.length * open;
    const factor = Math.min(free / (2 * raw.reduce((a, b) => a + b, 0)), widest / Math.max(...raw));
    return raw.map((x) => Math.max(x * factor, 4));
  }

  private scales(r: Rect, magnify: number[]): void {
    const { g, size, theme } = this;
    this.font(0.88);
    let x = r.x;
    const y = r.y + 2.35 * size;
    const bars: [string, number][] = this.d.scenario.cradle
      ? [["gaps and compressions", magnify[1]]]
      : [["floor", magnify[0]], ["balls", magnify[1]]];
    g.lineWidth = 2 * grown(size);
    for (const [name, scale] of bars) {
      const metres = niceBelow((2.4 * size) / scale);
      const length = metres * scale;
      g.strokeStyle = theme.muted;
      this.line(x + 1, y, x + 1 + length, y);
      for (const end of [x + 1, x + 1 + length]) this.line(end, y - 4, end, y + 4);
      const text = `${withUnit(metres, "m", 1)} ${name}`;
      this.text(text, x + length + 8, y, theme.muted);
      x += length + 8 + g.measureText(text).width + 1.2 * size;
    }
  }

  // `limit`: the widest gap that is drawn [pixels]; a wider one is dotted. `edge`: where the picture ends on the right.
  private stack(line: Line, state: State, track: Track, radii: number[], magnify: number[], limit: number, ghost: boolean, edge: number): void {
    const { theme, d } = this;
    const n = radii.length;
    const floor = !d.scenario.cradle;
    const centers: number[] = [];
    const cuts: number[] = []; // plane of contact j: below ball j
    const broken: boolean[] = [];
    let surface = 0;
    for (let i = 0; i < n; i++) {
      const wanted = i === 0 && !floor ? 0 : state.gap[i] * magnify[i];
      const deepest = 0.5 * Math.min(radii[i], i > 0 ? radii[i - 1] : Infinity); // a small ball stays visible
      const gap = Math.max(Math.min(wanted, limit), -deepest);
      broken.push(wanted > limit);
      centers.push(surface + gap + radii[i]);
      if (i === 0 || gap >= 0) cuts.push(i === 0 ? (floor ? 0 : -1e4) : surface + gap / 2);
      else {
        const distance = centers[i] - centers[i - 1];
        cuts.push(centers[i - 1] + (distance ** 2 + radii[i - 1] ** 2 - radii[i] ** 2) / (2 * distance));
      }
      surface = centers[i] + radii[i];
    }
    for (let i = 0; i < n; i++) {
      this.g.strokeStyle = ghost ? theme.icm : theme.ink;
      this.g.lineWidth = 2;
      const low = i > 0 && state.gap[i] < 0 ? cuts[i] : i === 0 && floor ? 0 : -1e4;
      const high = i + 1 < n && state.gap[i + 1] < 0 ? cuts[i + 1] : 1e4;
      line.ball(centers[i], radii[i], low, high, this.style(ghost, i, radii[i]));
    }
    const tags: Tag[] = [];
    for (let j = floor ? 0 : 1; j < n; j++) {
      const middle = j === 0 ? Math.max((centers[0] - radii[0]) / 2, 0) : cuts[j];
      this.contact(line, j, cuts[j], state, radii);
      if (broken[j]) this.dots(line, middle, limit);
      tags.push(this.tag(j, middle, state, Math.max(radii[j], j > 0 ? radii[j - 1] : 0)));
      if (ghost) this.flash(line, j, cuts[j], track);
    }
    if (line.horizontal) this.tagsAbove(line, tags, Math.max(...radii));
    else this.tagsBeside(line, tags, surface, edge);
  }

  private dots(line: Line, middle: number, limit: number): void {
    const { g } = this;
    const thick = grown(this.size);
    g.strokeStyle = this.theme.muted;
    g.lineWidth = 2 * thick;
    g.setLineDash([2 * thick, 4 * thick]);
    line.segment(middle - 0.4 * limit, 0, middle + 0.4 * limit, 0);
    g.setLineDash([]);
  }

  private forceOf(j: number, s: State): number {
    return s.force[j] > 1e-5 * this.d.peakForce[j] ? s.force[j] : 0;
  }

  // Arrows of the force in contact j.
  private contact(line: Line, j: number, plane: number, s: State, radii: number[]): void {
    const { g, theme, size, d } = this;
    const force = this.forceOf(j, s);
    if (force === 0) return;
    const room = 0.75 * Math.min(2.6 * size, radii[j], j > 0 ? radii[j - 1] : Infinity);
    const length = (0.25 + 0.75 * (force / Math.max(d.peakForce[j], 1e-30))) * room;
    for (const halo of [true, false]) {
      g.strokeStyle = g.fillStyle = halo ? theme.ground : theme.pairs[j];
      this.arrow(line, plane, plane + length, halo);
      if (j > 0) this.arrow(line, plane, plane - length, halo);
    }
  }

  private tag(j: number, along: number, s: State, radius: number): Tag {
    const force = this.forceOf(j, s);
    const gap = s.gap[j] > 0 ? withUnit(s.gap[j], "m", 3, true) : s.gap[j] < 0 && s.force[j] === 0 ? "no force" : "touching";
    return {
      along,
      radius,
      text: force > 0 ? `${forceName(j)} ${withUnit(force, "N", 3, true)}` : gap,
      color: force > 0 ? this.theme.pairs[j] : this.theme.muted,
      weight: force > 0 ? 700 : 400,
    };
  }

  // To the right of a column, one below the other, each with a line to its contact; over a ball at the edge.
  private tagsBeside(line: Line, tags: Tag[], top: number, edge: number): void {
    const { g, size, theme } = this;
    const places = apart(tags.map((t) => Math.max(t.along, 0.8 * size)), 1.2 * size, 0.8 * size, Math.max(top + size, 0));
    const reach = Math.max(...tags.map((t) => t.radius)) + 0.4 * size;
    tags.forEach((t, i) => {
      g.strokeStyle = theme.line;
      g.lineWidth = 1;
      line.segment(t.along, Math.min(0.72 * t.radius, reach - 6), places[i], reach - 3);
      this.font(0.92, t.weight);
      const [x, y] = line.at(places[i], reach);
      this.label(t.text, Math.min(x, edge - g.measureText(t.text).width), y, t.color, "left");
    });
  }

  // Above a row of balls, in as many lines as needed; gaps without room are left out.
  private tagsAbove(line: Line, tags: Tag[], radius: number): void {
    const { g, size } = this;
    const ends = [-Infinity, -Infinity, -Infinity];
    for (const t of tags) {
      this.font(0.92, t.weight);
      const half = g.measureText(t.text).width / 2;
      const [x, y] = line.at(t.along, -radius - 0.7 * size);
      const row = ends.findIndex((end) => x - half > end + 0.4 * size);
      if (row < 0 || (row === 2 && t.weight < 700)) continue;
      ends[row] = x + half;
      this.label(t.text, x, y - 1.15 * row * size, t.color);
    }
  }

  private arrow(line: Line, from: number, to: number, halo: boolean): void {
    const { g, size } = this;
    const head = Math.sign(to - from) * Math.min(0.55 * size, Math.abs(to - from) * 0.6);
    g.lineJoin = "round";
    g.lineWidth = halo ? 9 : 5;
    line.segment(from, 0, to - head, 0);
    g.beginPath();
    g.moveTo(...line.at(to, 0));
    g.lineTo(...line.at(to - head, -0.42 * size));
    g.lineTo(...line.at(to - head, 0.42 * size));
    g.closePath();
    g.lineWidth = 4;
    if (halo) g.stroke();
    g.fill();
  }

  // An instantaneous collision is shown for 0.4 s of the film.
  private flash(line: Line, pair: number, plane: number, track: Track): void {
    const last = track.shown.reduce((a, c) => (c.pair === pair && c.begin <= this.m.time ? Math.max(a, c.begin) : a), -Infinity);
    const age = (this.m.time - last) / this.m.rate / 0.4;
    if (!(age < 1)) return;
    const { g, size } = this;
    g.strokeStyle = this.theme.icm;
    g.lineWidth = 3;
    g.globalAlpha = 1 - age;
    for (let i = 0; i < 8; i++) {
      const [c, s] = [Math.cos((i * Math.PI) / 4), Math.sin((i * Math.PI) / 4)];
      const [r0, r1] = [(0.5 + 0.7 * age) * size, (0.9 + 1.1 * age) * size];
      line.segment(plane + r0 * s, r0 * c, plane + r1 * s, r1 * c);
    }
    g.globalAlpha = 1;
  }
}

function digitsOf(x: number, ticks: number[]): string {
  const step = ticks.length > 1 ? ticks[1] - ticks[0] : 1;
  return step >= 1e-4 ? x.toFixed(Math.max(0, -Math.floor(Math.log10(step) + 1e-9))).replace("-", "−") : digits(x);
}
