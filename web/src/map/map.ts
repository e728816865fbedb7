// The map of contact counts or of ε_eff/ε over ε and the gap or R1/R2 (Figs. 4–6), computed in workers, coarse first.
import { MAP_VALUES } from "../core/core";
import { piece, type Piece, type Pool } from "../core/pool";
import { Scale } from "../support/plot";
import { columnOf, type Scenario } from "../scenario/scenario";
import { observed } from "../state/signals";
import type { Theme } from "../style/theme";
import type { Box, MapAxis, MapShow } from "../scenario/view";
import { drawMap, type Layer, type MapLayout } from "./map_drawing";
import { Raster, SIDE, type CountLabel } from "./map_raster";
import type { Agreement } from "./trust";

const strides = [16, 8, 4, 2, 1];
const patience = 8_000; // a finer level that would take longer is omitted [ms]
const batchTime = 14; // ms: longest time of one batch

interface Batch {
  job: number;
  stride: number;
  at: number[]; // indices i + SIDE j of the points
}

export class ContactMap {
  box: Box;
  private readonly raster = new Raster();
  private before: Layer | null = null; // previous picture, until there is a new one
  private queue: { stride: number; column: number; from: number }[] = []; // remaining points of a column
  private sent = 0; // batches of this job that workers compute
  private column: Float64Array = new Float64Array();
  private axis: MapAxis = "gap";
  private job = 0;
  private began = NaN; // when the first points were requested
  private perPoint = 0; // mean time of a point [ms]; 0: not measured yet
  private next = 0; // stride of the level that is being sent
  private labels: CountLabel[] = [];
  elapsed: number | null = null; // ms for the whole map
  computing = 0; // ms of all workers together
  private computed = 0; // points
  resolution = 0; // complete points in each direction
  received = 0; // counts batches

  constructor(
    private readonly pool: Pool,
    shown: () => boolean,
  ) {
    observed(this, ["received"]);
    this.box = { x: [0.05, 1], y: [1e-6, 1e-2] };
    pool.add(() => this.nextBatch(), shown);
  }

  // `keep`: the previous picture shows a part of the same map and is kept until it is overwritten.
  start(scenario: Scenario, axis: MapAxis, box: Box, keep: boolean): void {
    this.job++;
    this.before = keep ? { sheet: this.raster.copy(), box: this.box } : null;
    this.raster.clear();
    this.box = box;
    this.labels = [];
    this.queue = [];
    this.elapsed = null;
    this.next = strides[0];
    this.resolution = this.sent = this.perPoint = 0;
    this.computing = this.computed = 0;
    this.began = NaN;
    for (const stride of strides)
      for (let column = 0; column < SIDE; column += stride) this.queue.push({ stride, column, from: 0 });
    this.column = columnOf(scenario);
    this.axis = axis;
    this.received++;
    this.pool.wake();
  }

  // Fraction of the map that is computed.
  get progress(): number {
    return this.elapsed !== null ? 1 : this.computed / (SIDE * SIDE);
  }

  // A batch for one worker: points of one level, for at most batchTime.
  private nextBatch(): Piece | null {
    const room = this.perPoint > 0 ? Math.max(1, Math.min(2500, batchTime / this.perPoint)) : 25;
    const at: number[] = [];
    const stride = this.queue[0]?.stride ?? 0;
    while (this.queue[0]?.stride === stride && at.length < room) {
      const next = this.queue[0];
      const coarse = stride < strides[0] && next.column % (2 * stride) === 0;
      const step = coarse ? 2 * stride : stride;
      let j = next.from || (coarse ? stride : 0);
      for (; j < SIDE && at.length < room; j += step) at.push(next.column + SIDE * j);
      if (j < SIDE) next.from = j;
      else this.queue.shift();
    }
    if (Number.isNaN(this.began)) this.began = performance.now();
    if (at.length === 0) return null;
    const x = this.scaleX(0, SIDE);
    const y = this.scaleY(0, SIDE);
    const points = new Float64Array(2 * at.length);
    at.forEach((place, k) => {
      points[2 * k] = x.value((place % SIDE) + 0.5);
      points[2 * k + 1] = y.value(Math.floor(place / SIDE) + 0.5);
    });
    const batch: Batch = { job: this.job, stride, at };
    this.sent++;
    const ask = { column: this.column, axis: this.axis === "gap" ? 0 : 1, points };
    return piece<"points">({ kind: "points", ask, done: (values, ms) => this.receive(batch, values, ms) });
  }

  private receive(batch: Batch, values: Float64Array, ms: number): void {
    if (batch.job !== this.job) return;
    const n = batch.at.length;
    this.sent--;
    this.computing += ms;
    this.computed += n;
    const perPoint = Math.max(ms / n, 1e-4);
    this.perPoint = this.perPoint > 0 ? 0.5 * (this.perPoint + perPoint) : perPoint;
    batch.at.forEach((place, k) =>
      this.raster.take(place, batch.stride, values.subarray(MAP_VALUES * k, MAP_VALUES * (k + 1))),
    );
    const level = this.levelDone();
    const over = this.queue.length === 0 && this.sent === 0;
    if (over) this.elapsed = performance.now() - this.began;
    if ((over || level) && batch.stride <= 4) this.labels = this.raster.labels();
    this.received++;
  }

  // Whether a level has just been completed; the next level is skipped if it would take too long.
  private levelDone(): boolean {
    const next = this.queue[0]?.stride ?? 0;
    if (next >= this.next) return false;
    this.resolution = Math.floor(SIDE / this.next);
    this.next = next;
    const points = (SIDE / Math.max(next, 1)) ** 2 * 0.75;
    if ((points * this.computing) / this.computed / this.pool.size <= patience) return true;
    this.queue = [];
    this.next = 0;
    return true;
  }

  private scaleX(from: number, to: number): Scale {
    return new Scale(this.box.x[0], this.box.x[1], from, to);
  }
  private scaleY(from: number, to: number): Scale {
    return new Scale(this.box.y[0], this.box.y[1], from, to, true);
  }

  shows(restitution: number, y: number): boolean {
    const { x, y: v } = this.box;
    return restitution >= x[0] && restitution <= x[1] && y >= v[0] && y <= v[1];
  }

  setShow(show: MapShow): void {
    this.raster.setShow(show);
  }

  draw(
    g: CanvasRenderingContext2D,
    w: number,
    h: number,
    axis: MapAxis,
    mark: [number, number],
    theme: Theme,
    agreement: Agreement | null,
    view: Box = this.box,
  ): MapLayout {
    void this.received;
    if (this.elapsed !== null) this.before = null;
    const { show, greatest } = this.raster;
    const layers = [...(this.before ? [this.before] : []), { sheet: this.raster.picture(), box: this.box }];
    return drawMap(g, w, h, { layers, view, axis, show, labels: this.labels, greatest, mark, agreement }, theme);
  }
}
