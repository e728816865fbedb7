// Validity of event-driven simulation: the gap above which both models agree, for every ε of the map.
import { grown, setFont, type Frame, type Scale } from "../support/plot";
import type { Theme } from "../style/theme";

const agreement = 0.05; // of ε_eff/ε with 1

// The lowest row above which a column of ε_eff/ε stays near 1; `side`: none, NaN: not computed.
export function trustedRow(ratio: (row: number) => number, side: number): number {
  let row = side;
  while (row > 0) {
    const value = ratio(row - 1);
    if (value === undefined) return NaN;
    if (!(Math.abs(value - 1) <= agreement)) break;
    row--;
  }
  return row;
}

export interface TrustPoint {
  restitution: number;
  gap: number; // m; infinity: none in the map
}

export function drawTrust(g: CanvasRenderingContext2D, points: TrustPoint[], x: Scale, y: Scale, f: Frame, theme: Theme, size: number): void {
  const shown = points.filter((p) => Number.isFinite(p.gap) && p.restitution >= x.low && p.restitution <= x.high);
  if (shown.length < 2) return;
  for (const [color, width] of [["#14161a", 6], ["#ffffff", 3]] as const) {
    g.strokeStyle = color;
    g.lineWidth = width * grown(size);
    g.lineJoin = "round";
    g.beginPath();
    let before: TrustPoint | null = null;
    for (const p of points) {
      if (!Number.isFinite(p.gap)) before = null;
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
  const at: [number, number] = [f.left + 0.5 * f.width, Math.max(Math.min(...shown.map((p) => y.at(p.gap))) - 0.4 * size, f.top + 1.5 * size)];
  const long = "models agree to 5 % above this line";
  const said = g.measureText(long).width < 0.9 * f.width ? long : "models agree above";
  g.strokeText(said, ...at);
  g.fillText(said, ...at);
}
