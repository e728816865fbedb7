// The plots over time: energy; how much faster one world cools and how much more energy the other has; the
// temperature of the rotation; the distance of the worlds; the share of overlapping contacts.
import { divergenceOf } from "./divergence";
import { digits, logTicks, minus, niceTicks } from "../support/format";
import { Pen, type Frame } from "../support/pen";
import { drawAxes, fontSize, grown, Scale, timeTicks, timeUnit } from "../support/plot";
import { measureOf, type Facts } from "./facts";
import { INTERVALS, type OneStart } from "./starts";
import { at, cooling, differenceAt, predictedAt, remembered, spread, surplusAt, type Estimate } from "./statistics";
import type { Sample } from "./simulation";
import type { GasTheme } from "./worlds";

export const graphs = ["energy", "cooling", "surplus", "ratio", "distance", "share"] as const;
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
  bands?: Band[];
}
interface Band {
  points: [number, number][];
  color: string;
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

// The times of the samples of the starts.
const timesOf = ({ start }: Facts): number[] =>
  Array.from({ length: INTERVALS + 1 }, (_, k) => (k / INTERVALS) * start.until);

// The band between two curves.
const band = (low: [number, number][], high: [number, number][], color: string): Band => ({
  points: [...low, ...high.reverse()].filter(([, y]) => Number.isFinite(y)),
  color,
});

// Mean of a quantity over the starts, with the scatter of one start.
function meanOf(
  f: Facts,
  key: string,
  of: (s: OneStart) => readonly number[],
  color: string,
  name: string,
): [Curve, Band] {
  const times = timesOf(f);
  const spreads = remembered(f.starts, key, () => times.map((_, k) => spread(at(f.starts, of, k))));
  const line = (sign: number): [number, number][] =>
    spreads.map(({ mean, scatter }, k) => [times[k], mean + sign * scatter]);
  return [{ points: line(0), color, width: 2.5, dash: [], name }, band(line(-1), line(1), color)];
}

// Both worlds: means over the starts, and thin lines of the film.
function ofWorlds(f: Facts, theme: GasTheme, quantity: "energy" | "ratio"): { curves: Curve[]; bands: Band[] } {
  const all = ([0, 1] as const).map((world) => {
    const color = world === 0 ? theme.icm : theme.newton;
    const name = world === 0 ? "event-driven" : "Newton";
    const film = curve(f.samples, (s) => s[quantity][world], color, 1);
    if (f.starts.length < 2) return { film: { ...film, width: 2, name }, mean: null };
    return { film, mean: meanOf(f, `${quantity} ${world}`, (s) => s[quantity][world], color, name) };
  });
  return {
    curves: all.flatMap(({ film, mean }) => (mean ? [film, mean[0]] : [film])),
    bands: all.flatMap(({ mean }) => (mean ? [mean[1]] : [])),
  };
}

const startsInWords = ({ starts: { length } }: Facts): string =>
  length < 2 ? "this film" : `mean of ${length} starts`;

function energyPlot(f: Facts, theme: GasTheme): Plot {
  const { samples, start, starts } = f;
  const all = [...samples.flatMap((s) => s.energy), ...starts.flatMap((s) => s.energy.flat())];
  const lowest = Math.min(...all.filter((e) => e > 0), 1);
  const log = lowest < 0.1 && start.setting.gravity === 0;
  const low = log ? 10 ** Math.floor(Math.log10(lowest)) : 0;
  return {
    title: `energy left, ${startsInWords(f)}`,
    y: (to, from) => new Scale(low, 1, from, to, log),
    ticks: (y) => (log ? decades(y) : niceTicks(0, 1, 2)),
    name: (tick) => (log ? power(tick) : String(tick)),
    ...ofWorlds(f, theme, "energy"),
  };
}

// T_r/T of both worlds.
function ratioPlot(f: Facts, theme: GasTheme): Plot {
  const all = [...f.samples.flatMap((s) => s.ratio), ...f.starts.flatMap((s) => s.ratio.flat())];
  const high = Math.ceil(Math.max(...all.filter(Number.isFinite), 1.05) * 5) / 5;
  return {
    title: "rotation over translation, Tᵣ/T",
    y: (to, from) => new Scale(0, high, from, to),
    ticks: () => niceTicks(0, high, 2),
    name: (tick) => String(tick),
    ...ofWorlds(f, theme, "ratio"),
  };
}

// The mean difference of the worlds over the starts with its standard error and the scatter of one start; by the law of
// the error; of the film. Early values are large and uncertain: the axis is that of later ones.
function differencePlot(
  f: Facts,
  theme: GasTheme,
  title: string,
  estimate: (k: number) => Estimate | null,
  law: (k: number) => [number, number, number] | null,
  ofFilm: (s: Sample) => number,
): Plot {
  const times = timesOf(f);
  const points = (y: (k: number) => number): [number, number][] => times.map((t, k) => [t, y(k)]);
  const estimates = times.map((_, k) => estimate(k));
  const laws = times.map((_, k) => (f.start.known ? law(k) : null));
  const line = (by: (e: Estimate) => number): [number, number][] =>
    points((k) => (estimates[k] ? by(estimates[k]) : NaN));
  const lawLine = (i: number): [number, number][] => points((k) => laws[k]?.[i] ?? NaN);
  const measured: Curve = { points: line((e) => e.value), color: theme.newton, width: 2.5, dash: [] };
  const film = curve(f.samples, ofFilm, theme.newton, 1);
  const late = (all: [number, number][]): number[] =>
    all.filter(([t, y]) => t > 0.25 * f.start.until && Number.isFinite(y)).map(([, y]) => y);
  const all = [
    ...late(line((e) => e.value + e.scatter)),
    ...late(line((e) => e.value - e.scatter)),
    ...late(lawLine(0)),
  ];
  const [low, high] = rounded(all.length > 0 ? all : [usualDifference]);
  const known = f.starts.length > 1;
  return {
    title,
    y: (to, from) => new Scale(low, high, from, to),
    ticks: () => niceTicks(low, high, 4),
    name: (tick) => minus(String(Number((100 * tick).toPrecision(3)))),
    bands: [
      band(
        line((e) => e.value - e.scatter),
        line((e) => e.value + e.scatter),
        theme.newton,
      ),
      band(
        line((e) => e.value - e.error),
        line((e) => e.value + e.error),
        theme.newton,
      ),
      band(lawLine(1), lawLine(2), theme.ink),
    ],
    curves: [
      { ...film, ...(known ? {} : { width: 2, name: "this film" }) },
      ...(known ? [{ ...measured, name: "mean, ± standard error" }] : []),
      ...(late(lawLine(0)).length > 0
        ? [{ points: lawLine(0), color: theme.ink, width: 2, dash: [6, 4], name: "law of the error" }]
        : []),
    ],
  };
}

const usualDifference = 0.1; // the axis before there are values

// Limits of an axis that holds these values and 0.
function rounded(all: number[]): [number, number] {
  const size = Math.max(...all.map(Math.abs), 1e-3);
  const step =
    [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 100].find((x) => size <= 2 * x) ?? 1e4;
  const [low, high] = [Math.min(...all, 0), Math.max(...all, 0)];
  return [low < -0.02 * step ? -step * Math.ceil(-low / step) : 0, step * Math.max(1, Math.ceil(high / step))];
}

const coolingPlot = (f: Facts, theme: GasTheme): Plot => {
  const measure = measureOf(f);
  const title = {
    cooling: "rate: cools too fast by, %",
    loss: "rate: loses energy too fast by, %",
    contacts: "rate: collides too often by, %",
  }[measure];
  const ofFilm = (s: Sample): number =>
    measure === "contacts"
      ? NaN
      : measure === "loss"
        ? (1 - s.energy[0]) / (1 - s.energy[1]) - 1
        : cooling(s.energy[0]) / cooling(s.energy[1]) - 1;
  const law = (k: number): [number, number, number] | null =>
    measure === "cooling" ? (predictedAt(f.starts, k)?.cooling ?? null) : null;
  return differencePlot(f, theme, title, (k) => differenceAt(f.starts, measure, k), law, ofFilm);
};
const surplusPlot = (f: Facts, theme: GasTheme): Plot =>
  differencePlot(
    f,
    theme,
    "energy: Newton has more by, %",
    (k) => surplusAt(f.starts, k),
    (k) => predictedAt(f.starts, k)?.surplus ?? null,
    (s) => s.energy[1] / s.energy[0] - 1,
  );

function distancePlot({ samples }: Facts, theme: GasTheme): Plot {
  const grows = divergenceOf(samples);
  const all = samples.map((s) => s.distance).filter((x) => x > 0);
  const high = 10 ** Math.max(1, Math.ceil(Math.log10(Math.max(...all, 1e-2))));
  const low = 10 ** Math.min(-3, Math.max(Math.floor(Math.log10(Math.min(...all, 1e-3))), -9));
  return {
    title: "distance in the film, diameters",
    y: (to, from) => new Scale(low, high, from, to, true),
    ticks: decades,
    name: power,
    curves: [
      { ...curve(samples, (s) => (s.distance > 0 ? s.distance : NaN), theme.muted, 2.5), name: "this film" },
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
    title: "contacts that overlap, film, %",
    y: (to, from) => new Scale(0, high, from, to),
    ticks: () => niceTicks(0, high, 2),
    name: (tick) => digits(100 * tick, 2).replace(/\.0+$/, ""),
    curves: [curve(samples, (s) => s.share, theme.newton, 2.5)],
  };
}

const plots: { [G in Graph]: (facts: Facts, theme: GasTheme) => Plot } = {
  energy: energyPlot,
  cooling: coolingPlot,
  surplus: surplusPlot,
  ratio: ratioPlot,
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
  const end = Math.max(facts.sample.time, facts.start.until);
  const x = new Scale(0, end, frame.left, frame.left + frame.width);
  const y = plot.y(frame.top, frame.top + frame.height);
  const [factor, unit] = timeUnit(end);
  const pen = new Pen(g, theme, size);
  drawAxes(
    pen,
    frame,
    x,
    y,
    timed ? { ...timeTicks(x, 0, factor, frame.width / (5 * size)), title: `time, ${unit}` } : null,
    { ticks: plot.ticks(y), name: plot.name, title: plot.title },
  );
  // A logarithmic axis has no place for 0.
  const across = (value: number): number => y.at(y.log ? Math.max(value, y.low) : value);
  const pixels = (points: [number, number][]): [number, number][] =>
    points.map(([t, value]) => [x.at(t), across(value)]);
  const curves = plot.curves.map((curve) => ({ ...curve, points: pixels(curve.points) }));
  pen.within(frame, () => {
    for (const { points, color } of plot.bands ?? []) pen.area(pixels(points), color, 0.16);
    for (const { points, color, width, dash } of curves) pen.curve(points, color, width * grown(size), dash);
  });
  named(pen, curves, frame);
}

// Legend in the corner with the fewest drawn points, which it covers.
function named(pen: Pen, all: Curve[], frame: Frame): void {
  const { theme, size } = pen;
  const drawn = all.flatMap(({ points }) => points);
  const curves = all.filter(({ name }) => name);
  const dash = 1.9 * size;
  const room = frame.width - dash - 1.9 * size;
  const width = (): number => Math.max(0, ...curves.map(({ name }) => pen.widthOf(name!)));
  pen.font(1, 600);
  if (width() > room) pen.font(room / width(), 600);
  const widest = width() + dash + 0.5 * size;
  const height = (1.3 * curves.length + 0.3) * size;
  const corners = [frame.left + frame.width - widest - 0.6 * size, frame.left + 0.8 * size].flatMap((left) =>
    [frame.top, frame.top + frame.height - height].map((top) => ({ left, top })),
  );
  const crossed = corners.map(
    ({ left, top }) => drawn.filter(([u, v]) => u > left && u < left + widest && v > top && v < top + height).length,
  );
  const fewest = Math.min(...crossed);
  const { left, top } = corners[crossed.indexOf(fewest)];
  if (fewest > 0) pen.veil(left - 0.3 * size, top, widest + 0.6 * size, height, theme.ground, 0.8);
  curves.forEach(({ name, color, dash: pattern, width }, i) => {
    const at = top + (0.8 + 1.3 * i) * size;
    pen.text(name!, left + dash + 0.5 * size, at, color);
    pen.line(left, at, left + dash, at, color, width, pattern);
  });
}
