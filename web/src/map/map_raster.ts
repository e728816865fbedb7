// The points of a map as pixels, in blocks that become finer, and the positions of labels.
import { MAP_VALUES } from "../core/map_points";
import { countColor, invalidColor, noRatioColor, ratioColor, verdictColors, type Rgb } from "../style/theme";
import { mapShows, type MapShow } from "../scenario/view";

export const SIDE = 400; // points in each direction

// Label of a region, at fractions of the map's width and height.
export interface CountLabel {
  x: number;
  y: number;
  n: number; // count, or index of the verdict
  share: number; // half the width of the region around the label, as a fraction of the map's
}

export class Raster {
  private readonly values = new Float64Array(SIDE * SIDE * MAP_VALUES);
  private readonly filled = new Uint8Array(SIDE * SIDE); // stride of the block that fills this point; 0: none yet
  private readonly image = new ImageData(SIDE, SIDE);
  private readonly sheet = sheetOf(SIDE);
  show: MapShow = "count";
  greatest = 0; // count
  highest = 1; // ε_eff/ε
  readonly kinds = new Set<"invalid" | "none" | "above">(); // what the legend has to name beside the scale

  clear(): void {
    this.image.data.fill(0);
    this.filled.fill(0);
    this.values.fill(NaN);
    this.greatest = 0;
    this.kinds.clear();
    this.highest = 1;
  }

  take(place: number, stride: number, values: Float64Array): void {
    this.values.set(values, MAP_VALUES * place);
    this.greatest = Math.max(this.greatest, values[0] || 0);
    this.fill(place, stride);
  }

  setShow(show: MapShow): void {
    if (show === this.show) return;
    this.show = show;
    this.kinds.clear();
    this.highest = 1;
    for (let place = 0; place < SIDE * SIDE; place++)
      if (this.filled[place] !== 0) this.paint(place, this.color(this.blockOf(place)));
  }

  picture(): HTMLCanvasElement {
    this.sheet.getContext("2d")!.putImageData(this.image, 0, 0);
    return this.sheet;
  }
  copy(): HTMLCanvasElement {
    const copy = sheetOf(SIDE);
    copy.getContext("2d")!.putImageData(this.image, 0, 0);
    return copy;
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
    const stride = this.filled[place] || 1;
    const i = place % SIDE;
    const j = Math.floor(place / SIDE);
    return i - (i % stride) + SIDE * (j - (j % stride));
  }

  private color(place: number): Rgb {
    const index = mapShows.indexOf(this.show);
    const value = this.values[MAP_VALUES * place + index];
    const count = this.values[MAP_VALUES * place];
    if (Number.isNaN(count) || (this.show === "verdict" && Number.isNaN(value)))
      return this.named("invalid", invalidColor);
    if (this.show === "count") return countColor(value);
    if (this.show === "verdict") return verdictColors[value];
    if (Number.isNaN(value)) return this.named("none", noRatioColor);
    if (value > 1.0000001) this.named("above", ratioColor((this.highest = Math.max(this.highest, value))));
    return ratioColor(value);
  }
  private named(kind: "invalid" | "none" | "above", color: Rgb): Rgb {
    this.kinds.add(kind);
    return color;
  }

  private paint(place: number, color: Rgb): void {
    const { data } = this.image;
    const at = 4 * ((place % SIDE) + SIDE * (SIDE - 1 - Math.floor(place / SIDE)));
    data[at] = color[0];
    data[at + 1] = color[1];
    data[at + 2] = color[2];
    data[at + 3] = 255;
  }

  computed(): { place: number; values: Float64Array }[] {
    const list = [];
    for (let place = 0; place < SIDE * SIDE; place++)
      if (this.filled[place] !== 0 && this.blockOf(place) === place)
        list.push({ place, values: this.values.subarray(MAP_VALUES * place, MAP_VALUES * (place + 1)) });
    return list;
  }

  // Labels each count or verdict where its region is widest.
  labels(): CountLabel[] {
    const step = 4;
    const n = SIDE / step;
    const best = new Map<number, CountLabel & { size: number }>();
    const width = new Float32Array(n * n);
    if (this.show !== "count" && this.show !== "verdict") return [];
    const index = mapShows.indexOf(this.show);
    const cell = (i: number, j: number): number =>
      this.values[MAP_VALUES * this.blockOf(i * step + SIDE * j * step) + index];
    for (const pass of [0, 1]) {
      for (let k = 0; k < n * n; k++) {
        const at = pass === 0 ? k : n * n - 1 - k;
        const [i, j] = [at % n, Math.floor(at / n)];
        if (pass === 0) width[at] = Math.min(i, n - 1 - i, j, n - 1 - j) + 1;
        for (const [di, dj] of [
          [-1, 0],
          [0, -1],
          [-1, -1],
          [1, -1],
        ]) {
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
      if (width[at] >= 3 && (!known || width[at] > known.size))
        best.set(count, { x: (i + 0.5) / n, y: (j + 0.5) / n, n: count, size: width[at], share: width[at] / n });
    }
    return [...best.values()];
  }
}

function sheetOf(side: number): HTMLCanvasElement {
  const sheet = document.createElement("canvas");
  sheet.width = sheet.height = side;
  return sheet;
}
