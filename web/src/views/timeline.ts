// Contact times for every ε (Fig. 3): each band is a contact.
import type { Contact, TimelineRow } from "../core/core";
import type { Drop } from "../core/drop";
import { drawAxes, fontSize, grown, Scale, setFont, stroke, timeTicks, timeUnit, type Frame } from "../support/plot";
import { piece, type Piece, type Pool } from "../core/pool";
import { columnOf, ranges, type Scenario } from "../scenario/scenario";
import type { Theme } from "../style/theme";

const even = 241; // rows to begin with
const finest = 1 / 4096; // of the distance between them, where the contacts change
const finestBend = 1 / 40; // where their times bend
const straight = 1 / 1500; // largest error of a line, relative to the times shown
const most = 1500; // rows
const patience = 4_000; // ms: rows that would take longer are left out
const longest = 5; // floor contacts: times shown
const low = ranges.restitution.low;

// Rows are computed in workers, coarse first. Where the contacts change between two rows, more rows are inserted
// to resolve the tips.
export class Timeline {
  private rows: TimelineRow[] = []; // by ε
  private adiabatic: TimelineRow[] = [];
  private queue: number[] = []; // ε
  private sent = 0; // batches in progress
  private asked = 0;
  private answered = 0;
  private perRow = 0; // ms, measured as it goes
  private job = 0;
  private column: Float64Array = new Float64Array();
  private exact = false; // there is an adiabatic solution

  constructor(
    pool: Pool,
    private readonly changed: () => void,
    shown: () => boolean,
  ) {
    pool.add(() => this.nextBatch(), shown);
    this.wake = () => pool.wake();
  }
  private readonly wake: () => void;

  start(scenario: Scenario): void {
    this.job++;
    this.rows = [];
    this.adiabatic = [];
    this.sent = this.perRow = this.answered = 0;
    this.column = columnOf(scenario);
    this.exact = scenario.law === "linear" && scenario.balls.length === 2 && !scenario.cradle;
    const places = new Set<number>();
    for (let stride = 16; stride >= 1; stride /= 2) for (let i = 0; i < even; i += stride) places.add(i);
    this.queue = [...places].map((i) => low + ((1 - low) * i) / (even - 1));
    this.asked = this.queue.length;
    this.wake();
  }

  get done(): boolean {
    return this.queue.length === 0 && this.sent === 0;
  }
  get progress(): number {
    return this.answered / Math.max(this.asked, 1);
  }

  private nextBatch(): Piece | null {
    if (this.queue.length === 0) return null;
    const room = this.perRow > 0 ? Math.max(1, Math.min(64, Math.floor(14 / this.perRow))) : 1;
    const restitution = this.queue.splice(0, room);
    const { job } = this;
    this.sent++;
    const ask = { column: this.column, restitution, adiabatic: this.exact };
    return piece<"timeline">({ kind: "timeline", ask, done: (rows, ms) => job === this.job && this.receive(rows, ms) });
  }

  private receive(rows: { newton: TimelineRow[]; adiabatic: TimelineRow[] }, ms: number): void {
    this.sent--;
    this.answered += rows.newton.length;
    this.perRow = 0.5 * (this.perRow || ms) + (0.5 * ms) / rows.newton.length;
    const merge = (old: TimelineRow[], more: TimelineRow[]): TimelineRow[] => [...old, ...more].sort((a, b) => a.restitution - b.restitution);
    this.rows = merge(this.rows, rows.newton);
    this.adiabatic = merge(this.adiabatic, rows.adiabatic);
    if (this.done) this.refine();
    this.changed();
  }

  // Bisects the intervals in which the contacts change or their times are not linear.
  private refine(): void {
    const { rows } = this;
    const apart = (1 - low) / (even - 1);
    const seen = this.span();
    for (let i = 1; i < rows.length; i++) {
      const [a, b] = [rows[i - 1], rows[i]];
      const distance = b.restitution - a.restitution;
      const changed = !alike(a, b) || (this.exact && !alike(this.adiabatic[i - 1], this.adiabatic[i]));
      const bent = distance > finestBend * apart && bends(rows[i - 2], a, b, rows[i + 1], seen);
      if (distance > finest * apart && (changed || bent)) this.queue.push(0.5 * (a.restitution + b.restitution));
    }
    if (rows.length + this.queue.length > most || this.queue.length * this.perRow > patience) this.queue = [];
    this.asked += this.queue.length;
  }

  // Range of times: the whole floor contact and, for nearly all rows, the last contact between balls. If that is so late that it
  // would compress the floor contact to a strip, the first contact between balls.
  private span(): number {
    const floor = this.rows.reduce((most, { tFloorEnd }) => (tFloorEnd < Infinity ? Math.max(most, tFloorEnd) : most), 0);
    const last = mostOf(this.rows.map((row) => row.tEnd));
    const first = mostOf(this.rows.map((row) => row.contacts.find((c) => c.pair > 0)?.end ?? 0));
    const room = floor > 0 ? Math.max(longest * floor, 1.3 * first) : Infinity;
    return Math.max(1.2 * floor, Math.min(1.15 * last, room), 1e-9);
  }

  // Whether balls touch again after the times shown.
  get goesOn(): boolean {
    const seen = this.span();
    return this.rows.some((row) => Number.isFinite(row.tEnd) && row.tEnd > seen);
  }

  draw(g: CanvasRenderingContext2D, w: number, h: number, d: Drop, theme: Theme): TimelineLayout {
    g.clearRect(0, 0, w, h);
    const size = fontSize(w);
    const f: Frame = { left: 3.2 * size, top: 2.2 * size, width: w - 3.2 * size - 1.4 * size, height: h - 5.4 * size };
    const begin = d.scenario.cradle ? d.from - 0.02 * (d.to - d.from) : Math.min(0, d.from);
    const span = this.span();
    const x = new Scale(begin, d.scenario.cradle ? Math.max(d.from + 1.15 * (span / 1.15 - d.from), begin + 1.1 * (d.to - begin)) : span, f.left, f.left + f.width);
    const y = new Scale(0, 1, f.top + f.height, f.top);
    g.save();
    g.beginPath();
    g.rect(f.left, f.top, f.width, f.height);
    g.clip();
    this.drawBands(g, x, y, d.scenario.balls.length > 2, theme);
    this.drawAdiabatic(g, x, y, theme);
    this.drawFloorEnd(g, x, y, theme, grown(size));
    g.restore();
    const [factor, unit] = timeUnit(x.high - x.low);
    drawAxes(
      g, f, x, y,
      {
        ...timeTicks(x, d.origin, factor, f.width / (5.5 * size)),
        title: `time (${unit})`,
      },
      { ticks: [0, 0.2, 0.4, 0.6, 0.8, 1], name: (v) => v.toFixed(1), title: "ε" },
      theme, size, false,
    );
    this.drawChosen(g, x, y, f, d, theme, size);
    return { x, y, frame: f };
  }

  // The regions in which two bodies touch. A region continues between rows with the same contacts; where they change,
  // it ends.
  private drawBands(g: CanvasRenderingContext2D, x: Scale, y: Scale, several: boolean, theme: Theme): void {
    // A contact that never ends extends to the edge of the plot.
    const end = (c: Contact): number => x.at(Number.isFinite(c.end) ? c.end : Math.max(c.begin, x.high));
    for (const group of runsOf(this.rows)) {
      const last = group.length - 1;
      const heights = group.map((row) => y.at(row.restitution));
      const [bottom, top] = [y.at(this.border(group[0], -1)), y.at(this.border(group[last], 1))];
      group[0].contacts.forEach(({ pair }, k) => {
        const left = group.map((row, i): [number, number] => [x.at(row.contacts[k].begin), heights[i]]);
        const right = group.map((row, i): [number, number] => [end(row.contacts[k]), heights[i]]);
        const over = several && pair > 0 ? 0 : 0.5; // pixels into the next region, or a hairline shows between them
        for (const edge of [left, right]) edge.unshift([edge[0][0], bottom + over]), edge.push([edge[last + 1][0], top - over]);
        g.fillStyle = g.strokeStyle = pair === 0 ? theme.faint : theme.pairs[pair];
        g.globalAlpha = several && pair > 0 ? 0.16 : 1;
        trace(g, [...left, ...right.reverse()]);
        g.fill();
        g.globalAlpha = 1;
        g.lineWidth = pair === 0 ? 0.5 : several ? 2.5 : 1; // bands of several pairs overlap: their edges tell them apart
        for (const edge of [left, right]) trace(g, edge), g.stroke();
      });
    }
  }

  // Half way to the next row above (1) or below (−1): there the region of a row ends.
  private border(row: TimelineRow, side: 1 | -1): number {
    const next = this.rows[this.rows.indexOf(row) + side];
    return next ? 0.5 * (row.restitution + next.restitution) : row.restitution;
  }

  // Edges of the adiabatic contacts over the bands: where they coincide the reaction on the lower ball does not matter.
  private drawAdiabatic(g: CanvasRenderingContext2D, x: Scale, y: Scale, theme: Theme): void {
    g.fillStyle = theme.ink;
    for (const group of runsOf(this.adiabatic))
      group[0].contacts.forEach(({ pair }, k) => {
        if (pair === 0) return;
        for (const edge of ["begin", "end"] as const)
          dots(g, group.filter((row) => Number.isFinite(row.contacts[k][edge])).map((row) => [x.at(row.contacts[k][edge]), y.at(row.restitution)]));
      });
  }

  private drawFloorEnd(g: CanvasRenderingContext2D, x: Scale, y: Scale, theme: Theme, thick: number): void {
    g.strokeStyle = theme.ink;
    g.lineWidth = 2 * thick;
    g.setLineDash([7 * thick, 5 * thick]);
    g.beginPath();
    let open = false;
    for (const { restitution, tFloorEnd } of this.rows) {
      if (Number.isFinite(tFloorEnd)) g[open ? "lineTo" : "moveTo"](x.at(tFloorEnd), y.at(restitution));
      open = Number.isFinite(tFloorEnd);
    }
    g.stroke();
    g.setLineDash([]);
  }

  private drawChosen(g: CanvasRenderingContext2D, x: Scale, y: Scale, f: Frame, d: Drop, theme: Theme, size: number): void {
    const at = y.at(d.scenario.restitution);
    g.strokeStyle = theme.ink;
    g.lineWidth = 3 * grown(size);
    stroke(g, f.left, at, f.left + f.width, at);
    setFont(g, theme, size, 700);
    const text = `ε = ${Number(d.scenario.restitution.toPrecision(4))}`;
    const width = g.measureText(text).width;
    g.fillStyle = theme.ink;
    g.textAlign = "right";
    g.textBaseline = "middle";
    const above = at - f.top > 2 * size;
    const middle = above ? at - 0.9 * size : at + 0.95 * size;
    g.fillStyle = theme.ground;
    g.globalAlpha = 0.85;
    g.fillRect(f.left + f.width - width - 14, middle - 0.7 * size, width + 10, 1.4 * size);
    g.globalAlpha = 1;
    g.fillStyle = theme.ink;
    g.fillText(text, f.left + f.width - 9, middle);
    if (d.scenario.balls.length !== 2) {
      this.drawNames(g, f, d.scenario.balls.length, theme, size);
      return;
    }
    g.textAlign = "center";
    let right = -Infinity;
    d.newton.run.contacts
      .filter((c) => c.pair === 1 && c.begin <= d.newton.run.last)
      .forEach((c, i) => {
        const end = Number.isFinite(c.end) ? c.end : Math.max(c.begin, x.high);
        const center = Math.min(x.at((c.begin + end) / 2), x.at(c.begin) + 1.2 * size); // beside the line of the film, which rests in the middle
        const name = String(i + 1);
        const half = g.measureText(name).width / 2 + 3;
        if (center - half < right || center > f.left + f.width - width - 20) return;
        right = center + half;
        g.globalAlpha = 0.85;
        g.fillStyle = theme.ground;
        g.fillRect(center - half, middle - 0.65 * size, 2 * half, 1.3 * size);
        g.globalAlpha = 1;
        g.fillStyle = theme.ink;
        g.fillText(name, center, middle);
      });
  }

  private drawNames(g: CanvasRenderingContext2D, f: Frame, balls: number, theme: Theme, size: number): void {
    setFont(g, theme, size, 700);
    g.textAlign = "right";
    g.textBaseline = "bottom";
    let at = f.left + f.width;
    for (let j = balls - 1; j >= 1; j--) {
      const name = `${j}–${j + 1}`;
      g.fillStyle = theme.pairs[j];
      g.fillText(name, at, f.top - 4);
      at -= g.measureText(name).width + 0.9 * size;
    }
    g.fillStyle = theme.muted;
    g.fillText("balls", at, f.top - 4);
  }
}

// The 90th percentile over the rows; infinite values are ignored.
function mostOf(times: number[]): number {
  const sorted = times.map((t) => (Number.isFinite(t) ? t : 0)).sort((a, b) => a - b);
  return sorted[Math.floor(0.9 * (sorted.length - 1))] ?? 0;
}

// Whether two rows have the same contacts, in the same order.
const alike = (a: TimelineRow, b: TimelineRow): boolean =>
  a.contacts.length === b.contacts.length && a.contacts.every((c, k) => c.pair === b.contacts[k].pair && Number.isFinite(c.end) === Number.isFinite(b.contacts[k].end));

// Whether a line between the rows a and b would miss what is shown of the times between them, judged by the curvature
// that a third row on either side shows. A curve with the second difference quotient q strays q h²/4 from its chord over h.
function bends(before: TimelineRow | undefined, a: TimelineRow, b: TimelineRow, after: TimelineRow | undefined, shown: number): boolean {
  if (!alike(a, b)) return false;
  const h = b.restitution - a.restitution;
  return [before, after].some((third) => {
    if (!third || !alike(a, third)) return false;
    return a.contacts.some((contact, k) => {
      const last = b.contacts[k];
      if (Math.min(contact.begin, last.begin) > shown) return false;
      return (["begin", "end"] as const).some((edge) => {
        const slope = (last[edge] - contact[edge]) / h;
        const other = (third.contacts[k][edge] - contact[edge]) / (third.restitution - a.restitution);
        return Math.abs((other - slope) / (third.restitution - b.restitution)) * h * h > 4 * straight * shown;
      });
    });
  });
}

function trace(g: CanvasRenderingContext2D, places: [number, number][]): void {
  g.beginPath();
  for (const place of places) g.lineTo(...place);
}

// A dotted line; a dashed stroke of so many short pieces takes a hundred times as long.
function dots(g: CanvasRenderingContext2D, places: [number, number][]): void {
  const apart = 4;
  let next = 0; // pixels to the next dot
  for (let i = 1; i < places.length; i++) {
    const [[x0, y0], [x1, y1]] = [places[i - 1], places[i]];
    const length = Math.min(Math.hypot(x1 - x0, y1 - y0), 2000);
    for (; next <= length; next += apart) {
      const u = length > 0 ? next / length : 0;
      g.fillRect(x0 + u * (x1 - x0) - 0.7, y0 + u * (y1 - y0) - 0.7, 1.4, 1.4);
    }
    next -= length;
  }
}

// Stretches of rows with the same contacts.
function runsOf(rows: TimelineRow[]): TimelineRow[][] {
  const runs: TimelineRow[][] = [];
  rows.forEach((row, i) => {
    if (i > 0 && alike(rows[i - 1], row)) runs[runs.length - 1].push(row);
    else runs.push([row]);
  });
  return runs;
}

export interface TimelineLayout {
  x: Scale;
  y: Scale;
  frame: Frame;
}
