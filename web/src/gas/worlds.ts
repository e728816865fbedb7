// Draws the disks of one world.
import { colorOf, type Theme } from "../style/theme";
import type { Seen, Start } from "./simulation";
import { RADIUS } from "./setting";

export interface GasTheme extends Theme {
  disk: string; // no contact
  lit: string; // contacts that overlap in time
}

export function gasTheme(theme: Theme, root: HTMLElement): GasTheme {
  return { ...theme, disk: colorOf(root, "disk"), lit: colorOf(root, "lit") };
}

// `color` marks disks in contact.
export function drawWorld(g: CanvasRenderingContext2D, width: number, height: number, start: Start, seen: Seen, color: string, theme: GasTheme): void {
  const margin = 3;
  const side = Math.min(width, height) - 2 * margin;
  const [left, top] = [(width - side) / 2, (height - side) / 2];
  const { walls, number } = start.setting;
  const scale = side / start.input.edge;
  const r = RADIUS * scale;
  g.clearRect(0, 0, width, height);
  g.fillStyle = theme.ground;
  g.fillRect(left, top, side, side);
  g.save();
  g.beginPath();
  g.rect(left, top, side, side);
  g.clip();
  const fills = [theme.disk, color, theme.lit];
  const paths = fills.map(() => new Path2D());
  const { positions, touched, links } = seen;
  const place = (i: number): [number, number] => [left + scale * positions[2 * i], top + side - scale * positions[2 * i + 1]];
  for (let i = 0; i < number; i++) {
    const [x, y] = place(i);
    const path = paths[touched[i]];
    const add = (cx: number, cy: number): void => {
      path.moveTo(cx + r, cy);
      path.arc(cx, cy, r, 0, 2 * Math.PI);
    };
    add(x, y);
    if (walls) continue;
    // Images of a disk that crosses an edge.
    const dx = x < left + r ? side : x > left + side - r ? -side : 0;
    const dy = y < top + r ? side : y > top + side - r ? -side : 0;
    if (dx !== 0) add(x + dx, y);
    if (dy !== 0) add(x, y + dy);
    if (dx !== 0 && dy !== 0) add(x + dx, y + dy);
  }
  const line = Math.max(1, 0.14 * r);
  g.lineWidth = line;
  paths.forEach((path, kind) => {
    g.fillStyle = fills[kind];
    g.fill(path);
    if (kind !== 2) return;
    g.strokeStyle = theme.ink;
    g.stroke(path);
  });
  g.lineWidth = Math.max(1.5, 0.3 * r);
  g.lineCap = "round";
  g.beginPath();
  for (let k = 0; k < links.length; k += 2) {
    const [x0, y0] = place(links[k]);
    let [x1, y1] = place(links[k + 1]);
    if (!walls) {
      x1 -= side * Math.round((x1 - x0) / side);
      y1 -= side * Math.round((y1 - y0) / side);
    }
    if (Math.hypot(x1 - x0, y1 - y0) > 3 * r) continue; // they have parted since
    g.moveTo(x0, y0);
    g.lineTo(x1, y1);
  }
  g.strokeStyle = theme.ink;
  g.stroke();
  g.restore();
  g.lineWidth = walls ? 4 : 1.5;
  g.strokeStyle = walls ? theme.ink : theme.muted;
  g.setLineDash(walls ? [] : [6, 5]);
  g.strokeRect(left, top, side, side);
  g.setLineDash([]);
}
