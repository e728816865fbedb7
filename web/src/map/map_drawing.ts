// A map as a picture: its points, axes, names of the regions, the present setting and the legend.
import { digits, logTicks, niceTicks, takesPrefix, withUnit } from "../support/format";
import { Pen, type Frame } from "../support/pen";
import { drawAxes, fontSize, grown, Scale, type AxisText } from "../support/plot";
import {
  countColor,
  css,
  inkOn,
  invalidColor,
  MOST_COUNTED,
  noRatioColor,
  ratioColor,
  verdictColors,
  type Rgb,
  type Theme,
} from "../style/theme";
import { axes } from "../scenario/axes";
import type { Scenario } from "../scenario/scenario";
import { drawTrust, regionsInWords, type Agreement } from "./trust";
import type { Box, MapAxis, MapShow, MapView } from "../scenario/view";
import type { CountLabel } from "./map_raster";

export interface Layer {
  sheet: HTMLCanvasElement;
  box: Box;
}
export interface MapPicture {
  layers: Layer[]; // the last one on top
  view: Box; // range of the axes, which may differ from the computed range
  scenario: Scenario;
  map: Pick<MapView, "axis" | "across" | "show">;
  labels: CountLabel[]; // of the last layer
  greatest: number; // count
  highest: number; // ε_eff/ε
  kinds: ReadonlySet<string>; // colours beside the scale
  mark: [number, number];
  agreement: Agreement | null;
}

export interface MapLayout {
  x: Scale;
  y: Scale;
  frame: Frame;
}

export function drawMap(g: CanvasRenderingContext2D, w: number, h: number, p: MapPicture, theme: Theme): MapLayout {
  g.clearRect(0, 0, w, h);
  const size = fontSize(w);
  const pen = new Pen(g, theme, size);
  const left = 4.6 * size;
  const legend = 1.9 * size;
  const f: Frame = { left, top: 2.2 * size, width: w - left - 0.8 * size, height: h - 5.6 * size - legend };
  const { axis, across, show } = p.map;
  const x = new Scale(p.view.x[0], p.view.x[1], f.left, f.left + f.width, axes[across].log);
  const y = new Scale(p.view.y[0], p.view.y[1], f.top + f.height, f.top, axes[axis].log);
  g.imageSmoothingEnabled = false;
  g.fillStyle = theme.faint;
  g.fillRect(f.left, f.top, f.width, f.height);
  pen.within(f, () => {
    for (const { sheet, box } of p.layers) {
      const [left, right, low, high] = [x.at(box.x[0]), x.at(box.x[1]), y.at(box.y[0]), y.at(box.y[1])];
      g.drawImage(sheet, left, high, right - left, low - high);
    }
    if (p.labels.length > 0) drawLabels(pen, x, y, p);
    if (p.agreement) drawTrust(pen, p.agreement, x, y, f, p.mark);
  });
  const most = f.width / (5 * size);
  drawAxes(pen, f, x, y, textOf(p, across, x, most), textOf(p, axis, y, f.height / (3 * size)), false);
  pen.within(f, () => drawMark(pen, f, x, y, p));
  drawLegend(pen, f, h - legend, p, show);
  return { x, y, frame: f };
}

function textOf({ scenario }: MapPicture, axis: MapAxis, scale: Scale, wanted: number): AxisText {
  const { title, unit, log } = axes[axis];
  const units = unit(scenario);
  const plain = units === "" || !takesPrefix(units);
  return {
    ticks: log ? logTicks(scale.low, scale.high) : niceTicks(scale.low, scale.high, Math.max(3, wanted)),
    name: (t) =>
      !plain ? withUnit(t, units, 4) : log && t >= 1e5 ? digits(t) : String(Number(t.toPrecision(log ? 4 : 6))),
    title: title(scenario) + (plain && units ? ` (${units})` : ""),
  };
}

function drawLabels(pen: Pen, x: Scale, y: Scale, { labels, layers, map }: MapPicture): void {
  pen.font(1.15, 700);
  const { box } = layers[layers.length - 1];
  const across = new Scale(box.x[0], box.x[1], 0, 1, x.log);
  const up = new Scale(box.y[0], box.y[1], 0, 1, y.log);
  const verdict = map.show === "verdict";
  for (const { n, x: right, y: high, share } of labels) {
    if (Number.isNaN(n)) continue;
    const color = verdict ? verdictColors[n] : countColor(n);
    const name = verdict ? verdictNames[n] : n === 1 ? "1 contact" : `${n} contacts`;
    // The whole name where its region has room for it.
    const room = 1.8 * share * (x.at(box.x[1]) - x.at(box.x[0]));
    const fits = pen.widthOf(name) < room;
    if (!fits && verdict) continue;
    pen.text(fits ? name : String(n), x.at(across.value(right)), y.at(up.value(high)), inkOn(color), "center");
  }
}

function drawMark(pen: Pen, f: Frame, x: Scale, y: Scale, p: MapPicture): void {
  const large = grown(pen.size);
  // Gap 0 has no place on a logarithmic axis.
  const px = p.mark[0] > 0 ? x.at(p.mark[0]) : f.left + 1;
  const py = p.mark[1] > 0 ? y.at(p.mark[1]) : f.top + f.height - 1;
  const { axis, across } = p.map;
  for (const [color, thick] of [
    ["#ffffff", 5],
    ["#14161a", 2],
  ] as const) {
    const width = thick * large;
    const line = (x0: number, y0: number, x1: number, y1: number, share = 1): void =>
      pen.line(x0, y0, x1, y1, color, share * width);
    // equal radii
    if (axis === "ratio" && y.low < 1 && y.high > 1) line(f.left, y.at(1), f.left + f.width, y.at(1), 0.5);
    if (across === "ratio" && x.low < 1 && x.high > 1) line(x.at(1), f.top, x.at(1), f.top + f.height, 0.5);
    line(px - 11 * large, py, px + 11 * large, py);
    line(px, py - 11 * large, px, py + 11 * large);
    pen.stroked(color, width, [], () => pen.g.arc(px, py, 6 * large, 0, 2 * Math.PI));
  }
}

const legendNames: Record<MapShow, string> = {
  count: "ball–ball contacts (Newton)",
  effective: "effective ε over ε",
  separation: "effective ε over ε, at separation",
  verdict: "independent collisions and Newton",
};
// In the order of the core's answers.
export const verdictNames = ["agree", "by luck", "do not agree", "cannot be said"];

// What the colours and the regions mean, for those who do not see them.
export function mapInWords(show: MapShow, greatest: number, agreement: Agreement | null): string {
  const scales = {
    count: `0 to ${greatest}`,
    effective: "0 to 1",
    separation: "0 to 1",
    verdict: verdictNames.join(", "),
  };
  const regions = agreement ? ` ${regionsInWords(agreement.points, agreement.tolerance)}` : "";
  return `Colours: ${legendNames[show]}: ${scales[show]}.${regions}`;
}

// The name of the colours, the scale, and what is beside it.
function drawLegend(pen: Pen, f: Frame, top: number, p: MapPicture, show: MapShow): void {
  const { g, theme, size } = pen;
  pen.font(0.95);
  pen.text(legendNames[show], f.left, f.top + f.height + 7 + 1.3 * size, theme.ink, "left", "top");
  const swatches = swatchesOf(p, show);
  const width = (name: string): number => 2.2 * size + pen.widthOf(name);
  const beside = swatches.reduce((sum, [name]) => sum + width(name), 0);
  let at = f.left;
  if (show === "count") {
    const last = Math.min(MOST_COUNTED, Math.max(p.greatest, 4));
    at = drawCounts(pen, { ...f, width: f.width - beside }, last, p.greatest > MOST_COUNTED, top) + 0.6 * size;
  } else if (show !== "verdict") at = drawRatios(pen, f.left, Math.min(15 * size, f.width - beside - 3 * size), top);
  pen.font(0.95);
  for (const [name, color] of swatches) {
    g.fillStyle = css(color);
    g.fillRect(at, top, 1.2 * size, 1.5 * size);
    pen.text(name, at + 1.5 * size, top + 0.75 * size, theme.ink);
    at += width(name);
  }
}

function swatchesOf({ kinds, highest }: MapPicture, show: MapShow): [string, Rgb][] {
  const list: [string, Rgb][] =
    show === "verdict" ? verdictNames.slice(0, 3).map((name, i) => [name, verdictColors[i]]) : [];
  if (kinds.has("above"))
    list.push([highest < 1.005 ? "just above 1" : `above 1, up to ${digits(highest, 3)}`, ratioColor(1.5)]);
  if (kinds.has("none")) list.push(["none", noRatioColor]);
  if (kinds.has("invalid") || show === "verdict")
    list.push([show === "verdict" ? verdictNames[3] : "no answer", invalidColor]);
  return list;
}

// From 0 to 1; returns where it ends.
function drawRatios(pen: Pen, left: number, width: number, top: number): number {
  const { g, theme, size } = pen;
  const height = 1.5 * size;
  for (let i = 0; i < width; i++) {
    g.fillStyle = css(ratioColor(i / width));
    g.fillRect(left + 1.2 * size + i, top, 1.5, height);
  }
  pen.text("0", left, top + height / 2, theme.ink);
  pen.text("1", left + width + 1.6 * size, top + height / 2, theme.ink);
  return left + width + 3.2 * size;
}

// The colour legend up to `last`; open: the last field also stands for larger counts. Returns where it ends.
export function drawCounts(pen: Pen, f: Frame, last: number, open: boolean, top: number): number {
  const { g, size } = pen;
  const height = 1.5 * size;
  const width = Math.min(2.4 * size, f.width / (last + (open ? 1.6 : 1)));
  pen.font(Math.min(0.95, (0.6 * width) / size), 600);
  for (let n = 0; n <= last; n++) {
    const more = open && n === last;
    const own = (more ? 1.6 : 1) * width;
    const [left, middle] = [f.left + n * width, top + height / 2 + 1];
    g.fillStyle = css(countColor(n));
    g.fillRect(left, top, own + 0.5, height);
    pen.text(more ? `${n}+` : String(n), left + 0.5 * own, middle, inkOn(countColor(n)), "center");
  }
  return f.left + (last + (open ? 1.6 : 1)) * width;
}
