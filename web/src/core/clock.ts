// Conversion between screen time and physical time: real time, slowed smoothly during contacts.
//
// Near a contact lasting microseconds the film must run 10⁴ times slower than in free fall. The film's speed is
//   rate(t) = min(1, min over contact windows of s + a · distance(t, window)),
// s the speed inside the window. A speed linear in t falls exponentially on the screen, so the eye sees an even
// slowing.
import type { Contact } from "./core";

export interface Window {
  begin: number;
  end: number;
  rate: number;
}

const slope = 7; // 1/s: how quickly the film slows down
const screenSeconds = 9; // for all contacts together

// Contacts that follow each other closely share a window.
export function windowsOf(contacts: Contact[], last: number): Window[] {
  const spans = contacts
    .map((c) => ({ begin: c.begin, end: Number.isFinite(c.end) ? c.end : last }))
    .sort((a, b) => a.begin - b.begin);
  const groups: { begin: number; end: number }[] = [];
  for (const span of spans) {
    const group = groups[groups.length - 1];
    if (group && span.begin - group.end < 2 * (group.end - group.begin)) group.end = Math.max(group.end, span.end);
    else groups.push({ ...span });
  }
  const lasting = groups.filter((g) => g.end > g.begin).slice(0, 3);
  const share = Math.max(screenSeconds / Math.max(lasting.length, 1), 3.5);
  return lasting.map((g) => {
    const pad = 0.06 * (g.end - g.begin);
    return { begin: g.begin - pad, end: g.end + pad, rate: Math.min(1, (g.end - g.begin) / share) };
  });
}

export class Clock {
  private readonly t: number[] = [];
  private readonly screen: number[] = [];

  constructor(
    readonly start: number,
    readonly stop: number,
    readonly windows: Window[],
  ) {
    const nodes = new Set<number>([start, stop]);
    const add = (x: number): void => void (x > start && x < stop && nodes.add(x));
    for (const w of windows) {
      add(w.begin);
      add(w.end);
      for (let d = w.rate / slope / 20; d < 1; d *= 1.15) {
        add(w.begin - d);
        add(w.end + d);
      }
    }
    for (let i = 1; i < 100; i++) add(start + ((stop - start) * i) / 100);
    this.t = [...nodes].sort((a, b) => a - b);
    this.screen = [0];
    for (let i = 1; i < this.t.length; i++) {
      const r0 = this.rate(this.t[i - 1]);
      const r1 = this.rate(this.t[i]);
      const mean = Math.abs(r1 / r0 - 1) < 1e-9 ? r0 : (r1 - r0) / Math.log(r1 / r0);
      this.screen.push(this.screen[i - 1] + (this.t[i] - this.t[i - 1]) / mean);
    }
  }

  get length(): number {
    return this.screen[this.screen.length - 1];
  }

  // Physical seconds per screen second.
  rate(t: number): number {
    let rate = 1;
    for (const w of this.windows) rate = Math.min(rate, w.rate + slope * Math.max(0, w.begin - t, t - w.end));
    return rate;
  }

  toPhysical(screen: number): number {
    return interpolate(this.screen, this.t, screen);
  }
  toScreen(t: number): number {
    return interpolate(this.t, this.screen, t);
  }
}

function interpolate(x: number[], y: number[], at: number): number {
  if (!(at > x[0])) return y[0];
  let low = 0;
  let high = x.length - 1;
  if (at >= x[high]) return y[high];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (x[middle] <= at) low = middle;
    else high = middle;
  }
  return y[low] + ((y[high] - y[low]) * (at - x[low])) / (x[high] - x[low]);
}
