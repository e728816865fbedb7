// The positions of labels in a plot.
import type { Frame } from "./pen";

type Point = [number, number];

export interface Box {
  left: number;
  middle: number;
  width: number;
  height: number;
}

const strip = 8; // pixels: points are sorted into vertical strips

// Places labels within the frame, clear of the curves, of single points, of vertical lines and of other labels.
export class Room {
  private readonly strips: number[][] = [];
  private readonly taken: Box[] = [];

  constructor(
    private readonly frame: Frame,
    curves: Point[][],
    points: Point[],
    private readonly lines: number[],
  ) {
    for (const curve of curves) this.trace(curve);
    for (const [x, y] of points) this.add(x, y);
  }

  private add(x: number, y: number): void {
    if (x >= 0) (this.strips[Math.floor(x / strip)] ??= []).push(y);
  }

  // A point every two pixels.
  private trace(corners: Point[]): void {
    corners.forEach(([x, y], i) => {
      const [x0, y0] = corners[i - 1] ?? [x, y];
      const parts = Math.min(Math.ceil(Math.hypot(x - x0, y - y0) / 2), 500); // NaN where there is no curve
      for (let k = 1; k <= parts; k++) this.add(x0 + (k / parts) * (x - x0), y0 + (k / parts) * (y - y0));
    });
  }

  private cost({ left, middle, width, height }: Box): number {
    const [right, top, bottom] = [left + width, middle - 0.5 * height, middle + 0.5 * height];
    const { frame } = this;
    const outside =
      left < frame.left || right > frame.left + frame.width || top < frame.top || bottom > frame.top + frame.height;
    const over = this.taken.some(
      (b) => left < b.left + b.width && b.left < right && Math.abs(middle - b.middle) < 0.5 * (height + b.height),
    );
    let crossed = 0;
    for (let i = Math.max(Math.floor((left - 2) / strip), 0); i <= (right + 2) / strip; i++)
      for (const y of this.strips[i] ?? []) if (y > top - 1 && y < bottom + 1) crossed++;
    return (
      (outside ? 1e6 : 0) +
      (over ? 1e4 : 0) +
      crossed +
      20 * this.lines.filter((x) => x > left - 5 && x < right + 5).length
    );
  }

  // Returns and reserves the first of the best positions.
  take(places: Box[]): Box {
    const costs = places.map((place) => this.cost(place));
    const best = places[costs.indexOf(Math.min(...costs))];
    this.taken.push(best);
    return best;
  }
}
