// Rebound height of the top ball by both models over the gap, ε or R1/R2. Few points are computed first, then more
// where the curve bends or jumps. On a cradle the velocity of the last ball takes the place of the height.
import type { CurveAxis } from "../scenario/story_view";
import type { Solved } from "../core/drop";
import { piece, type Piece, type Pool } from "../core/pool";
import { columnOf, copyOf, firstGap, lowestHeight, ranges, type Scenario } from "../scenario/scenario";
import { observed } from "../state/signals";
import { wholeMap } from "../scenario/view";

export interface CurvePoint {
  x: number;
  newton: number; // m, or m/s on a cradle; NaN: there is none
  icm: number;
}

export interface Span {
  low: number;
  high: number;
  log: boolean;
}

// The range of the map, extended down to where the gap no longer matters.
export function spanOf(s: Scenario, axis: CurveAxis, floorContact: number, speed: number): Span {
  if (axis === "e") return { low: ranges.restitution.low, high: 1, log: false };
  const { y } = wholeMap(s, axis, floorContact, speed);
  return { low: y[0], high: axis === "gap" ? Math.min(2 * y[1], ranges.gap.high) : y[1], log: true };
}

// Duration of the floor contact and impact speed of a drop, from which plots take their range.
export function scaleOf({ scenario: { cradle, velocities }, newton: { run }, from, to }: Solved): [number, number] {
  const floor = Number.isFinite(run.tFloorEnd) ? run.tFloorEnd : to - from;
  return [floor, cradle ? Math.max(...velocities.map(Math.abs)) : run.impactSpeed];
}

export function valueOn(s: Scenario, axis: CurveAxis): number {
  if (axis === "e") return s.restitution;
  return axis === "gap" ? s.gaps[firstGap(s)] : s.balls[0].radius / s.balls[1].radius;
}

// The scenario moved to x; null where the lowest ball would not start above the floor.
export function movedTo(s: Scenario, axis: CurveAxis, x: number): Scenario | null {
  const at = copyOf(s);
  if (axis === "e") at.restitution = x;
  else if (axis === "gap") at.gaps = at.gaps.map((gap, i) => (i < firstGap(s) ? gap : x));
  else at.balls[0].radius = x * at.balls[1].radius;
  return !s.cradle && at.height < lowestHeight(at) ? null : at;
}

const coarse = 24; // intervals of the first pass
const finest = 2 ** -4; // smallest interval, relative to the first ones
const mostPoints = 700;
const batchTime = 30; // ms: longest time of one batch

export class Curve {
  points: CurvePoint[] = [];
  touching: CurvePoint | null = null; // at gap 0, which a logarithmic axis does not have
  done = true;
  span: Span = { low: 0, high: 1, log: false };
  axis: CurveAxis = "gap";
  private scenario: Scenario | null = null;
  private queue: number[] = [];
  private sent = 0; // batches of this job that workers compute
  private job = 0;
  private perPoint = 0; // mean time of a point [ms]; 0: not measured yet

  constructor(
    private readonly pool: Pool,
    shown: () => boolean,
  ) {
    observed(this, ["points", "touching", "done"]);
    pool.add(() => this.nextBatch(), shown);
  }

  start(scenario: Scenario, axis: CurveAxis, span: Span): void {
    this.stop();
    this.scenario = copyOf(scenario);
    this.axis = axis;
    this.span = span;
    this.done = false;
    this.queue = Array.from({ length: coarse + 1 }, (_, i) => this.at(i / coarse));
    if (axis === "gap") this.queue.unshift(0);
    this.pool.wake();
  }

  // Results in progress are discarded.
  stop(): void {
    this.job++;
    this.points = [];
    this.touching = null;
    this.queue = [];
    this.sent = this.perPoint = 0;
    this.done = true;
  }

  // Converts a fraction of the axis to a value; shareOf is the inverse.
  private at(share: number): number {
    const { low, high, log } = this.span;
    return log ? low * (high / low) ** share : low + (high - low) * share;
  }
  private shareOf(x: number): number {
    const { low, high, log } = this.span;
    return log ? Math.log(x / low) / Math.log(high / low) : (x - low) / (high - low);
  }

  private nextBatch(): Piece | null {
    const { scenario, job } = this;
    if (!scenario || this.queue.length === 0) return null;
    const room = this.perPoint > 0 ? Math.max(1, Math.min(64, batchTime / this.perPoint)) : 4;
    const places: number[] = [];
    const columns: Float64Array[] = [];
    while (this.queue.length > 0 && columns.length < room) {
      const x = this.queue.shift()!;
      const moved = movedTo(scenario, this.axis, x);
      if (!moved) continue;
      places.push(x);
      columns.push(columnOf(moved));
    }
    if (columns.length === 0) {
      this.goOn();
      return null;
    }
    this.sent++;
    return piece<"curve">({
      kind: "curve",
      ask: { columns },
      done: (values, ms) => this.receive(job, places, values, ms),
    });
  }

  private receive(job: number, places: number[], values: Float64Array, ms: number): void {
    if (job !== this.job) return;
    this.sent--;
    const each = Math.max(ms / places.length, 1e-3);
    this.perPoint = this.perPoint > 0 ? 0.5 * (this.perPoint + each) : each;
    const points = places.map((x, k) => ({ x, newton: values[2 * k], icm: values[2 * k + 1] }));
    const touching = (p: CurvePoint): boolean => p.x === 0 && this.axis === "gap";
    this.touching = points.find(touching) ?? this.touching;
    this.points = [...this.points, ...points.filter((p) => !touching(p))].sort((a, b) => a.x - b.x);
    this.goOn();
  }

  private goOn(): void {
    if (this.queue.length > 0 || this.sent > 0) return;
    this.queue = this.refined();
    this.done = this.queue.length === 0;
  }

  // Midpoints of the intervals in which a straight line would be visibly wrong.
  private refined(): number[] {
    const { points } = this;
    if (points.length >= mostPoints) return [];
    const heights = points.flatMap((p) => [p.newton, p.icm]).filter(Number.isFinite);
    const whole = Math.max(...heights) - Math.min(...heights, 0);
    const next: number[] = [];
    for (let i = 1; i < points.length; i++) {
      const [a, b] = [points[i - 1], points[i]];
      const width = (this.shareOf(b.x) - this.shareOf(a.x)) * coarse;
      if (width <= finest * 1.001) continue;
      if (width > 0.26 || bends(a, b, 0.004 * whole)) next.push(this.at(this.shareOf(a.x) + (0.5 * width) / coarse));
    }
    return next;
  }
}

// Whether a curve changes by more than `least` between two points, or exists at only one of them.
function bends(a: CurvePoint, b: CurvePoint, least: number): boolean {
  return (["newton", "icm"] as const).some(
    (key) => Number.isFinite(a[key]) !== Number.isFinite(b[key]) || Math.abs(a[key] - b[key]) > least,
  );
}
