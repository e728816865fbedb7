// One scenario solved by both models, and what the pictures need of it.
import { Clock, windowsOf } from "./clock";
import { Model, type Contact, type Core, type Run, type State } from "./core";
import { GRAVITY, type Scenario } from "./scenario";

export interface Track {
  run: Run; // the sequence of contacts
  shown: Contact[]; // contacts while the animation runs
  final: State; // when the sequence is over
  peaks: number[]; // [n] height each centre then rises to
  initialEnergy: number;
}

export interface Drop {
  scenario: Scenario;
  newton: Track;
  icm: Track;
  start: number; // of the animation: release [s]
  stop: number;
  origin: number; // zero of the times shown: first floor touch, or first contact of a cradle
  from: number; // span of the contacts
  to: number;
  clock: Clock; // slow through the contacts
  realTime: Clock;
  times: number[]; // samples of the forces below
  forces: number[][]; // [pair][time]
  peakForce: number[]; // [pair]
  compression: number[]; // [pair] largest [m]
  bottom: number; // extent of the true-scale picture along the line [m]
  top: number;
}

export interface Unsolved {
  scenario: Scenario;
  reason: string;
}

const outcomes = { invalid: 3, collapse: 4, unresolved: 5, neverLands: 6 };

function track(core: Core, model: Model, s: Scenario): Track | null {
  const run = core.solve(model);
  if (!run || !Number.isFinite(run.last) || run.outcome === outcomes.invalid || run.outcome === outcomes.neverLands) return null;
  const [initial, final] = core.sample(model, [run.first, run.last]);
  const peaks = Array.from(final.position, (z, i) => {
    const v = final.velocity[i];
    return s.cradle || v <= 0 ? z : z + (v * v) / (2 * GRAVITY);
  });
  return { run, shown: run.contacts, final, peaks, initialEnergy: initial.energy.reduce((a, b) => a + b, 0) + initial.stored };
}

// When the fastest ball is at its highest point, or has gone far enough on a cradle.
function endOfFilm(s: Scenario, t: Track): number {
  const speeds = Array.from(t.final.velocity);
  if (s.cradle) {
    const fastest = Math.max(...speeds.map(Math.abs), 1e-3);
    return t.run.last + (6 * s.balls[0].radius) / fastest;
  }
  const rise = Math.max(...speeds, 0) / GRAVITY;
  return t.run.last + Math.min(Math.max(rise, 0.15), 3);
}

export function solve(core: Core, scenario: Scenario): Drop | Unsolved {
  core.set(scenario);
  const newton = track(core, Model.newton, scenario);
  const icm = track(core, Model.independent, scenario);
  if (!newton || !icm) return { scenario, reason: "These balls never meet the floor." };
  let stop = Math.max(endOfFilm(scenario, newton), endOfFilm(scenario, icm));
  for (const [model, t] of [[Model.newton, newton], [Model.independent, icm]] as const) {
    const longer = core.solve(model, stop);
    if (longer && longer.outcome !== outcomes.unresolved && longer.outcome !== outcomes.collapse) t.shown = longer.contacts;
    else stop = Math.min(stop, core.solve(model)?.last ?? stop);
  }
  const start = newton.run.first;
  const sequence = newton.run.contacts.filter((c) => c.begin <= newton.run.last);
  const known = [...sequence, ...icm.run.contacts.filter((c) => c.begin <= Math.max(newton.run.last, icm.run.last))];
  const ends = known.map((c) => (Number.isFinite(c.end) ? c.end : newton.run.last));
  const first = Math.min(...known.map((c) => c.begin));
  const from = scenario.cradle ? first : Math.min(0, first);
  const origin = scenario.cradle ? first : 0;
  const to = Math.max(...ends, from + 1e-9);
  const windows = windowsOf(known, newton.run.last).filter((w) => w.end < stop);
  const drop: Drop = {
    scenario, newton, icm, start, stop, origin, from, to,
    clock: new Clock(start, stop, windows),
    realTime: new Clock(start, stop, []),
    times: [], forces: [], peakForce: [], compression: [], bottom: 0, top: 0,
  };
  sampleForces(core, drop, sequence);
  findExtent(core, drop);
  return drop;
}

function sampleForces(core: Core, d: Drop, contacts: Contact[]): void {
  const n = d.scenario.balls.length;
  const span = d.to - d.from;
  const low = d.from - 0.06 * span;
  const high = d.to + 0.08 * span;
  const times = new Set<number>();
  const count = 480;
  for (let i = 0; i <= count; i++) times.add(low + ((high - low) * i) / count);
  const edge = 1e-9 * span;
  for (const c of contacts) {
    const end = Number.isFinite(c.end) ? c.end : d.to;
    for (const t of [c.begin - edge, c.begin + edge, end - edge, end + edge]) times.add(t);
    for (let i = 1; i < 24; i++) times.add(c.begin + ((end - c.begin) * i) / 24);
  }
  d.times = [...times].filter((t) => t >= low && t <= high).sort((a, b) => a - b);
  const states = core.sample(Model.newton, d.times);
  for (let j = 0; j < n; j++) {
    d.forces.push(states.map((s) => (Number.isFinite(s.force[j]) ? s.force[j] : 0)));
    d.peakForce.push(d.forces[j].reduce((a, b) => Math.max(a, b), 0));
    d.compression.push(states.reduce((a, s) => Math.max(a, -s.gap[j]), 0));
  }
}

function findExtent(core: Core, d: Drop): void {
  const n = d.scenario.balls.length;
  const radius = (i: number): number => d.scenario.balls[i].radius;
  const times = Array.from({ length: 60 }, (_, i) => d.start + ((d.stop - d.start) * i) / 59);
  d.bottom = d.scenario.cradle ? Infinity : 0;
  d.top = 0;
  for (const model of [Model.newton, Model.independent]) {
    for (const s of core.sample(model, times)) {
      if (d.scenario.cradle) d.bottom = Math.min(d.bottom, s.position[0] - radius(0));
      for (let i = 0; i < n; i++) d.top = Math.max(d.top, s.position[i] + radius(i));
    }
  }
}
