// The map of contact counts, of ε_eff/ε or of verdicts over two axes (Figs. 4–6), computed in workers, coarse first.
import { MAP_VALUES, type MapTask } from "../core/map_points";
import { piece, type Piece, type Pool } from "../core/pool";
import { Scale } from "../support/plot";
import { axes } from "../scenario/axes";
import { copyOf, type Scenario } from "../scenario/scenario";
import { observed } from "../state/signals";
import type { Theme } from "../style/theme";
import type { Limits } from "../scenario/axes";
import type { Box, MapAxis, MapShow, MapView } from "../scenario/view";
import { drawMap, mapInWords, type Layer, type MapLayout } from "./map_drawing";
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
  private task: Omit<MapTask, "points"> | null = null;
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
  // `tolerance`: of the verdict; null: the verdict is not computed.
  start(scenario: Scenario, axes: [x: MapAxis, y: MapAxis], tolerance: number | null, box: Box, keep: boolean): void {
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
    this.task = { scenario: copyOf(scenario), axes, tolerance };
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
    const points = Float64Array.from(at.flatMap((place) => this.pointOf(place)));
    const batch: Batch = { job: this.job, stride, at };
    this.sent++;
    const ask = { ...this.task!, points };
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
    if ((over || level) && (batch.stride <= 4 || over)) this.labels = this.raster.labels();
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

  private pointOf(place: number): [number, number] {
    const { box, task } = this;
    const value = ([low, high]: Limits, axis: MapAxis, i: number): number =>
      new Scale(low, high, 0, SIDE, axes[axis].log).value(i + 0.5);
    return [value(box.x, task!.axes[0], place % SIDE), value(box.y, task!.axes[1], Math.floor(place / SIDE))];
  }

  shows(across: number, up: number): boolean {
    const { x, y } = this.box;
    return across >= x[0] && across <= x[1] && up >= y[0] && up <= y[1];
  }

  // The computed points with their values, in rows for a CSV file.
  rows(): number[][] {
    return this.raster.computed().map(({ place, values }) => [...this.pointOf(place), ...values]);
  }

  inWords(show: MapShow, agreement: Agreement | null): string {
    return mapInWords(show, this.raster.greatest, agreement);
  }

  setShow(show: MapShow): void {
    this.raster.setShow(show);
    this.labels = this.elapsed === null ? [] : this.raster.labels();
  }

  draw(
    g: CanvasRenderingContext2D,
    w: number,
    h: number,
    scenario: Scenario,
    map: MapView,
    mark: [number, number],
    theme: Theme,
    agreement: Agreement | null,
    view: Box = this.box,
  ): MapLayout {
    void this.received;
    if (this.elapsed !== null) this.before = null;
    const { greatest, highest, kinds } = this.raster;
    const layers = [...(this.before ? [this.before] : []), { sheet: this.raster.picture(), box: this.box }];
    const { labels } = this;
    return drawMap(g, w, h, { layers, view, scenario, map, labels, greatest, highest, kinds, mark, agreement }, theme);
  }
}
