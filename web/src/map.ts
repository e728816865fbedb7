// The map of contact counts or of ε_eff/ε over ε and the gap or R1/R2 (Figs. 4–6), computed in workers, coarse first.
import { MAP_VALUES } from "./core";
import { logTicks, niceTicks, withUnit } from "./format";
import { drawAxes, fontSize, Scale, setFont, stroke, type Frame } from "./plot";
import { columnOf, type Scenario } from "./scenario";
import { countColor, css, inkOn, invalidColor, MOST_COUNTED, ratioColor, type Rgb, type Theme } from "./theme";
import type { Box, MapAxis, MapShow } from "./view";
import type { WorkerBatch, WorkerColumn, WorkerResult, WorkerStart } from "./worker";

export const SIDE = 400; // points each way
const strides = [16, 8, 4, 2, 1];
const patience = 8_000; // ms: a finer level that would take longer is left out
const batchTime = 14; // ms: how long a worker may be out of reach

interface Batch {
  job: number;
  stride: number;
  at: Int32Array; // places i + SIDE j of the points
}

export interface Reading {
  restitution: number;
  y: number;
  count: number;
  effective: number;
  separation: number;
}

export class ContactMap {
  box: Box;
  private readonly workers: Worker[] = [];
  private readonly idle: Worker[] = [];
  private readonly values = new Float32Array(SIDE * SIDE * MAP_VALUES);
  private readonly filled = new Uint8Array(SIDE * SIDE); // stride of the block that fills this place, 0: none yet
  private readonly image: ImageData;
  private readonly sheet: HTMLCanvasElement;
  private queue: { stride: number; column: number }[] = [];
  private readonly sent = new Map<number, Batch>();
  private job = 0;
  private batches = 0;
  private began = 0;
  private perPoint = 0.012; // ms, measured as it goes
  private next = 0; // stride of the level that is being sent
  private show: MapShow = "count";
  private labels: { x: number; y: number; n: number }[] = [];
  elapsed: number | null = null; // ms for the whole map
  computing = 0; // ms of all workers together
  private computed = 0; // points
  resolution = 0; // points each way that are complete
  greatest = 0; // count in view
  fresh = false; // begun anew: draw at once

  constructor(
    module: WebAssembly.Module,
    workerUrl: string,
    private readonly changed: () => void,
  ) {
    this.box = { x: [0.05, 1], y: [1e-6, 1e-2] };
    this.sheet = document.createElement("canvas");
    this.sheet.width = this.sheet.height = SIDE;
    this.image = new ImageData(SIDE, SIDE);
    const n = Math.min(Math.max(navigator.hardwareConcurrency || 2, 1), 8);
    for (let i = 0; i < n; i++) {
      const worker = new Worker(workerUrl, { type: "module" });
      const start: WorkerStart = { kind: "start", module };
      worker.postMessage(start);
      worker.onmessage = (event: MessageEvent<WorkerResult>) => this.receive(worker, event.data);
      this.workers.push(worker);
      this.idle.push(worker);
    }
  }

  start(scenario: Scenario, axis: MapAxis, box: Box): void {
    this.job++;
    this.box = box;
    this.filled.fill(0);
    this.values.fill(NaN);
    this.labels = [];
    this.queue = [];
    this.elapsed = null;
    this.greatest = 0;
    this.fresh = true;
    this.next = strides[0];
    this.resolution = 0;
    this.computing = this.computed = 0;
    this.began = performance.now();
    for (const stride of strides) for (let column = 0; column < SIDE; column += stride) this.queue.push({ stride, column });
    const column: WorkerColumn = { kind: "column", job: this.job, column: columnOf(scenario), axis: axis === "gap" ? 0 : 1 };
    for (const worker of this.workers) worker.postMessage(column);
    for (const worker of this.idle.splice(0)) this.feed(worker);
  }

  private feed(worker: Worker): void {
    const room = Math.max(24, Math.min(2500, batchTime / this.perPoint));
    const at: number[] = [];
    let stride = 0;
    while (this.queue.length > 0 && at.length < room) {
      const next = this.queue[0];
      if (stride !== 0 && next.stride !== stride) break;
      stride = next.stride;
      this.queue.shift();
      const coarse = stride < strides[0] && next.column % (2 * stride) === 0;
      for (let j = coarse ? stride : 0; j < SIDE; j += coarse ? 2 * stride : stride) at.push(next.column + SIDE * j);
    }
    if (at.length === 0) {
      this.idle.push(worker);
      return;
    }
    const x = this.scaleX(0, SIDE);
    const y = this.scaleY(0, SIDE);
    const points = new Float64Array(2 * at.length);
    at.forEach((place, k) => {
      points[2 * k] = x.value((place % SIDE) + 0.5);
      points[2 * k + 1] = y.value(Math.floor(place / SIDE) + 0.5);
    });
    const batch = ++this.batches;
    this.sent.set(batch, { job: this.job, stride, at: Int32Array.from(at) });
    const message: WorkerBatch = { kind: "batch", job: this.job, batch, points };
    worker.postMessage(message, [points.buffer]);
  }

  private receive(worker: Worker, result: WorkerResult): void {
    const batch = this.sent.get(result.batch);
    this.sent.delete(result.batch);
    if (batch && result.job === this.job) {
      const n = batch.at.length;
      this.computing += result.ms;
      this.computed += n;
      this.perPoint = 0.5 * this.perPoint + 0.5 * Math.max(result.ms / n, 1e-4);
      for (let k = 0; k < n; k++) {
        const place = batch.at[k];
        for (let v = 0; v < MAP_VALUES; v++) this.values[MAP_VALUES * place + v] = result.values[MAP_VALUES * k + v];
        this.greatest = Math.max(this.greatest, result.values[MAP_VALUES * k] || 0);
        this.fill(place, batch.stride);
      }
      let next = this.queue[0]?.stride ?? 0;
      if (next < this.next) {
        // A level is complete; the next is left out where it would take too long.
        this.resolution = Math.floor(SIDE / this.next);
        const points = (SIDE / Math.max(next, 1)) ** 2 * 0.75;
        if ((points * this.computing) / this.computed / this.workers.length > patience) {
          this.queue = [];
          next = 0;
        }
        this.next = next;
      }
      const over = this.queue.length === 0 && ![...this.sent.values()].some((b) => b.job === this.job);
      if (over) this.elapsed = performance.now() - this.began;
      if (over || this.queue[0]?.stride !== batch.stride) this.placeLabels(batch.stride);
      this.changed();
    }
    this.feed(worker);
  }

  setShow(show: MapShow): void {
    this.show = show;
    for (let place = 0; place < SIDE * SIDE; place++) if (this.filled[place] !== 0) this.paint(place, this.color(this.blockOf(place)));
  }

  // Workers may answer out of turn: a coarse block leaves what finer ones have filled.
  private fill(place: number, stride: number): void {
    const color = this.color(place);
    const i0 = place % SIDE;
    const j0 = Math.floor(place / SIDE);
    for (let j = j0; j < Math.min(j0 + stride, SIDE); j++) {
      for (let i = i0; i < Math.min(i0 + stride, SIDE); i++) {
        const at = i + SIDE * j;
        if (this.filled[at] !== 0 && this.filled[at] < stride) continue;
        this.filled[at] = stride;
        this.paint(at, color);
      }
    }
  }

  // The computed point whose block fills this place.
  private blockOf(place: number): number {
    const stride = this.filled[place];
    const i = place % SIDE;
    const j = Math.floor(place / SIDE);
    return i - (i % stride) + SIDE * (j - (j % stride));
  }

  private color(place: number): Rgb {
    const index = this.show === "count" ? 0 : this.show === "effective" ? 1 : 2;
    const value = this.values[MAP_VALUES * place + index];
    const count = this.values[MAP_VALUES * place];
    if (Number.isNaN(count)) return invalidColor;
    if (index === 0) return countColor(value);
    return Number.isNaN(value) ? countColor(0) : ratioColor(value);
  }

  private paint(place: number, color: Rgb): void {
    const { data } = this.image;
    const at = 4 * ((place % SIDE) + SIDE * (SIDE - 1 - Math.floor(place / SIDE)));
    data[at] = color[0];
    data[at + 1] = color[1];
    data[at + 2] = color[2];
    data[at + 3] = 255;
  }

  // Each count is written where its region is widest.
  private placeLabels(stride: number): void {
    if (stride > 4) return;
    const step = 4;
    const n = SIDE / step;
    const best = new Map<number, { x: number; y: number; n: number; size: number }>();
    const width = new Float32Array(n * n);
    const cell = (i: number, j: number): number => this.values[MAP_VALUES * (i * step + SIDE * j * step)];
    for (const pass of [0, 1]) {
      for (let k = 0; k < n * n; k++) {
        const at = pass === 0 ? k : n * n - 1 - k;
        const [i, j] = [at % n, Math.floor(at / n)];
        if (pass === 0) width[at] = Math.min(i, n - 1 - i, j, n - 1 - j) + 1;
        for (const [di, dj] of [[-1, 0], [0, -1], [-1, -1], [1, -1]]) {
          const [a, b] = pass === 0 ? [i + di, j + dj] : [i - di, j - dj];
          if (a < 0 || b < 0 || a >= n || b >= n) continue;
          width[at] = Math.min(width[at], cell(a, b) === cell(i, j) ? width[a + n * b] + 1 : 1);
        }
      }
    }
    for (let at = 0; at < n * n; at++) {
      const [i, j] = [at % n, Math.floor(at / n)];
      const count = cell(i, j);
      const known = best.get(count);
      if (width[at] >= 3 && (!known || width[at] > known.size)) best.set(count, { x: (i + 0.5) / n, y: (j + 0.5) / n, n: count, size: width[at] });
    }
    this.labels = [...best.values()];
  }

  private scaleX(from: number, to: number): Scale {
    return new Scale(this.box.x[0], this.box.x[1], from, to);
  }
  private scaleY(from: number, to: number): Scale {
    return new Scale(this.box.y[0], this.box.y[1], from, to, true);
  }

  read(restitution: number, y: number): Reading | null {
    const i = Math.min(Math.floor(this.scaleX(0, SIDE).at(restitution)), SIDE - 1);
    const j = Math.min(Math.floor(this.scaleY(0, SIDE).at(y)), SIDE - 1);
    if (i < 0 || j < 0 || restitution > this.box.x[1] || y > this.box.y[1]) return null;
    if (this.filled[i + SIDE * j] === 0) return null;
    const place = this.blockOf(i + SIDE * j);
    const [count, effective, separation] = this.values.subarray(MAP_VALUES * place, MAP_VALUES * place + 3);
    return { restitution, y, count, effective, separation };
  }

  draw(g: CanvasRenderingContext2D, w: number, h: number, axis: MapAxis, mark: [number, number], theme: Theme): MapLayout {
    g.clearRect(0, 0, w, h);
    const size = fontSize(w);
    const left = 4.6 * size;
    const legend = 1.9 * size;
    const f: Frame = { left, top: 2.2 * size, width: w - left - 0.8 * size, height: h - 5.6 * size - legend };
    const x = this.scaleX(f.left, f.left + f.width);
    const y = this.scaleY(f.top + f.height, f.top);
    this.sheet.getContext("2d")!.putImageData(this.image, 0, 0);
    g.imageSmoothingEnabled = false;
    g.fillStyle = theme.faint;
    g.fillRect(f.left, f.top, f.width, f.height);
    g.drawImage(this.sheet, f.left, f.top, f.width, f.height);
    drawAxes(
      g, f, x, y,
      { ticks: niceTicks(x.low, x.high, Math.max(3, f.width / (5 * size))), name: (t) => String(Number(t.toPrecision(6))), title: "ε" },
      {
        ticks: logTicks(y.low, y.high),
        name: (t) => (axis === "gap" ? withUnit(t, "m", 4) : String(Number(t.toPrecision(4)))),
        title: axis === "gap" ? "gap Δh" : "R₁/R₂",
      },
      theme, size, false,
    );
    if (this.show === "count") this.drawLabels(g, f, theme, size);
    this.drawMark(g, f, x, y, axis, mark);
    this.drawLegend(g, f, h - legend, theme, size);
    return { x, y, frame: f };
  }

  private drawLabels(g: CanvasRenderingContext2D, f: Frame, theme: Theme, size: number): void {
    setFont(g, theme, 1.15 * size, 700);
    g.textAlign = "center";
    g.textBaseline = "middle";
    for (const label of this.labels) {
      if (Number.isNaN(label.n)) continue;
      g.fillStyle = inkOn(countColor(label.n));
      g.fillText(String(label.n), f.left + label.x * f.width, f.top + (1 - label.y) * f.height);
    }
  }

  private drawMark(g: CanvasRenderingContext2D, f: Frame, x: Scale, y: Scale, axis: MapAxis, [e, v]: [number, number]): void {
    g.save();
    g.beginPath();
    g.rect(f.left, f.top, f.width, f.height);
    g.clip();
    const [px, py] = [x.at(e), v > 0 ? y.at(v) : f.top + f.height - 1];
    for (const [color, width] of [["#ffffff", 5], ["#14161a", 2]] as const) {
      g.strokeStyle = color;
      g.lineWidth = width;
      if (axis === "ratio" && y.low < 1 && y.high > 1) {
        g.lineWidth = width * 0.5;
        stroke(g, f.left, y.at(1), f.left + f.width, y.at(1));
        g.lineWidth = width;
      }
      stroke(g, px - 11, py, px + 11, py);
      stroke(g, px, py - 11, px, py + 11);
      g.beginPath();
      g.arc(px, py, 6, 0, 2 * Math.PI);
      g.stroke();
    }
    g.restore();
  }

  private drawLegend(g: CanvasRenderingContext2D, f: Frame, top: number, theme: Theme, size: number): void {
    const height = 1.5 * size;
    g.textBaseline = "middle";
    if (this.show === "count") {
      const last = Math.min(MOST_COUNTED, Math.max(this.greatest, 4));
      const width = Math.min(2.4 * size, f.width / (last + 1));
      setFont(g, theme, Math.min(0.95 * size, 0.6 * width), 600);
      g.textAlign = "center";
      for (let n = 0; n <= last; n++) {
        g.fillStyle = css(countColor(n));
        g.fillRect(f.left + n * width, top, width + 0.5, height);
        g.fillStyle = inkOn(countColor(n));
        g.fillText(n === MOST_COUNTED && this.greatest > MOST_COUNTED ? `${n}+` : String(n), f.left + (n + 0.5) * width, top + height / 2 + 1);
      }
      return;
    }
    setFont(g, theme, 0.95 * size);
    const width = Math.min(0.55 * f.width, 15 * size);
    for (let i = 0; i < width; i++) {
      g.fillStyle = css(ratioColor(i / width));
      g.fillRect(f.left + 1.2 * size + i, top, 1.5, height);
    }
    g.fillStyle = theme.ink;
    g.textAlign = "left";
    g.fillText("0", f.left, top + height / 2);
    g.fillText("1", f.left + width + 1.6 * size, top + height / 2);
    g.fillStyle = css(ratioColor(1.5));
    g.fillRect(f.left + width + 3.4 * size, top, height, height);
    g.fillStyle = theme.ink;
    g.fillText("above 1", f.left + width + 5.3 * size, top + height / 2);
  }
}

export interface MapLayout {
  x: Scale;
  y: Scale;
  frame: Frame;
}
