// Close-up: gaps and compressions are magnified, forces are arrows, and ratios of the radii are reduced.
import type { State } from "../core/core";
import type { Drop, Track } from "../core/drop";
import { forceName, niceBelow, withUnit } from "../support/format";
import { grown } from "../support/plot";
import { Line } from "./ball";
import { Painter, type Moment, type Rect } from "./painter";
import type { Theme } from "../style/theme";

// Label at a contact.
interface Tag {
  along: number; // position of the contact
  radius: number; // of the larger ball of the contact
  text: string;
  color: string;
  weight: number;
}

// Ascending positions near the wanted ones, at least `distance` apart and within [low, high] if possible.
export function apart(wanted: number[], distance: number, low: number, high: number): number[] {
  const places = [...wanted];
  for (let i = 0; i < places.length; i++) places[i] = Math.max(places[i], i > 0 ? places[i - 1] + distance : low);
  for (let i = places.length - 1; i >= 0; i--)
    places[i] = Math.min(places[i], i + 1 < places.length ? places[i + 1] - distance : high);
  for (let i = 0; i < places.length; i++) places[i] = Math.max(places[i], i > 0 ? places[i - 1] + distance : low);
  return places;
}

// The close-up alone.
export function drawCloseUp(
  g: CanvasRenderingContext2D,
  w: number,
  h: number,
  d: Drop,
  m: Moment,
  theme: Theme,
  size: number,
): void {
  g.clearRect(0, 0, w, h);
  new CloseUp(g, d, m, theme, size).draw({ x: 0, y: 0, w, h });
}

export class CloseUp extends Painter {
  draw(r: Rect): void {
    this.header(r, "Close-up");
    const cradle = this.d.scenario.cradle;
    const { size } = this;
    this.sizesSaid(r);
    const begin = cradle ? r.y + 3.4 * size : r.x;
    const width = (cradle ? r.h - 3.6 * size : r.w) / 2;
    const length = cradle ? r.w - 5.6 * size : r.h - 6.4 * size;
    const open = Math.min(2.1 * size, (0.4 * length) / this.d.scenario.balls.length); // space for a gap
    const radii = this.schematicRadii(
      length,
      cradle
        ? Math.min(0.34 * width, 0.62 * width - 3.2 * size)
        : width * Math.min(0.27, Math.max(0.16, 0.5 - (3.1 * size) / width)),
      open,
    ); // leaves space for the forces
    const pairs = Math.max(...this.d.compression.slice(1), 1e-15);
    const magnify = this.d.compression.map((c, j) => (1.1 * size) / Math.max(j === 0 ? c : pairs, 1e-15));
    this.scales(r, magnify);
    if (!cradle) this.floor(r.x, r.x + r.w, r.y + r.h - 2.1 * size);
    const places = this.models().map((_, k) => begin + (k + (cradle ? 0.62 : 0.31)) * width);
    this.models().forEach(([name, color, state, track, ghost], k) => {
      const middle = places[k];
      const edge = k + 1 < places.length ? places[k + 1] - Math.max(...radii) - 0.3 * size : r.x + r.w;
      const line = new Line(this.g, cradle, cradle ? r.x + 5.2 * size : r.y + r.h - 2.1 * size, middle);
      this.font(1, 600);
      if (cradle) this.text(name, r.x, middle, color);
      else this.text(name, middle, r.y + r.h - 0.95 * size, color, "center");
      this.stack(line, state, track, radii, magnify, 0.9 * open, ghost, edge);
    });
  }

  private sizesSaid(r: Rect): void {
    const { size, theme } = this;
    const begin = r.x + this.widthOf("Close-up") + 0.8 * size;
    this.font(0.88);
    const note = ["sizes ∝ R⁰·⁴, gaps magnified", "sizes ∝ R⁰·⁴"].find((x) => begin + this.widthOf(x) < r.x + r.w);
    if (note) this.text(note, begin, r.y + 0.9 * size, theme.muted);
  }

  // Radii in the picture. They are proportional to R to the power 0.4, so that small balls are visible.
  private schematicRadii(length: number, widest: number, open: number): number[] {
    const raw = this.d.scenario.balls.map((b) => b.radius ** 0.4);
    const free = length - raw.length * open;
    const factor = Math.min(free / (2 * raw.reduce((a, b) => a + b, 0)), widest / Math.max(...raw));
    return raw.map((x) => Math.max(x * factor, 4));
  }

  private scales(r: Rect, magnify: number[]): void {
    const { size, theme } = this;
    this.font(0.88);
    let x = r.x;
    const y = r.y + 2.35 * size;
    const bars: [string, number][] = this.d.scenario.cradle
      ? [["gaps and compressions", magnify[1]]]
      : [
          ["floor", magnify[0]],
          ["balls", magnify[1]],
        ];
    const bar = (x0: number, y0: number, x1: number, y1: number): void =>
      this.line(x0, y0, x1, y1, theme.muted, 2 * grown(size));
    for (const [name, scale] of bars) {
      const metres = niceBelow((2.4 * size) / scale);
      const length = metres * scale;
      bar(x + 1, y, x + 1 + length, y);
      for (const end of [x + 1, x + 1 + length]) bar(end, y - 4, end, y + 4);
      const text =
        [`${withUnit(metres, "m", 1)} ${name}`, withUnit(metres, "m", 1)].find(
          (t) => x + length + 6 + this.widthOf(t) < r.x + r.w,
        ) ?? "";
      this.text(text, x + length + 6, y, theme.muted);
      x += length + 6 + this.widthOf(text) + 0.8 * size;
    }
  }

  // `limit`: the widest gap that is drawn [pixels]; a wider one is dotted. `edge`: right end of the space for labels.
  private stack(
    line: Line,
    state: State,
    track: Track,
    radii: number[],
    magnify: number[],
    limit: number,
    ghost: boolean,
    edge: number,
  ): void {
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
    const first = floor ? 0 : 1; // contact
    if (ghost) for (let j = first; j < n; j++) this.flash(line, j, cuts[j], track); // behind the balls
    for (let i = 0; i < n; i++) {
      this.g.strokeStyle = ghost ? theme.icm : theme.ink;
      this.g.lineWidth = 2;
      const low = i > 0 && state.gap[i] < 0 ? cuts[i] : i === 0 && floor ? 0 : -1e4;
      const high = i + 1 < n && state.gap[i + 1] < 0 ? cuts[i + 1] : 1e4;
      line.cutBall(centers[i], radii[i], low, high, this.look(ghost, i, radii[i]));
    }
    const tags: Tag[] = [];
    for (let j = first; j < n; j++) {
      const middle = j === 0 ? Math.max((centers[0] - radii[0]) / 2, 0) : cuts[j];
      this.contact(line, j, cuts[j], state, radii);
      if (broken[j]) this.dots(line, middle, limit);
      tags.push(this.tag(j, middle, state, Math.max(radii[j], j > 0 ? radii[j - 1] : 0)));
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
    const gap =
      s.gap[j] > 0 ? withUnit(s.gap[j], "m", 3, true) : s.gap[j] < 0 && s.force[j] === 0 ? "no force" : "touching";
    return {
      along,
      radius,
      text: force > 0 ? `${forceName(j)} ${withUnit(force, "N", 3, true)}` : gap,
      color: force > 0 ? this.theme.pairs[j] : this.theme.muted,
      weight: force > 0 ? 700 : 400,
    };
  }

  // Labels to the right of a column, each with a line to its contact. Without enough space a force is written over the
  // ball, and a gap is omitted.
  private tagsBeside(line: Line, tags: Tag[], top: number, edge: number): void {
    const { g, size, theme } = this;
    const places = apart(
      tags.map((t) => Math.max(t.along, 0.8 * size)),
      1.2 * size,
      0.8 * size,
      Math.max(top + size, 0),
    );
    const reach = Math.max(...tags.map((t) => t.radius)) + 0.4 * size;
    tags.forEach((t, i) => {
      this.font(0.92, t.weight);
      const [x, y] = line.at(places[i], reach);
      const over = Math.max(x + this.widthOf(t.text) - edge, 0);
      if (over > 0.8 * size && t.weight < 700) return;
      g.strokeStyle = theme.line;
      g.lineWidth = 1;
      line.segment(t.along, Math.min(0.72 * t.radius, reach - 6), places[i], reach - 3);
      this.label(t.text, x - over, y, t.color, "left");
    });
  }

  // Labels above a row of balls, in up to three lines; gaps without space are omitted.
  private tagsAbove(line: Line, tags: Tag[], radius: number): void {
    const { size } = this;
    const ends = [-Infinity, -Infinity, -Infinity];
    for (const t of tags) {
      this.font(0.92, t.weight);
      const half = this.widthOf(t.text) / 2;
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
    const last = track.shown.reduce(
      (a, c) => (c.pair === pair && c.begin <= this.m.time ? Math.max(a, c.begin) : a),
      -Infinity,
    );
    const age = (this.m.time - last) / this.m.rate / 0.4;
    if (!(age < 1)) return;
    const { g, size } = this;
    g.strokeStyle = this.theme.icm;
    g.lineWidth = 3;
    g.globalAlpha = 1 - age;
    for (let i = 0; i < 8; i++) {
      const [c, s] = [Math.cos((i * Math.PI) / 4), Math.sin((i * Math.PI) / 4)];
      if (pair === 0 && s < -0.1) continue; // nothing below the floor
      const [r0, r1] = [(0.5 + 0.7 * age) * size, (0.9 + 1.1 * age) * size];
      line.segment(plane + r0 * s, r0 * c, plane + r1 * s, r1 * c);
    }
    g.globalAlpha = 1;
  }
}
