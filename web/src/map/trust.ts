// Region of agreement of both models: for each ε the gap above which they agree.
import type { Box } from "../scenario/view";
import type { Pool } from "../core/pool";
import { inPercent } from "../scenario/tolerance";
import { columnOf, copyOf, type Scenario } from "../scenario/scenario";
import { observed } from "../state/signals";
import type { Theme } from "../style/theme";
import { grown, setFont, type Frame, type Scale } from "../support/plot";

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

export function drawTrust(
  g: CanvasRenderingContext2D,
  { points, tolerance }: Agreement,
  x: Scale,
  y: Scale,
  f: Frame,
  theme: Theme,
  size: number,
): void {
  const known = ({ gap }: TrustPoint): boolean => gap > 0 && gap < Infinity;
  const shown = points.filter((p) => known(p) && p.restitution >= x.low && p.restitution <= x.high);
  if (shown.length < 2) return;
  for (const [color, width] of [
    ["#14161a", 6],
    ["#ffffff", 3],
  ] as const) {
    g.strokeStyle = color;
    g.lineWidth = width * grown(size);
    g.lineJoin = "round";
    g.beginPath();
    let before: TrustPoint | null = null;
    for (const p of points) {
      if (!known(p)) before = null;
      else {
        if (before) g.lineTo(x.at(p.restitution), y.at(p.gap));
        else g.moveTo(x.at(p.restitution), y.at(p.gap));
        before = p;
      }
    }
    g.stroke();
  }
  setFont(g, theme, 1.05 * size, 700);
  g.textAlign = "center";
  g.textBaseline = "bottom";
  g.lineWidth = 5;
  g.lineJoin = "round";
  g.strokeStyle = "#14161a";
  g.fillStyle = "#ffffff";
  const at: [number, number] = [
    f.left + 0.5 * f.width,
    Math.max(Math.min(...shown.map((p) => y.at(p.gap))) - 0.4 * size, f.top + 1.5 * size),
  ];
  const long = `models agree to ${inPercent(tolerance)} above this line`;
  const text = g.measureText(long).width < 0.9 * f.width ? long : "models agree above";
  g.strokeText(text, ...at);
  g.fillText(text, ...at);
}
