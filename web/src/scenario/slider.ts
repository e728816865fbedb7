// Positions of sliders: even steps on a linear scale, a thousand on a logarithmic one.
import { clampTo, type Range } from "./scenario";

export const steps = (r: Range): number => (r.log ? 1000 : Math.round((r.high - r.low) / (r.step ?? 0.001)));

// Sliders are logarithmic where the range is; values are rounded to a few digits.
export function fromSlider(r: Range, at: number): number {
  if (r.zero && at === 0) return 0;
  const share = at / steps(r);
  const x = r.log ? r.low * (r.high / r.low) ** share : r.low + (r.high - r.low) * share;
  return clampTo(r, Number(r.log ? x.toPrecision(3) : x.toFixed(3)));
}

export function toSlider(r: Range, x: number): number {
  if (r.zero && x === 0) return 0;
  const share = r.log ? Math.log(x / r.low) / Math.log(r.high / r.low) : (x - r.low) / (r.high - r.low);
  return Math.round(steps(r) * Math.min(Math.max(share, 0), 1));
}
