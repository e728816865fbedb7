// The map of contact counts or of ε_eff/ε over ε and the gap or R1/R2 (Figs. 4–6), computed in workers, coarse first.
import { MAP_VALUES } from "../core/core";
import { logTicks, niceTicks, withUnit } from "../support/format";
import { drawAxes, fontSize, grown, Scale, setFont, stroke, type Frame } from "../support/plot";
import { columnOf, type Scenario } from "../scenario/scenario";
import { countColor, css, inkOn, invalidColor, MOST_COUNTED, ratioColor, type Rgb, type Theme } from "../style/theme";
import { drawTrust, trustedRow, type TrustPoint } from "./trust";
import type { Box, MapAxis, MapShow } from "../app/view";
import { piece, type Piece, type Pool } from "../core/pool";

export const SIDE = 400; // points each way
const strides = [16, 8, 4, 2, 1];
const patience = 8_000; // ms: a finer level that would take longer is left out
const batchTime = 14; // ms: longest time of one batch

interface Batch {
  job: number;
  stride: number;
  at: number[]; // indices i + SIDE j of the points
}

export class ContactMap {
  box: Box;
  private readonly values = new Float32Array(SIDE * SIDE * MAP_VALUES);
  private readonly filled = new Uint8Array(SIDE * SIDE); // stride of the block that fills this place, 0: none yet
  private readonly image: ImageData;
  private readonly sheet: HTMLCanvasElement;
  private before: { sheet: HTMLCanvasElement; box: Box } | null = null; // previous picture, until there is a new one
  private queue: { stride: number; column: number; from: number }[] = []; // remaining points of a column
  private sent = 0; // batches of this job in progress
  private column: Float64Array = new Float64Array();
  private axis: MapAxis = "gap";
  private job = 0;
  private began = NaN; // when the first points were asked for
  private perPoint = 0; // ms, measured continuously; 0: not known yet
  private next = 0; // stride of the level that is being sent
  private show: MapShow = "count";
  private labels: { x: number; y: number; n: number }[] = [];
  elapsed: number | null = null; // ms for the whole map
  computing = 0; // ms of all workers together
  private computed = 0; // points
  resolution = 0; // points each way that are complete
  greatest = 0; // count in view
  fresh = false; // restarted: draw at once

  constructor(
    private readonly pool: Pool,
    private readonly changed: () => void,
    shown: () => boolean,
  ) {
    this.box = { x: [0.05, 1], y: [1e-6, 1e-2] };
    this.sheet = document.createElement("canvas");
    this.sheet.width = this.sheet.height = SIDE;
    this.image = new ImageData(SIDE, SIDE);
    pool.add(() => this.nextBatch(), shown);
  }

  // `keep`: the picture shows part of the same map and stays until it is overwritten.
  start(scenario: Scenario, axis: MapAxis, box: Box, keep: boolean): void {
    this.job++;
    this.before = keep ? { sheet: this.paintedSheet(), box: this.box } : null;
    this.image.data.fill(0);
    this.box = box;
    this.filled.fill(0);
    this.values.fill(NaN);
    this.labels = [];
    this.queue = [];
    this.elapsed = null;
    this.greatest = 0;
    this.fresh = true;
    this.next = strides[0];
    this.resolution = this.sent = this.perPoint = 0;
    this.computing = this.computed = 0;
    this.began = NaN;
    for (const stride of strides) for (let column = 0; column < SIDE; column += stride) this.queue.push({ stride, column, from: 0 });
    this.column = columnOf(scenario);
    this.axis = axis;
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
    batch.at.forEach((place, k) => {
      for (let v = 0; v < MAP_VALUES; v++) this.values[MAP_VALUES * place + v] = values[MAP_VALUES * k + v];
      this.greatest = Math.max(this.greatest, values[MAP_VALUES * k] || 0);
      this.fill(place, batch.stride);
    });
    const level = this.levelDone();
    const over = this.queue.length === 0 && this.sent === 0;
    if (over) this.elapsed = performance.now() - this.began;
    if (over || level) this.placeLabels(batch.stride);
    this.changed();
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

  setShow(show: MapShow): void {
    if (show === this.show) return;
    this.show = show;
    for (let place = 0; place < SIDE * SIDE; place++) if (this.filled[place] !== 0) this.paint(place, this.color(this.blockOf(place)));
  }

  // Workers may answer out of order: a coarse block does not overwrite finer ones.
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

  // The computed point whose block covers this pixel.
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

  // Labels each count where its region is widest.
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

  shows(restitution: number, y: number): boolean {
    const { x, y: v } = this.box;
    return restitution >= x[0] && restitution <= x[1] && y >= v[0] && y <= v[1];
  }

  private paintedSheet(): HTMLCanvasElement {
    const copy = document.createElement("canvas");
    copy.width = copy.height = SIDE;
    const g = copy.getContext("2d")!;
    g.putImageData(this.image, 0, 0);
    return copy;
  }

  // `view`: the range of the axes, which may differ from the computed range.
  draw(g: CanvasRenderingContext2D, w: number, h: number, axis: MapAxis, mark: [number, number], theme: Theme, view: Box = this.box): MapLayout {
    g.clearRect(0, 0, w, h);
    const size = fontSize(w);
    const left = 4.6 * size;
    const legend = 1.9 * size;
    const f: Frame = { left, top: 2.2 * size, width: w - left - 0.8 * size, height: h - 5.6 * size - legend };
    const x = new Scale(view.x[0], view.x[1], f.left, f.left + f.width);
    const y = new Scale(view.y[0], view.y[1], f.top + f.height, f.top, true);
    this.sheet.getContext("2d")!.putImageData(this.image, 0, 0);
    g.imageSmoothingEnabled = false;
    g.fillStyle = theme.faint;
    g.fillRect(f.left, f.top, f.width, f.height);
    g.save();
    g.beginPath();
    g.rect(f.left, f.top, f.width, f.height);
    g.clip();
    if (this.elapsed !== null) this.before = null;
    for (const part of [this.before, { sheet: this.sheet, box: this.box }]) {
      if (!part) continue;
      const [left, right, low, high] = [x.at(part.box.x[0]), x.at(part.box.x[1]), y.at(part.box.y[0]), y.at(part.box.y[1])];
      g.drawImage(part.sheet, left, high, right - left, low - high);
    }
    if (this.show === "count") this.drawLabels(g, x, y, theme, size);
    else if (axis === "gap") drawTrust(g, this.trusted(), x, y, f, theme, size);
    g.restore();
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
    this.drawMark(g, f, x, y, axis, mark, grown(size));
    this.drawLegend(g, f, h - legend, theme, size);
    return { x, y, frame: f };
  }

  // For each column the gap above which both models agree; empty until the map is complete.
  trusted(): TrustPoint[] {
    if (this.elapsed === null) return [];
    const [x, y] = [this.scaleX(0, SIDE), this.scaleY(0, SIDE)];
    const value = this.show === "separation" ? 2 : 1;
    return Array.from({ length: SIDE }, (_, i) => {
      const row = trustedRow((j) => this.values[MAP_VALUES * this.blockOf(i + SIDE * j) + value], SIDE);
      return { restitution: x.value(i + 0.5), gap: row < SIDE ? y.value(row) : Infinity };
    });
  }

  private drawLabels(g: CanvasRenderingContext2D, x: Scale, y: Scale, theme: Theme, size: number): void {
    setFont(g, theme, 1.15 * size, 700);
    g.textAlign = "center";
    g.textBaseline = "middle";
    for (const label of this.labels) {
      if (Number.isNaN(label.n)) continue;
      g.fillStyle = inkOn(countColor(label.n));
      g.fillText(String(label.n), x.at(this.scaleX(0, 1).value(label.x)), y.at(this.scaleY(0, 1).value(label.y)));
    }
  }

  private drawMark(g: CanvasRenderingContext2D, f: Frame, x: Scale, y: Scale, axis: MapAxis, [e, v]: [number, number], large: number): void {
    g.save();
    g.beginPath();
    g.rect(f.left, f.top, f.width, f.height);
    g.clip();
    const [px, py] = [x.at(e), v > 0 ? y.at(v) : f.top + f.height - 1];
    for (const [color, width] of [["#ffffff", 5], ["#14161a", 2]] as const) {
      g.strokeStyle = color;
      g.lineWidth = width * large;
      if (axis === "ratio" && y.low < 1 && y.high > 1) {
        g.lineWidth = 0.5 * width * large;
        stroke(g, f.left, y.at(1), f.left + f.width, y.at(1));
        g.lineWidth = width * large;
      }
      stroke(g, px - 11 * large, py, px + 11 * large, py);
      stroke(g, px, py - 11 * large, px, py + 11 * large);
      g.beginPath();
      g.arc(px, py, 6 * large, 0, 2 * Math.PI);
      g.stroke();
    }
    g.restore();
  }

  private drawLegend(g: CanvasRenderingContext2D, f: Frame, top: number, theme: Theme, size: number): void {
    const height = 1.5 * size;
    g.textBaseline = "middle";
    if (this.show === "count") {
      drawCounts(g, f, Math.min(MOST_COUNTED, Math.max(this.greatest, 4)), this.greatest > MOST_COUNTED, top, size, theme);
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

// The colour legend up to `last`; open: the last field also stands for larger counts.
export function drawCounts(g: CanvasRenderingContext2D, f: Frame, last: number, open: boolean, top: number, size: number, theme: Theme): void {
  const height = 1.5 * size;
  const width = Math.min(2.4 * size, f.width / (last + (open ? 1.6 : 1)));
  setFont(g, theme, Math.min(0.95 * size, 0.6 * width), 600);
  g.textAlign = "center";
  g.textBaseline = "middle";
  for (let n = 0; n <= last; n++) {
    const more = open && n === last;
    const own = (more ? 1.6 : 1) * width;
    g.fillStyle = css(countColor(n));
    g.fillRect(f.left + n * width, top, own + 0.5, height);
    g.fillStyle = inkOn(countColor(n));
    g.fillText(more ? `${n}+` : String(n), f.left + n * width + 0.5 * own, top + height / 2 + 1);
  }
}

export interface MapLayout {
  x: Scale;
  y: Scale;
  frame: Frame;
}
