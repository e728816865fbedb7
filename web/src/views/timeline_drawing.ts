// The timeline as a picture: bands in which bodies touch, the end of the floor contact, the present ε.
import type { Contact, TimelineRow } from "../core/core";
import type { Drop } from "../core/drop";
import { Pen, type Frame } from "../support/pen";
import { drawAxes, fontSize, grown, Scale, timeTicks, timeUnit } from "../support/plot";
import type { Theme } from "../style/theme";

export interface TimelinePicture {
  rows: TimelineRow[]; // by ε
  adiabatic: TimelineRow[];
  span: number; // last time shown [s]
}

export interface TimelineLayout {
  x: Scale;
  y: Scale;
  frame: Frame;
}

export function drawTimeline(
  g: CanvasRenderingContext2D,
  w: number,
  h: number,
  p: TimelinePicture,
  d: Drop,
  theme: Theme,
): TimelineLayout {
  g.clearRect(0, 0, w, h);
  const size = fontSize(w);
  const pen = new Pen(g, theme, size);
  const f: Frame = { left: 3.2 * size, top: 2.2 * size, width: w - 3.2 * size - 1.4 * size, height: h - 5.4 * size };
  const begin = d.scenario.cradle ? d.from - 0.02 * (d.to - d.from) : Math.min(0, d.from);
  const { span } = p;
  const x = new Scale(
    begin,
    d.scenario.cradle ? Math.max(d.from + 1.15 * (span / 1.15 - d.from), begin + 1.1 * (d.to - begin)) : span,
    f.left,
    f.left + f.width,
  );
  const y = new Scale(0, 1, f.top + f.height, f.top);
  pen.within(f, () => {
    drawBands(pen, x, y, p.rows, d.scenario.balls.length > 2);
    drawAdiabatic(pen, x, y, p.adiabatic);
    drawFloorEnd(pen, x, y, p.rows);
  });
  const [factor, unit] = timeUnit(x.high - x.low);
  drawAxes(
    pen,
    f,
    x,
    y,
    {
      ...timeTicks(x, d.origin, factor, f.width / (5.5 * size)),
      title: `time (${unit})`,
    },
    { ticks: [0, 0.2, 0.4, 0.6, 0.8, 1], name: (v) => v.toFixed(1), title: "ε" },
    false,
  );
  drawChosen(pen, x, y, f, d);
  return { x, y, frame: f };
}

// Draws the regions in which two bodies touch. A region consists of neighbouring rows with the same contacts.
function drawBands(pen: Pen, x: Scale, y: Scale, rows: TimelineRow[], several: boolean): void {
  const { theme } = pen;
  // A contact that never ends extends to the edge of the plot.
  const end = (c: Contact): number => x.at(Number.isFinite(c.end) ? c.end : Math.max(c.begin, x.high));
  for (const group of runsOf(rows)) {
    const last = group.length - 1;
    const heights = group.map((row) => y.at(row.restitution));
    const [bottom, top] = [y.at(border(rows, group[0], -1)), y.at(border(rows, group[last], 1))];
    group[0].contacts.forEach(({ pair }, k) => {
      const left = group.map((row, i): [number, number] => [x.at(row.contacts[k].begin), heights[i]]);
      const right = group.map((row, i): [number, number] => [end(row.contacts[k]), heights[i]]);
      // Pixels of overlap with the next region, to avoid a hairline between them.
      const over = several && pair > 0 ? 0 : 0.5;
      for (const edge of [left, right]) {
        edge.unshift([edge[0][0], bottom + over]);
        edge.push([edge[last + 1][0], top - over]);
      }
      const color = pair === 0 ? theme.faint : theme.pairs[pair];
      pen.area([...left, ...right.reverse()], color, several && pair > 0 ? 0.16 : 1);
      const width = pair === 0 ? 0.5 : several ? 2.5 : 1; // bands of several pairs overlap: edges distinguish them
      for (const edge of [left, right]) pen.curve(edge, color, width);
    });
  }
}

// The region of a row ends half way to the next row above (1) or below (−1).
function border(rows: TimelineRow[], row: TimelineRow, side: 1 | -1): number {
  const next = rows[rows.indexOf(row) + side];
  return next ? 0.5 * (row.restitution + next.restitution) : row.restitution;
}

// Draws the edges of the adiabatic contacts over the bands. Where both coincide, the lower ball is not affected by the
// upper one.
function drawAdiabatic({ g, theme }: Pen, x: Scale, y: Scale, rows: TimelineRow[]): void {
  g.fillStyle = theme.ink;
  for (const group of runsOf(rows))
    group[0].contacts.forEach(({ pair }, k) => {
      if (pair === 0) return;
      for (const edge of ["begin", "end"] as const)
        dots(
          g,
          group
            .filter((row) => Number.isFinite(row.contacts[k][edge]))
            .map((row) => [x.at(row.contacts[k][edge]), y.at(row.restitution)]),
        );
    });
}

function drawFloorEnd(pen: Pen, x: Scale, y: Scale, rows: TimelineRow[]): void {
  const thick = grown(pen.size);
  const ends = rows.map(({ restitution, tFloorEnd }): [number, number] => [x.at(tFloorEnd), y.at(restitution)]);
  pen.curve(ends, pen.theme.ink, 2 * thick, [7 * thick, 5 * thick]);
}

function drawChosen(pen: Pen, x: Scale, y: Scale, f: Frame, d: Drop): void {
  const { theme, size } = pen;
  const at = y.at(d.scenario.restitution);
  pen.line(f.left, at, f.left + f.width, at, theme.ink, 3 * grown(size));
  pen.font(1, 700);
  const text = `ε = ${Number(d.scenario.restitution.toPrecision(4))}`;
  const width = pen.widthOf(text);
  const above = at - f.top > 2 * size;
  const middle = above ? at - 0.9 * size : at + 0.95 * size;
  pen.veil(f.left + f.width - width - 14, middle - 0.7 * size, width + 10, 1.4 * size, theme.ground, 0.85);
  pen.text(text, f.left + f.width - 9, middle, theme.ink, "right");
  if (d.scenario.balls.length !== 2) {
    drawNames(pen, f, d.scenario.balls.length);
    return;
  }
  let right = -Infinity;
  d.newton.run.contacts
    .filter((c) => c.pair === 1 && c.begin <= d.newton.run.last)
    .forEach((c, i) => {
      const end = Number.isFinite(c.end) ? c.end : Math.max(c.begin, x.high);
      // The cursor of the film often stands in the middle of a long contact.
      const center = Math.min(x.at((c.begin + end) / 2), x.at(c.begin) + 1.2 * size);
      const name = String(i + 1);
      const half = pen.widthOf(name) / 2 + 3;
      if (center - half < right || center > f.left + f.width - width - 20) return;
      right = center + half;
      pen.veil(center - half, middle - 0.65 * size, 2 * half, 1.3 * size, theme.ground, 0.85);
      pen.text(name, center, middle, theme.ink, "center");
    });
}

function drawNames(pen: Pen, f: Frame, balls: number): void {
  pen.font(1, 700);
  let at = f.left + f.width;
  for (let j = balls - 1; j >= 1; j--) {
    const name = `${j}–${j + 1}`;
    pen.text(name, at, f.top - 4, pen.theme.pairs[j], "right", "bottom");
    at -= pen.widthOf(name) + 0.9 * pen.size;
  }
  pen.text("balls", at, f.top - 4, pen.theme.muted, "right", "bottom");
}

// Whether two rows have the same contacts, in the same order.
export const alike = (a: TimelineRow, b: TimelineRow): boolean =>
  a.contacts.length === b.contacts.length &&
  a.contacts.every(
    (c, k) => c.pair === b.contacts[k].pair && Number.isFinite(c.end) === Number.isFinite(b.contacts[k].end),
  );

// A dotted line of rectangles: a dashed stroke with so many dots takes a hundred times as long.
function dots(g: CanvasRenderingContext2D, places: [number, number][]): void {
  const apart = 4;
  let next = 0; // pixels to the next dot
  for (let i = 1; i < places.length; i++) {
    const [[x0, y0], [x1, y1]] = [places[i - 1], places[i]];
    const length = Math.min(Math.hypot(x1 - x0, y1 - y0), 2000);
    for (; next <= length; next += apart) {
      const u = length > 0 ? next / length : 0;
      g.fillRect(x0 + u * (x1 - x0) - 0.7, y0 + u * (y1 - y0) - 0.7, 1.4, 1.4);
    }
    next -= length;
  }
}

// Groups of neighbouring rows with the same contacts.
function runsOf(rows: TimelineRow[]): TimelineRow[][] {
  const runs: TimelineRow[][] = [];
  rows.forEach((row, i) => {
    if (i > 0 && alike(rows[i - 1], row)) runs[runs.length - 1].push(row);
    else runs.push([row]);
  });
  return runs;
}
