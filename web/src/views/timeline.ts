// Contact times for every ε (Fig. 3): each band is a contact.
import type { TimelineRow } from "../core/core";
import type { Drop } from "../core/drop";
import { piece, type Piece, type Pool } from "../core/pool";
import { columnOf, ranges, type Scenario } from "../scenario/scenario";
import { observed } from "../state/signals";
import type { Theme } from "../style/theme";
import { alike, drawTimeline, type TimelineLayout } from "./timeline_drawing";

const even = 241; // number of equidistant rows that are computed first
const finest = 1 / 4096; // smallest distance of rows where the contacts change, relative to the equidistant rows
const finestBend = 1 / 40; // the same where the times of contacts are not linear in ε
const straight = 1 / 1500; // largest error of linear interpolation, relative to the times shown
const most = 1500; // number of rows
const patience = 4_000; // ms: rows that would take longer are left out
const longest = 5; // largest time shown, in durations of the floor contact
const low = ranges.restitution.low;

// Rows are computed in workers, coarse first. Where the contacts change between two rows, more rows are inserted
// to resolve the tips.
export class Timeline {
  private rows: TimelineRow[] = []; // by ε
  private adiabatic: TimelineRow[] = [];
  private queue: number[] = []; // ε
  private sent = 0; // batches that workers compute
  private requested = 0;
  private answered = 0;
  private perRow = 0; // mean time of a row [ms]; 0: not measured yet
  private job = 0;
  private column: Float64Array = new Float64Array();
  private exact = false; // the adiabatic solution exists

  constructor(pool: Pool, shown: () => boolean) {
    observed(this, ["rows"]);
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
    this.requested = this.queue.length;
    this.wake();
  }

  get done(): boolean {
    return this.queue.length === 0 && this.sent === 0;
  }
  get progress(): number {
    return this.answered / Math.max(this.requested, 1);
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
    const merge = (old: TimelineRow[], more: TimelineRow[]): TimelineRow[] =>
      [...old, ...more].sort((a, b) => a.restitution - b.restitution);
    this.rows = merge(this.rows, rows.newton);
    this.adiabatic = merge(this.adiabatic, rows.adiabatic);
    if (this.done) this.refine();
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
    this.requested += this.queue.length;
  }

  // Last time shown. It includes the whole floor contact and, for nearly all rows, the last contact between balls; only
  // the first contact between balls if the last one is so late that the floor contact would become a narrow strip.
  private span(): number {
    const floor = this.rows.reduce(
      (most, { tFloorEnd }) => (tFloorEnd < Infinity ? Math.max(most, tFloorEnd) : most),
      0,
    );
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
    return drawTimeline(g, w, h, { rows: this.rows, adiabatic: this.adiabatic, span: this.span() }, d, theme);
  }
}

// The 90th percentile over the rows; infinite values are ignored.
function mostOf(times: number[]): number {
  const sorted = times.map((t) => (Number.isFinite(t) ? t : 0)).sort((a, b) => a - b);
  return sorted[Math.floor(0.9 * (sorted.length - 1))] ?? 0;
}

// Whether linear interpolation between the rows a and b has a visible error. The curvature is estimated with a third
// row on either side: a curve with the second difference quotient q deviates by q h²/4 from its chord over h.
function bends(
  before: TimelineRow | undefined,
  a: TimelineRow,
  b: TimelineRow,
  after: TimelineRow | undefined,
  shown: number,
): boolean {
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
