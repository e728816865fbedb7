// The plots over time: energy, its difference between both simulations, their distance, fraction of overlapping
// contacts.
import { divergenceOf } from "./divergence";
import { digits, logTicks, minus, niceTicks } from "../support/format";
import { drawAxes, fontSize, grown, Scale, setFont, timeTicks, timeUnit, type Frame } from "../support/plot";
import type { Facts } from "./facts";
import type { Sample } from "./simulation";
import type { GasTheme } from "./worlds";

export const graphs = ["energy", "difference", "distance", "share"] as const;
export type Graph = (typeof graphs)[number];

interface Curve {
  points: [number, number][];
  color: string;
  width: number;
  dash: number[];
  name?: string;
}
interface Plot {
  title: string;
  y: (to: number, from: number) => Scale;
  ticks: (y: Scale) => number[];
  name: (tick: number) => string;
  curves: Curve[];
  band?: [number, number][];
}

const curve = (
  samples: readonly Sample[],
  y: (s: Sample) => number,
  color: string,
  width = 2,
  dash: number[] = [],
  x: (s: Sample) => number = (s) => s.time,
): Curve => ({
  points: samples.map((s) => [x(s), y(s)]),
  color,
  width,
  dash,
});
const decades = (y: Scale): number[] => {
  const all = logTicks(y.low, y.high);
  const every = Math.ceil(all.length / 4);
  return all.filter((_, i) => i % every === 0);
};
const power = (tick: number): string =>
  tick >= 0.001 && tick <= 1000 ? String(Number(tick.toPrecision(3))) : digits(tick, 1);

function energyPlot({ samples, start }: Facts, theme: GasTheme): Plot {
  const lowest = Math.min(...samples.flatMap((s) => s.energy).filter((e) => e > 0), 1);
  const log = lowest < 0.1 && start.setting.gravity === 0;
  const low = log ? 10 ** Math.floor(Math.log10(lowest)) : 0;
  return {
    title: "energy left, E/E(0)",
    y: (to, from) => new Scale(low, 1, from, to, log),
    ticks: (y) => (log ? decades(y) : niceTicks(0, 1, 2)),
    name: (tick) => (log ? power(tick) : String(tick)),
    curves: [
      { ...curve(samples, (s) => s.energy[0], theme.icm, 2.5), name: "event-driven" },
      { ...curve(samples, (s) => s.energy[1], theme.newton, 2.5), name: "Newton" },
    ],
  };
}

// Moving average over a thirtieth of the run, because both energies decrease in small steps.
function smoothed(of: Curve): Curve {
  const { points } = of;
  const half = Math.floor(points.length / 60);
  // Cumulative sums and numbers of all points before.
  const [sums, known] = [new Float64Array(points.length + 1), new Uint32Array(points.length + 1)];
  points.forEach(([, y], i) => {
    const counts = Number.isFinite(y);
    sums[i + 1] = sums[i] + (counts ? y : 0);
    known[i + 1] = known[i] + (counts ? 1 : 0);
  });
  const mean = (i: number): number => {
    const [from, to] = [Math.max(i - half, 0), Math.min(i + half + 1, points.length)];
    return (sums[to] - sums[from]) / (known[to] - known[from]);
  };
  return { ...of, points: points.map(([t, y], i) => [t, Number.isFinite(y) ? mean(i) : NaN]) };
}

// Ratio of Newton's energy to that of the event-driven simulation, minus one: measured, and by the law.
function differencePlot({ samples, start }: Facts, theme: GasTheme): Plot {
  const over = (s: Sample, energy: number): number => (s.energy[0] > 0 ? energy / s.energy[0] - 1 : NaN);
  const law = start.setting.restitution < 1 && !start.setting.walls;
  const measured = smoothed(curve(samples, (s) => over(s, s.energy[1]), theme.newton, 2.5));
  const expected = smoothed(curve(samples, (s) => over(s, s.predicted[0]), theme.ink, 2, [6, 4]));
  const bound = (i: number): [number, number][] =>
    smoothed(curve(samples, (s) => over(s, s.predicted[i]), "")).points.filter(([, y]) => Number.isFinite(y));
  const all = [measured, expected].flatMap(({ points }) => points.map(([, y]) => y)).filter(Number.isFinite);
  const step =
    [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 100].find(
      (x) => Math.max(...all.map(Math.abs), 0) <= 2 * x,
    ) ?? 1e4;
  const [low, high] = [
    Math.min(...all, 0) < -0.02 * step ? -step * Math.ceil(-Math.min(...all) / step) : 0,
    step * Math.max(1, Math.ceil((1.5 * Math.max(...all, 0)) / step)),
  ];
  return {
    title: "Newton’s surplus of energy, %",
    y: (to, from) => new Scale(low, high, from, to),
    ticks: () => niceTicks(low, high, 4),
    name: (tick) => minus(String(Number((100 * tick).toPrecision(3)))),
    band: law ? [...bound(1), ...bound(2).reverse()] : [],
    curves: [{ ...measured, name: "this run" }, ...(law ? [{ ...expected, name: "law of the error" }] : [])],
  };
}

function distancePlot({ samples }: Facts, theme: GasTheme): Plot {
  const grows = divergenceOf(samples);
  const all = samples.map((s) => s.distance).filter((x) => x > 0);
  const high = 10 ** Math.max(1, Math.ceil(Math.log10(Math.max(...all, 1e-2))));
  const low = 10 ** Math.min(-3, Math.max(Math.floor(Math.log10(Math.min(...all, 1e-3))), -9));
  return {
    title: "distance of the worlds, diameters",
    y: (to, from) => new Scale(low, high, from, to, true),
    ticks: decades,
    name: power,
    curves: [
      { ...curve(samples, (s) => (s.distance > 0 ? s.distance : NaN), theme.muted, 2.5), name: "this run" },
      ...(grows
        ? [
            {
              ...curve(
                samples,
                (s) =>
                  s.collisions >= grows.from && s.collisions <= grows.to
                    ? grows.low * Math.exp(grows.rate * (s.collisions - grows.from))
                    : NaN,
                theme.ink,
                2,
                [6, 4],
              ),
              name: `${digits(grows.rate, 2)} per collision`,
            },
          ]
        : []),
    ],
  };
}

function sharePlot({ samples }: Facts, theme: GasTheme): Plot {
  const all = samples.map((s) => s.share).filter(Number.isFinite);
  const high = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1].find((x) => Math.max(...all, 0) <= 0.9 * x) ?? 1;
  return {
    title: "contacts that overlap, %",
    y: (to, from) => new Scale(0, high, from, to),
    ticks: () => niceTicks(0, high, 2),
    name: (tick) => digits(100 * tick, 2).replace(/\.0+$/, ""),
    curves: [curve(samples, (s) => s.share, theme.newton, 2.5)],
  };
}

const plots: { [G in Graph]: (facts: Facts, theme: GasTheme) => Plot } = {
  energy: energyPlot,
  difference: differencePlot,
  distance: distancePlot,
  share: sharePlot,
};

// `timed`: with numbers below the time axis.
export function drawGraph(
  g: CanvasRenderingContext2D,
  width: number,
  height: number,
  graph: Graph,
  facts: Facts,
  theme: GasTheme,
  timed: boolean,
): void {
  const plot = plots[graph](facts, theme);
  const size = fontSize(width);
  const frame: Frame = {
    left: 3.7 * size,
    top: 2.1 * size,
    width: width - 4.7 * size,
    height: height - (timed ? 5.1 : 3) * size,
  };
  g.clearRect(0, 0, width, height);
  if (frame.width < 20 || frame.height < 20) return;
  const end = Math.max(facts.sample.time, 60 * facts.start.base);
  const x = new Scale(0, end, frame.left, frame.left + frame.width);
  const y = plot.y(frame.top, frame.top + frame.height);
  const [factor, unit] = timeUnit(end);
  drawAxes(
    g,
    frame,
    x,
    y,
    timed ? { ...timeTicks(x, 0, factor, frame.width / (5 * size)), title: `time, ${unit}` } : null,
    { ticks: plot.ticks(y), name: plot.name, title: plot.title },
    theme,
    size,
  );
  g.save();
  g.beginPath();
  g.rect(frame.left, frame.top, frame.width, frame.height);
  g.clip();
  const across = (value: number): number => y.at(Math.max(value, y.low));
  if (plot.band && plot.band.length > 2) {
    g.globalAlpha = 0.16;
    g.fillStyle = theme.ink;
    g.beginPath();
    for (const [t, value] of plot.band) g.lineTo(x.at(t), across(value));
    g.fill();
    g.globalAlpha = 1;
  }
  const k = grown(size);
  for (const { points, color, width: line, dash } of plot.curves) {
    g.strokeStyle = color;
    g.lineWidth = line * k;
    g.setLineDash(dash);
    g.beginPath();
    let down = false;
    for (const [t, value] of points) {
      if (!Number.isFinite(value) || !Number.isFinite(t)) down = false;
      else if (down) g.lineTo(x.at(t), across(value));
      else {
        g.moveTo(x.at(t), across(value));
        down = true;
      }
    }
    g.stroke();
  }
  g.setLineDash([]);
  g.restore();
  const drawn = plot.curves.flatMap(({ points }) => points.map(([t, value]) => [x.at(t), across(value)]));
  named(g, plot, frame, theme, size, drawn);
}

// Legend in the corner with the fewest drawn points.
function named(
  g: CanvasRenderingContext2D,
  plot: Plot,
  frame: Frame,
  theme: GasTheme,
  size: number,
  drawn: number[][],
): void {
  const curves = plot.curves.filter(({ name }) => name);
  const dash = 1.9 * size;
  const room = frame.width - dash - 1.9 * size;
  const width = (): number => Math.max(0, ...curves.map(({ name }) => g.measureText(name!).width));
  setFont(g, theme, size, 600);
  if (width() > room) setFont(g, theme, (size * room) / width(), 600);
  g.textAlign = "left";
  g.textBaseline = "middle";
  const widest = width() + dash + 0.5 * size;
  const height = (1.3 * curves.length + 0.3) * size;
  const corners = [frame.left + frame.width - widest - 0.6 * size, frame.left + 0.8 * size].flatMap((left) =>
    [frame.top, frame.top + frame.height - height].map((top) => ({ left, top })),
  );
  const crossed = corners.map(
    ({ left, top }) => drawn.filter(([u, v]) => u > left && u < left + widest && v > top && v < top + height).length,
  );
  const { left, top } = corners[crossed.indexOf(Math.min(...crossed))];
  curves.forEach(({ name, color, dash: pattern, width }, i) => {
    const at = top + (0.8 + 1.3 * i) * size;
    g.fillStyle = color;
    g.fillText(name!, left + dash + 0.5 * size, at);
    g.strokeStyle = color;
    g.lineWidth = width;
    g.setLineDash(pattern);
    g.beginPath();
    g.moveTo(left, at);
    g.lineTo(left + dash, at);
    g.stroke();
    g.setLineDash([]);
  });
}
