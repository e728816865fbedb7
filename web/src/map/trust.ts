// Region of agreement of both models: for each ε the gap above which they agree.
import type { Box } from "../scenario/view";
import type { Pool } from "../core/pool";
import { inPercent } from "../scenario/tolerance";
import { digits, withUnit } from "../support/format";
import { columnOf, copyOf, type Scenario } from "../scenario/scenario";
import { observed } from "../state/signals";
import type { Frame, Pen } from "../support/pen";
import { grown, type Scale } from "../support/plot";

export interface TrustPoint {
  restitution: number;
  gap: number; // as agreement_gaps() of the core has it [m]: only finite positive ones are on the line
}

const columns = 64;

// Boundary of the region, by the verdict of the core.
export class Agreement {
  points: TrustPoint[] = [];
  present: TrustPoint | null = null; // at the ε of the setting
  tolerance = NaN;
  private key = "";
  private presentKey = "";

  constructor(private readonly pool: Pool) {
    observed(this, ["points", "present"]);
  }

  refresh(scenario: Scenario, { x, y }: Box, tolerance: number): void {
    const base = copyOf(scenario);
    base.restitution = base.gaps[0] = 0;
    const key = JSON.stringify([base, x, y, tolerance]);
    this.refreshPresent(scenario, y, tolerance, key);
    if (key === this.key) return;
    this.key = key;
    this.points = [];
    this.tolerance = tolerance;
    const restitution = Array.from({ length: columns }, (_, i) => x[0] + ((x[1] - x[0]) * i) / (columns - 1));
    void this.ask(scenario, restitution, y, tolerance).then((points) => {
      if (key === this.key) this.points = points;
    });
  }

  private refreshPresent(scenario: Scenario, y: Box["y"], tolerance: number, base: string): void {
    const key = base + String(scenario.restitution);
    if (key === this.presentKey) return;
    this.presentKey = key;
    this.present = null;
    void this.ask(scenario, [scenario.restitution], y, tolerance).then(([point]) => {
      if (key === this.presentKey) this.present = point;
    });
  }

  private async ask(scenario: Scenario, restitution: number[], y: Box["y"], tolerance: number): Promise<TrustPoint[]> {
    const request = { column: columnOf(scenario), restitution, low: y[0], high: y[1], tolerance };
    const gaps = await this.pool.ask("agreement", request);
    return restitution.map((e, i) => ({ restitution: e, gap: gaps[i] }));
  }
}

// The names of what is above and below the line, or of a map that has no line.
export interface RegionNames {
  above: string[]; // the longest first
  below: string[];
  none: string[];
}

const onLine = ({ gap }: TrustPoint): boolean => gap > 0 && gap < Infinity;

export function regionNames(points: TrustPoint[], tolerance: number): RegionNames {
  const names: RegionNames = { above: [], below: [], none: [] };
  const to = inPercent(tolerance);
  if (points.some(onLine)) {
    names.above = [`to be trusted: models agree to ${to}`, `models agree to ${to}`, "models agree"];
    names.below = ["not to be trusted", "not trusted"];
  } else if (points.length > 0 && points.every(({ gap }) => gap === Infinity))
    names.none = [`not to be trusted: models agree to ${to} at no gap shown`, "not to be trusted here"];
  else if (points.length > 0 && points.every(({ gap }) => Number.isNaN(gap)))
    names.none = ["no line: at the widest gap nothing to compare", "nothing to compare"];
  else if (points.length > 0)
    names.none = [`no line: models do not agree to ${to} at the widest gap`, "no line of agreement"];
  return names;
}

// The same in a sentence, for those who do not see the picture.
export function regionsInWords(points: TrustPoint[], tolerance: number): string {
  const { above, below, none } = regionNames(points, tolerance);
  if (none.length > 0) return `${none[0]}.`;
  const line = points.filter(onLine);
  if (line.length === 0) return "";
  const ends = [line[0], line[line.length - 1]].map(
    ({ restitution, gap }) => `${withUnit(gap, "m", 2)} at ε = ${digits(restitution, 2)}`,
  );
  return `A line runs from a gap of ${ends.join(" to one of ")}. Above it, ${above[0]}. Below it, ${below[0]}: models need not agree.`;
}

export function drawTrust(
  pen: Pen,
  { points, tolerance }: Pick<Agreement, "points" | "tolerance">,
  x: Scale,
  y: Scale,
  f: Frame,
  mark: [number, number],
): void {
  const shown = points.filter((p) => p.restitution >= x.low && p.restitution <= x.high);
  const parts = partsOf(points, x, y);
  drawParts(pen, parts);
  pen.font(1.05, 700);
  const { above, below, none } = regionNames(shown, tolerance);
  const places = placesIn(f, 1.7 * pen.size, parts.flat(), [x.at(mark[0]), y.at(mark[1])]);
  for (const [names, side] of [
    [above, "above"],
    [below, "below"],
    [none, "middle"],
  ] as const)
    for (const name of names) {
      const at = places(pen.widthOf(name) + pen.size, side);
      if (!at) continue;
      pen.label(name, ...at, "#ffffff", "center", "middle", "#14161a");
      break;
    }
}

type Pixel = [x: number, y: number];

// The line in pixels: its parts between columns without a point. A single point is as wide as its column.
function partsOf(points: TrustPoint[], x: Scale, y: Scale): Pixel[][] {
  const parts: Pixel[][] = [[]];
  for (const p of points)
    if (onLine(p)) parts[parts.length - 1].push([x.at(p.restitution), y.at(p.gap)]);
    else if (parts[parts.length - 1].length > 0) parts.push([]);
  const half = points.length > 1 ? 0.5 * (x.at(points[1].restitution) - x.at(points[0].restitution)) : 0;
  return parts.map((part) => (part.length === 1 ? [-half, half].map((by) => [part[0][0] + by, part[0][1]]) : part));
}

function drawParts({ g, size }: Pen, parts: Pixel[][]): void {
  for (const [color, width] of [
    ["#14161a", 6],
    ["#ffffff", 3],
  ] as const) {
    g.strokeStyle = color;
    g.lineWidth = width * grown(size);
    g.lineJoin = "round";
    g.beginPath();
    for (const part of parts) part.forEach((at, i) => (i === 0 ? g.moveTo(...at) : g.lineTo(...at)));
    g.stroke();
  }
}

// Where a name fits beside the line, clear of it and of the mark, as near to the middle as possible; null: nowhere.
function placesIn(
  f: Frame,
  height: number,
  line: Pixel[],
  [markX, markY]: Pixel,
): (width: number, side: "above" | "below" | "middle") => Pixel | null {
  const clear = 0.7 * height; // of the mark
  return (width, side) => {
    const room = f.width - width;
    if (room < 0) return null;
    for (let k = 0; k <= 20; k++) {
      const centre = f.left + 0.5 * f.width + (0.5 * room * ((k % 2 === 0 ? 1 : -1) * Math.ceil(k / 2))) / 10;
      const near = line.filter(([x]) => Math.abs(x - centre) <= 0.5 * width + 4).map(([, y]) => y);
      const over = Math.abs(markX - centre) < 0.5 * width + clear;
      const start = side === "above" ? Math.min(...near) - 0.8 * height : Math.max(...near) + 0.8 * height;
      const tries = side === "middle" ? [0.5, 0.3, 0.7].map((share) => f.top + share * f.height) : [start];
      if (side !== "middle") tries.push(start + (side === "above" ? -2.2 : 2.2) * height);
      const at = tries.find(
        (y) =>
          y - 0.5 * height >= f.top &&
          y + 0.5 * height <= f.top + f.height &&
          !(over && Math.abs(markY - y) < 0.5 * height + clear),
      );
      if (at !== undefined && (side === "middle" || near.length > 0)) return [centre, at];
    }
    return null;
  };
}
