// A map as a picture: its points, axes, names of the regions, the present setting and the legend.
import { logTicks, niceTicks, withUnit } from "../support/format";
import { drawAxes, fontSize, grown, Scale, setFont, stroke, type Frame } from "../support/plot";
import { countColor, css, inkOn, MOST_COUNTED, ratioColor, type Theme } from "../style/theme";
import { drawTrust, type Agreement } from "./trust";
import type { Box, MapAxis, MapShow } from "../scenario/view";
import type { CountLabel } from "./map_raster";

export interface Layer {
  sheet: HTMLCanvasElement;
  box: Box;
}
export interface MapPicture {
  layers: Layer[]; // the last one on top
  view: Box; // range of the axes, which may differ from the computed range
  axis: MapAxis;
  show: MapShow;
  labels: CountLabel[]; // of the last layer
  greatest: number; // count
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
  const left = 4.6 * size;
  const legend = 1.9 * size;
  const f: Frame = { left, top: 2.2 * size, width: w - left - 0.8 * size, height: h - 5.6 * size - legend };
  const x = new Scale(p.view.x[0], p.view.x[1], f.left, f.left + f.width);
  const y = new Scale(p.view.y[0], p.view.y[1], f.top + f.height, f.top, true);
  g.imageSmoothingEnabled = false;
  g.fillStyle = theme.faint;
  g.fillRect(f.left, f.top, f.width, f.height);
  g.save();
  g.beginPath();
  g.rect(f.left, f.top, f.width, f.height);
  g.clip();
  for (const { sheet, box } of p.layers) {
    const [left, right, low, high] = [x.at(box.x[0]), x.at(box.x[1]), y.at(box.y[0]), y.at(box.y[1])];
    g.drawImage(sheet, left, high, right - left, low - high);
  }
  if (p.show === "count") drawLabels(g, x, y, p, theme, size);
  else if (p.agreement) drawTrust(g, p.agreement, x, y, f, theme, size);
  g.restore();
  drawAxes(
    g,
    f,
    x,
    y,
    {
      ticks: niceTicks(x.low, x.high, Math.max(3, f.width / (5 * size))),
      name: (t) => String(Number(t.toPrecision(6))),
      title: "ε",
    },
    {
      ticks: logTicks(y.low, y.high),
      name: (t) => (p.axis === "gap" ? withUnit(t, "m", 4) : String(Number(t.toPrecision(4)))),
      title: p.axis === "gap" ? "gap Δh" : "R₁/R₂",
    },
    theme,
    size,
    false,
  );
  drawMark(g, f, x, y, p.axis, p.mark, grown(size));
  drawLegend(g, f, h - legend, p, theme, size);
  return { x, y, frame: f };
}

function drawLabels(
  g: CanvasRenderingContext2D,
  x: Scale,
  y: Scale,
  { labels, layers }: MapPicture,
  theme: Theme,
  size: number,
): void {
  setFont(g, theme, 1.15 * size, 700);
  g.textAlign = "center";
  g.textBaseline = "middle";
  const { box } = layers[layers.length - 1];
  const across = new Scale(box.x[0], box.x[1], 0, 1);
  const up = new Scale(box.y[0], box.y[1], 0, 1, true);
  for (const label of labels) {
    if (Number.isNaN(label.n)) continue;
    g.fillStyle = inkOn(countColor(label.n));
    g.fillText(String(label.n), x.at(across.value(label.x)), y.at(up.value(label.y)));
  }
}

function drawMark(
  g: CanvasRenderingContext2D,
  f: Frame,
  x: Scale,
  y: Scale,
  axis: MapAxis,
  [e, v]: [number, number],
  large: number,
): void {
  g.save();
  g.beginPath();
  g.rect(f.left, f.top, f.width, f.height);
  g.clip();
  const [px, py] = [x.at(e), v > 0 ? y.at(v) : f.top + f.height - 1];
  for (const [color, width] of [
    ["#ffffff", 5],
    ["#14161a", 2],
  ] as const) {
    g.strokeStyle = color;
    g.lineWidth = width * large;
    if (axis === "ratio" && y.low < 1 && y.high > 1) {
      g.lineWidth = 0.5 * width * large;
      stroke(g, f.left, y.at(1), f.left + f.width, y.at(1));
      g.lineWidth = width * large;
    }
    stroke(g, px - 11 * large, py, px + 11 * large, py);
    stroke(g, px, py - 11 * large, px, py + 11 * large);
    g.beginPath();
    g.arc(px, py, 6 * large, 0, 2 * Math.PI);
    g.stroke();
  }
  g.restore();
}

function drawLegend(
  g: CanvasRenderingContext2D,
  f: Frame,
  top: number,
  { show, greatest }: MapPicture,
  theme: Theme,
  size: number,
): void {
  const height = 1.5 * size;
  g.textBaseline = "middle";
  if (show === "count") {
    drawCounts(g, f, Math.min(MOST_COUNTED, Math.max(greatest, 4)), greatest > MOST_COUNTED, top, size, theme);
    return;
  }
  drawRatioName(g, f.left, top + height / 2, theme, size);
  setFont(g, theme, 0.95 * size);
  const width = Math.min(0.55 * f.width, 15 * size);
  for (let i = 0; i < width; i++) {
    g.fillStyle = css(ratioColor(i / width));
    g.fillRect(f.left + 1.2 * size + i, top, 1.5, height);
  }
  g.fillStyle = theme.ink;
  g.textAlign = "left";
  g.fillText("0", f.left, top + height / 2);
  const right = f.width > 34 * size ? "1: collisions are right" : "1";
  g.fillText(right, f.left + width + 1.6 * size, top + height / 2);
  const above = f.left + width + 2.8 * size + g.measureText(right).width;
  g.fillStyle = css(ratioColor(1.5));
  g.fillRect(above, top, height, height);
  g.fillStyle = theme.ink;
  g.fillText("above 1", above + 1.9 * size, top + height / 2);
}

// "ε_eff/ε" with a subscript, to the left of `right`.
function drawRatioName(g: CanvasRenderingContext2D, right: number, middle: number, theme: Theme, size: number): void {
  g.fillStyle = theme.ink;
  g.textAlign = "right";
  let at = right - 0.7 * size;
  for (const [text, scale, drop] of [
    ["/ε", 0.95, 0],
    ["eff", 0.7, 0.3],
    ["ε", 0.95, 0],
  ] as const) {
    setFont(g, theme, scale * size, 600);
    g.fillText(text, at, middle + drop * size);
    at -= g.measureText(text).width;
  }
}

// The colour legend up to `last`; open: the last field also stands for larger counts.
export function drawCounts(
  g: CanvasRenderingContext2D,
  f: Frame,
  last: number,
  open: boolean,
  top: number,
  size: number,
  theme: Theme,
): void {
  const height = 1.5 * size;
  const width = Math.min(2.4 * size, f.width / (last + (open ? 1.6 : 1)));
  setFont(g, theme, Math.min(0.95 * size, 0.6 * width), 600);
  g.textAlign = "center";
  g.textBaseline = "middle";
  for (let n = 0; n <= last; n++) {
    const more = open && n === last;
    const own = (more ? 1.6 : 1) * width;
    g.fillStyle = css(countColor(n));
    g.fillRect(f.left + n * width, top, own + 0.5, height);
    g.fillStyle = inkOn(countColor(n));
    g.fillText(more ? `${n}+` : String(n), f.left + n * width + 0.5 * own, top + height / 2 + 1);
  }
}
