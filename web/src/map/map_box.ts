// The part of the map that is shown. `logs`: which of both axes are logarithmic.
import type { Box } from "../scenario/view";

type Range = [number, number];

type Logs = readonly [x: boolean, y: boolean];
const usual: Logs = [false, true]; // ε, and the gap or R₁/R₂

const log = ([low, high]: Range): Range => [Math.log(low), Math.log(high)];
const exp = ([low, high]: Range): Range => [Math.exp(low), Math.exp(high)];

// Changes a range on its own scale.
const onScale = (
  isLog: boolean,
  range: Range,
  limits: Range,
  change: (range: Range, limits: Range) => Range,
): Range => {
  if (!isLog) return change(range, limits);
  const changed = exp(change(log(range), log(limits)));
  return [Math.max(changed[0], limits[0]), Math.min(changed[1], limits[1])];
};

// Zooms about a fixed point, within the limits of the map; a factor above 1 enlarges.
export function zoomed(box: Box, limits: Box, factor: number, at: [number, number], logs = usual): Box {
  const part = (isLog: boolean, range: Range, at: number, limits: Range): Range =>
    onScale(isLog, range, limits, ([low, high], [least, most]) => {
      const inside = Math.min(Math.max(isLog ? Math.log(Math.max(at, range[0])) : at, low), high);
      return [Math.max(inside - (inside - low) / factor, least), Math.min(inside + (high - inside) / factor, most)];
    });
  return { x: part(logs[0], box.x, at[0], limits.x), y: part(logs[1], box.y, at[1], limits.y) };
}

// Moves by fractions of the frame, within the limits of the map.
export function panned({ x, y }: Box, limits: Box, right: number, up: number, logs = usual): Box {
  const shift = (isLog: boolean, range: Range, share: number, limits: Range): Range =>
    onScale(isLog, range, limits, ([low, high], [least, most]) => {
      const by = Math.min(Math.max(-share * (high - low), least - low), most - high);
      return [low + by, high + by];
    });
  return { x: shift(logs[0], x, right, limits.x), y: shift(logs[1], y, up, limits.y) };
}

export const tooSmall = ({ x, y }: Box): boolean => [x, y].some(([low, high]) => high - low < 1e-6 * high);

// Rounded to the digits of the link, so that the link reproduces the view.
export function linked({ x, y }: Box): Box {
  const keep = ([a, b]: Range): Range => [Number(a.toPrecision(6)), Number(b.toPrecision(6))];
  return { x: keep(x), y: keep(y) };
}
