// Draws the disks of one simulation.
import { colorOf, type Theme } from "../style/theme";
import type { Sheet } from "../support/dom";
import { Pen, type Frame } from "../support/pen";
import { Disks } from "./disks";
import type { Seen, Start } from "./simulation";
import { RADIUS } from "./setting";

export interface GasTheme extends Theme {
  disk: string; // no contact
  lit: string; // contacts that overlap in time
}

export function gasTheme(theme: Theme, root: HTMLElement): GasTheme {
  return { ...theme, disk: colorOf(root, "disk"), lit: colorOf(root, "lit") };
}

export class WorldView {
  private readonly disks = new Disks();

  // `color` marks disks in contact.
  constructor(
    readonly sheet: Sheet,
    private readonly color: "newton" | "icm",
  ) {}

  draw(start: Start, seen: Seen, theme: GasTheme): void {
    const { g, width, height } = this.sheet;
    const margin = 3;
    const ratio = this.sheet.canvas.width / width;
    const pixels = Math.round((Math.min(width, height) - 2 * margin) * ratio);
    const side = pixels / ratio;
    const [left, top] = [(width - side) / 2, (height - side) / 2].map((x) => Math.round(x * ratio) / ratio);
    g.clearRect(0, 0, width, height);
    this.drawDisks(start, seen, pixels, theme);
    this.disks.draw(g, left * ratio, top * ratio);
    const pen = new Pen(g, theme, 0); // writes nothing
    const box: Frame = { left, top, width: side, height: side };
    drawSpokes(pen, start, seen, box);
    drawLinks(pen, start, seen, box);
    const { walls } = start.setting;
    g.lineWidth = walls ? 4 : 1.5;
    g.strokeStyle = walls ? theme.ink : theme.muted;
    g.setLineDash(walls ? [] : [6, 5]);
    g.strokeRect(left, top, side, side);
    g.setLineDash([]);
  }

  // Disks in contact are drawn over the others.
  private drawDisks(start: Start, { positions, touched }: Seen, pixels: number, theme: GasTheme): void {
    const { disks } = this;
    const { walls, number } = start.setting;
    const scale = pixels / start.input.edge;
    const r = RADIUS * scale;
    disks.clear(pixels, theme.ground);
    [{ fill: theme.disk }, { fill: theme[this.color] }, { fill: theme.lit, rim: theme.ink }].forEach((paint, kind) => {
      disks.set(kind, paint, r);
      for (let i = 0; i < number; i++) {
        if (touched[i] !== kind) continue;
        const [x, y] = [scale * positions[2 * i], pixels - scale * positions[2 * i + 1]];
        disks.put(kind, x, y);
        if (walls) continue;
        // Periodic images of a disk that crosses an edge.
        const dx = x < r ? pixels : x > pixels - r ? -pixels : 0;
        const dy = y < r ? pixels : y > pixels - r ? -pixels : 0;
        if (dx !== 0) disks.put(kind, x + dx, y);
        if (dy !== 0) disks.put(kind, x, y + dy);
        if (dx !== 0 && dy !== 0) disks.put(kind, x + dx, y + dy);
      }
    });
  }
}

// Draws one path in the box, with lines of a width relative to the radius of the disks on the screen. `place`: of a
// disk on the screen.
function drawLines(
  pen: Pen,
  start: Start,
  { positions }: Seen,
  box: Frame,
  width: (r: number) => number,
  trace: (place: (i: number) => [number, number], r: number) => void,
): void {
  const { left, top, height: side } = box;
  const scale = side / start.input.edge;
  const r = RADIUS * scale;
  const place = (i: number): [number, number] => [
    left + scale * positions[2 * i],
    top + side - scale * positions[2 * i + 1],
  ];
  pen.within(box, () => pen.stroked(pen.theme.ink, width(r), [], () => trace(place, r)));
}

// A radius of each disk that turns.
function drawSpokes(pen: Pen, start: Start, seen: Seen, box: Frame): void {
  if (seen.angles.length === 0) return;
  const width = (r: number): number => Math.max(1, 0.16 * r);
  drawLines(pen, start, seen, box, width, (place, r) =>
    seen.angles.forEach((angle, i) => {
      const [x, y] = place(i);
      pen.g.moveTo(x, y);
      pen.g.lineTo(x + r * Math.cos(angle), y - r * Math.sin(angle));
    }),
  );
}

// Lines between the centres of disks whose contacts overlap in time.
function drawLinks(pen: Pen, start: Start, seen: Seen, box: Frame): void {
  const { g } = pen;
  const { links } = seen;
  const side = box.width;
  const width = (r: number): number => Math.max(1.5, 0.3 * r);
  drawLines(pen, start, seen, box, width, (place, r) => {
    g.lineCap = "round";
    for (let k = 0; k < links.length; k += 2) {
      const [x0, y0] = place(links[k]);
      let [x1, y1] = place(links[k + 1]);
      if (!start.setting.walls) {
        x1 -= side * Math.round((x1 - x0) / side);
        y1 -= side * Math.round((y1 - y0) / side);
      }
      if (Math.hypot(x1 - x0, y1 - y0) > 3 * r) continue; // the contact has ended since
      g.moveTo(x0, y0);
      g.lineTo(x1, y1);
    }
  });
}
