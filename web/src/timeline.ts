// When the balls touch, for every ε (Fig. 3): bands are contacts, read horizontally.
import { Model, type Core, type TimelineRow } from "./core";
import type { Drop } from "./drop";
import { drawAxes, fontSize, Scale, setFont, stroke, timeTicks, timeUnit, type Frame } from "./plot";
import { ranges, type Scenario } from "./scenario";
import type { Theme } from "./theme";

const count = 241;
const low = ranges.restitution.low;
const restitutionAt = (i: number): number => low + ((1 - low) * i) / (count - 1);

// Rows are computed coarse first, as much as fits into each frame.
export class Timeline {
  private rows: (TimelineRow | undefined)[] = [];
  private adiabatic: (TimelineRow | undefined)[] = [];
  private queue: number[] = [];
  private stride = 1;
  private scenario: Scenario | null = null;
  done = true;

  start(scenario: Scenario): void {
    this.scenario = scenario;
    this.rows = new Array<TimelineRow | undefined>(count);
    this.adiabatic = new Array<TimelineRow | undefined>(count);
    this.queue = [];
    const seen = new Set<number>();
    for (let s = 16; s >= 1; s /= 2)
      for (let i = 0; i < count; i += s) {
        if (!seen.has(i)) this.queue.push(i);
        seen.add(i);
      }
    this.stride = 16;
    this.done = false;
  }

  // Works for about `budget` ms. Returns whether there is something new to draw.
  work(core: Core, budget: number): boolean {
    const { scenario } = this;
    if (this.done || !scenario) return false;
    core.set(scenario);
    const begin = performance.now();
    const exact = scenario.law === "linear" && scenario.balls.length === 2 && !scenario.cradle;
    const batch = exact ? 16 : 1;
    while (this.queue.length > 0 && performance.now() - begin < budget) {
      const indices = this.queue.splice(0, batch);
      const values = indices.map(restitutionAt);
      core.timeline(Model.newton, values).forEach((row, k) => (this.rows[indices[k]] = row));
      if (exact) core.timeline(Model.adiabatic, values).forEach((row, k) => (this.adiabatic[indices[k]] = row));
    }
    this.done = this.queue.length === 0;
    while (this.stride > 1 && this.complete(this.stride / 2)) this.stride /= 2;
    return true;
  }

  private complete(stride: number): boolean {
    for (let i = 0; i < count; i += stride) if (!this.rows[i]) return false;
    return true;
  }

  private at(rows: (TimelineRow | undefined)[], i: number): TimelineRow | undefined {
    return rows[i] ?? rows[i - (i % this.stride)];
  }

  // The whole floor contact and the last contact between balls of nearly all rows.
  private span(): number {
    const ends: number[] = [];
    let floor = 0;
    for (const row of this.rows) {
      if (!row) continue;
      if (row.tFloorEnd < Infinity) floor = Math.max(floor, row.tFloorEnd);
      ends.push(Number.isFinite(row.tEnd) ? row.tEnd : 0);
    }
    ends.sort((a, b) => a - b);
    const typical = ends[Math.floor(0.9 * (ends.length - 1))] ?? 0;
    return Math.max(1.2 * floor, 1.15 * typical, 1e-9);
  }

  draw(g: CanvasRenderingContext2D, w: number, h: number, d: Drop, theme: Theme): TimelineLayout {
    g.clearRect(0, 0, w, h);
    const size = fontSize(w);
    const f: Frame = { left: 3.2 * size, top: 2.2 * size, width: w - 3.2 * size - 1.4 * size, height: h - 5.4 * size };
    const begin = d.scenario.cradle ? d.from - 0.02 * (d.to - d.from) : Math.min(0, d.from);
    const span = this.span();
    const x = new Scale(begin, d.scenario.cradle ? Math.max(d.from + 1.15 * (span / 1.15 - d.from), begin + 1.1 * (d.to - begin)) : span, f.left, f.left + f.width);
    const y = new Scale(0, 1, f.top + f.height, f.top);
    g.save();
    g.beginPath();
    g.rect(f.left, f.top, f.width, f.height);
    g.clip();
    this.drawBands(g, x, y, d.scenario.balls.length > 2, theme);
    this.drawAdiabatic(g, x, y, theme);
    this.drawFloorEnd(g, x, y, theme);
    g.restore();
    const [factor, unit] = timeUnit(x.high - x.low);
    drawAxes(
      g, f, x, y,
      {
        ...timeTicks(x, d.origin, factor, f.width / (5.5 * size)),
        title: `time (${unit})`,
      },
      { ticks: [0, 0.2, 0.4, 0.6, 0.8, 1], name: (v) => v.toFixed(1), title: "ε" },
      theme, size, false,
    );
    this.drawChosen(g, x, y, f, d, theme, size);
    return { x, y, frame: f };
  }

  private drawBands(g: CanvasRenderingContext2D, x: Scale, y: Scale, several: boolean, theme: Theme): void {
    const edge = (i: number): number => Math.round(y.at(restitutionAt(i - 0.5))); // whole pixels leave no seams
    for (let i = 0; i < count; i++) {
      const row = this.at(this.rows, i);
      if (!row) continue;
      const top = edge(i + 1);
      const thickness = edge(i) - top;
      for (const c of row.contacts) {
        const from = x.at(c.begin);
        const width = x.at(Number.isFinite(c.end) ? c.end : x.high) - from;
        g.fillStyle = c.pair === 0 ? theme.faint : theme.pairs[c.pair];
        g.globalAlpha = several && c.pair > 0 ? 0.16 : 1;
        g.fillRect(from, top, Math.max(width, c.pair === 0 ? 0 : 1), thickness);
        g.globalAlpha = 1;
        if (!several || c.pair === 0) continue;
        g.fillRect(from - 1, top, 2.5, thickness); // bands of several pairs overlap: their edges tell them apart
        g.fillRect(from + width - 1.5, top, 2.5, thickness);
      }
    }
  }

  // Edges of the adiabatic contacts over the bands: where they coincide the reaction on the lower ball does not matter.
  private drawAdiabatic(g: CanvasRenderingContext2D, x: Scale, y: Scale, theme: Theme): void {
    g.fillStyle = theme.ink;
    for (let i = 0; i < count; i += 2) {
      const row = this.adiabatic[i];
      if (!row) continue;
      for (const c of row.contacts) {
        if (c.pair === 0) continue;
        for (const t of [c.begin, c.end]) if (Number.isFinite(t)) g.fillRect(x.at(t) - 0.6, y.at(restitutionAt(i)) - 0.6, 1.4, 1.4);
      }
    }
  }

  private drawFloorEnd(g: CanvasRenderingContext2D, x: Scale, y: Scale, theme: Theme): void {
    g.strokeStyle = theme.ink;
    g.lineWidth = 2;
    g.setLineDash([7, 5]);
    g.beginPath();
    let open = false;
    for (let i = 0; i < count; i++) {
      const row = this.at(this.rows, i);
      if (!row || !Number.isFinite(row.tFloorEnd)) {
        open = false;
        continue;
      }
      if (open) g.lineTo(x.at(row.tFloorEnd), y.at(restitutionAt(i)));
      else g.moveTo(x.at(row.tFloorEnd), y.at(restitutionAt(i)));
      open = true;
    }
    g.stroke();
    g.setLineDash([]);
  }

  private drawChosen(g: CanvasRenderingContext2D, x: Scale, y: Scale, f: Frame, d: Drop, theme: Theme, size: number): void {
    const at = y.at(d.scenario.restitution);
    g.strokeStyle = theme.ink;
    g.lineWidth = 3;
    stroke(g, f.left, at, f.left + f.width, at);
    setFont(g, theme, size, 700);
    const text = `ε = ${Number(d.scenario.restitution.toPrecision(4))}`;
    const width = g.measureText(text).width;
    g.fillStyle = theme.ink;
    g.textAlign = "right";
    g.textBaseline = "middle";
    const above = at - f.top > 2 * size;
    const middle = above ? at - 0.9 * size : at + 0.95 * size;
    g.fillStyle = theme.ground;
    g.globalAlpha = 0.85;
    g.fillRect(f.left + f.width - width - 14, middle - 0.7 * size, width + 10, 1.4 * size);
    g.globalAlpha = 1;
    g.fillStyle = theme.ink;
    g.fillText(text, f.left + f.width - 9, middle);
    if (d.scenario.balls.length !== 2) {
      this.drawNames(g, f, d.scenario.balls.length, theme, size);
      return;
    }
    g.textAlign = "center";
    let right = -Infinity;
    d.newton.run.contacts
      .filter((c) => c.pair === 1 && c.begin <= d.newton.run.last)
      .forEach((c, i) => {
        const end = Number.isFinite(c.end) ? c.end : x.high;
        const center = x.at((c.begin + end) / 2);
        const name = String(i + 1);
        const half = g.measureText(name).width / 2 + 3;
        if (center - half < right || center > f.left + f.width - width - 20) return;
        right = center + half;
        g.globalAlpha = 0.85;
        g.fillStyle = theme.ground;
        g.fillRect(center - half, middle - 0.65 * size, 2 * half, 1.3 * size);
        g.globalAlpha = 1;
        g.fillStyle = theme.ink;
        g.fillText(name, center, middle);
      });
  }

  private drawNames(g: CanvasRenderingContext2D, f: Frame, balls: number, theme: Theme, size: number): void {
    setFont(g, theme, size, 700);
    g.textAlign = "right";
    g.textBaseline = "bottom";
    let at = f.left + f.width;
    for (let j = balls - 1; j >= 1; j--) {
      const name = `${j}–${j + 1}`;
      g.fillStyle = theme.pairs[j];
      g.fillText(name, at, f.top - 4);
      at -= g.measureText(name).width + 0.9 * size;
    }
    g.fillStyle = theme.muted;
    g.fillText("balls", at, f.top - 4);
  }
}

export interface TimelineLayout {
  x: Scale;
  y: Scale;
  frame: Frame;
}
