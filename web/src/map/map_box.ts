// The part of the map that is shown: ε along x, gap [m] or R₁/R₂ along y, whose axis is logarithmic.
import type { Box } from "../scenario/view";

type Range = [number, number];

const log = ([low, high]: Range): Range => [Math.log(low), Math.log(high)];
const exp = ([low, high]: Range): Range => [Math.exp(low), Math.exp(high)];

// Zooms about a fixed point, within the limits of the map; a factor above 1 enlarges.
export function zoomed({ x, y }: Box, limits: Box, factor: number, [e, v]: [number, number]): Box {
  const part = ([low, high]: Range, at: number, [least, most]: Range): Range => {
    const inside = Math.min(Math.max(at, low), high);
    return [Math.max(inside - (inside - low) / factor, least), Math.min(inside + (high - inside) / factor, most)];
  };
  return { x: part(x, e, limits.x), y: exp(part(log(y), Math.log(Math.max(v, y[0])), log(limits.y))) };
}

// Moves by fractions of the frame, within the limits of the map.
export function panned({ x, y }: Box, limits: Box, right: number, up: number): Box {
  const shift = ([low, high]: Range, share: number, [least, most]: Range): Range => {
    const by = Math.min(Math.max(-share * (high - low), least - low), most - high);
    return [low + by, high + by];
  };
  return { x: shift(x, right, limits.x), y: exp(shift(log(y), up, log(limits.y))) };
}

export const tooSmall = ({ x, y }: Box): boolean => x[1] - x[0] < 1e-6 || y[1] / y[0] < 1 + 1e-6;

// Rounded to the digits of the link, so that the link reproduces the view.
export function linked({ x, y }: Box): Box {
  const keep = ([a, b]: Range): Range => [Number(a.toPrecision(6)), Number(b.toPrecision(6))];
  return { x: keep(x), y: keep(y) };
}
