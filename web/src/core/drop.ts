// One scenario solved by both models, with the data for the plots. solve() runs in a worker and returns
// plain data; Drop adds derived values.
import { Clock, windowsOf, type Window } from "./clock";
import { Model, failures, type Comparison, type Contact, type Core, type Run, type State } from "./core";
import { loneBall, type LoneBall } from "./lone_ball";
import { Motion, type Samples } from "./motion";
import { bandOf } from "./rises";
import { GRAVITY, type Scenario } from "../scenario/scenario";
import { usualTolerance } from "../scenario/tolerance";
import { independent as independentNames, newton as newtonNames } from "../scenario/tables";

export interface Track {
  run: Run; // the sequence of contacts
  shown: Contact[]; // contacts during the film
  final: State; // when the sequence is over
  leaves: number[]; // [n] velocities after the last contact [m/s]; NaN: at rest, or not known
  peaks: number[]; // [n] rebound heights of the centres; NaN: no bounce, or not resolved
  later: number[]; // [n] greatest heights after the first bounce while the film runs
  known: number; // end of the known motion [s]
  samples: Samples;
}

export interface Solved {
  scenario: Scenario;
  newton: Track;
  icm: Track;
  comparison: Comparison;
  start: number; // of the film: release [s]
  stop: number;
  origin: number; // zero of the times shown: first floor touch, or first contact of a cradle
  from: number; // span of the contacts
  to: number;
  windows: Window[]; // time windows of slow motion
  times: Float64Array; // samples of the forces below
  forces: Float64Array[]; // [pair][time]
  peakForce: number[]; // [pair]
  compression: number[]; // [pair] largest [m]
  lone: LoneBall | null; // the lowest ball without the others; null: it stays on the floor, or there is none
  meets: number; // velocity of the lowest ball, upwards, as balls first touch [m/s]; NaN: they do not
  band: [number, number] | null; // Newton's heights of the top ball for half and twice the stiffness, if unmeasured
  bottom: number; // extent of the true-scale picture along the line [m]
  top: number;
}

// Results before the film is computed; those of Newton's equations come first.
export interface Answered {
  scenario: Scenario;
  newton: Track;
  icm: Track | null; // null: not yet
  comparison: Comparison | null;
}

export interface Unsolved {
  scenario: Scenario;
  reason: string;
}

export interface Drop extends Solved {
  clock: Clock; // slow through the contacts
  readonly realTime: Clock;
  motion: { newton: Motion; icm: Motion };
}

export function dropOf(s: Solved): Drop {
  let real: Clock | null = null; // created on demand: most films are slow in the contacts
  return {
    ...s,
    clock: new Clock(s.start, s.stop, s.windows),
    get realTime() {
      return (real ??= new Clock(s.start, s.stop, []));
    },
    motion: { newton: new Motion(s.newton.samples), icm: new Motion(s.icm.samples) },
  };
}

const greatest = (values: Iterable<number>, least: number): number => {
  let most = least;
  for (const x of values) if (x > most) most = x;
  return most;
};

function sequence(core: Core, model: Model): Track | null {
  const run = core.solve(model);
  if (!run || !Number.isFinite(run.last) || run.outcome === failures.invalid || run.outcome === failures.neverLands)
    return null;
  const [final] = core.sample(model, [run.last]);
  const samples = { times: new Float64Array(), rows: new Float64Array(), balls: final.position.length };
  return {
    run,
    shown: run.contacts,
    final,
    leaves: core.finalVelocities(model),
    peaks: core.reboundHeights(model),
    later: [],
    known: run.last,
    samples,
  };
}

// Time at which every ball has reached its rebound height, on a cradle a distance; at most three seconds after the
// sequence.
function endOfFilm(s: Scenario, t: Track): number {
  const { position, velocity } = t.final;
  if (s.cradle) return t.run.last + (6 * s.balls[0].radius) / greatest(velocity.map(Math.abs), 1e-3);
  const flights = t.peaks.map((z, i) => Math.sqrt((2 * Math.max(z - position[i], 0)) / GRAVITY));
  return t.run.last + Math.min(greatest([...flights, ...velocity.map((v) => v / GRAVITY)], 0.15), 3);
}

// Continues a run after the sequence to the end of the film, or as far as the model goes. Independent collisions can
// accumulate repeatedly; a film shows at most this number.
const mostEvents = 10_000;

function goOn(core: Core, model: Model, t: Track, stop: number): void {
  const longer = core.solve(model, stop, t.run.events + mostEvents);
  if (!longer || !(longer.last >= t.run.last)) return void core.solve(model);
  t.shown = longer.contacts;
  t.known = longer.last;
}

// Greatest heights after the first bounce in the samples. A ball that turns between two samples is in flight.
function laterHeights(t: Track): number[] {
  const { times, rows, balls: n } = t.samples;
  const size = rows.length / times.length;
  return Array.from({ length: n }, (_, i) => {
    const bounce = t.shown.find((c) => c.pair === i && c.end >= 0)?.end ?? Infinity;
    let most = NaN;
    for (let k = times.findIndex((time) => time >= bounce); k >= 0 && k < times.length; k++) {
      const [z, v] = [rows[k * size + i], rows[k * size + n + i]];
      const turns = v > 0 && k + 1 < times.length && rows[(k + 1) * size + n + i] < 0;
      const top = turns && v < 2 * GRAVITY * (times[k + 1] - times[k]) ? z + (v * v) / (2 * GRAVITY) : z;
      if (!(top <= most)) most = top;
    }
    return most;
  });
}

const quick = 30; // within this time [ms] only Newton's result and the complete one are reported

// `report` receives the name of each stage, its share of the work and what is known by then.
type Report = (what: string, share: number, known: Answered | null) => void;
export function solve(
  core: Core,
  scenario: Scenario,
  tolerance = usualTolerance,
  report: Report = () => {},
): Solved | Unsolved {
  const begin = performance.now();
  const later = (what: string, share: number, known: Answered | null): void =>
    void (performance.now() - begin > quick && report(what, share, known));
  const lone = loneBall(core, scenario); // first, because the core keeps the last runs
  const band = bandOf(core, scenario);
  core.set(scenario);
  const newton = sequence(core, Model.newton);
  const known = newton && { scenario, newton, icm: null, comparison: null };
  report(independentNames.label, 0.3, known);
  const icm = newton && sequence(core, Model.independent);
  if (!newton || !icm) return { scenario, reason: "These balls never meet the floor." };
  const comparison = core.compare(tolerance);
  const both = { scenario, newton, icm, comparison };
  later(`the film by ${newtonNames.label}`, 0.5, both);
  const stop = Math.max(endOfFilm(scenario, newton), endOfFilm(scenario, icm));
  goOn(core, Model.newton, newton, stop);
  later(`the film by ${independentNames.label}`, 0.75, both);
  goOn(core, Model.independent, icm, stop);
  later("the film’s pictures", 0.9, both);
  const contacts = newton.run.contacts.filter((c) => c.begin <= newton.run.last);
  const endOf = (c: Contact): number => (Number.isFinite(c.end) ? c.end : newton.run.last);
  const first = contacts.reduce((a, c) => Math.min(a, c.begin), contacts.length > 0 ? Infinity : 0);
  const from = scenario.cradle ? first : Math.min(0, first);
  const span = contacts.reduce((a, c) => Math.max(a, endOf(c)), from + 1e-9) - from;
  // Independent collisions that come much later are left out: they would compress Newton's contacts to a line.
  const instants = icm.run.contacts.filter((c) => c.begin <= from + 1.5 * span);
  const solved: Solved = {
    scenario,
    newton,
    icm,
    comparison,
    stop,
    from,
    start: newton.run.first,
    origin: scenario.cradle ? first : 0,
    to: instants.reduce((a, c) => Math.max(a, c.begin), from + span),
    windows: windowsOf(contacts, newton.run.last).filter((w) => w.begin < stop),
    times: new Float64Array(),
    forces: [],
    peakForce: [],
    compression: [],
    lone,
    meets: meetingOf(core, newton.run),
    band,
    bottom: 0,
    top: 0,
  };
  sampleForces(core, solved, contacts);
  sampleFilm(core, solved);
  return solved;
}

function meetingOf(core: Core, { contacts }: Run): number {
  const touch = contacts.reduce((a, { pair, begin }) => (pair > 0 ? Math.min(a, begin) : a), Infinity);
  return touch < Infinity ? core.sample(Model.newton, Float64Array.of(touch))[0].velocity[0] : NaN;
}

const edges = (c: Contact, edge: number, last: number): number[] => {
  const end = Number.isFinite(c.end) ? c.end : last;
  return [c.begin - edge, c.begin + edge, end - edge, end + edge];
};

function sampleForces(core: Core, d: Solved, contacts: Contact[]): void {
  const n = d.scenario.balls.length;
  const span = d.to - d.from;
  const low = d.from - 0.06 * span;
  const high = d.to + 0.08 * span;
  const times = new Set<number>();
  const count = 480;
  for (let i = 0; i <= count; i++) times.add(low + ((high - low) * i) / count);
  const inside = Math.max(Math.floor(2400 / Math.max(contacts.length, 100)), 2);
  for (const c of contacts) {
    const end = Number.isFinite(c.end) ? c.end : d.to;
    for (const t of edges(c, 1e-9 * span, d.to)) times.add(t);
    for (let i = 1; i < inside; i++) times.add(c.begin + ((end - c.begin) * i) / inside);
  }
  d.times = Float64Array.from(times)
    .filter((t) => t >= low && t <= high)
    .sort();
  const rows = core.rows(Model.newton, d.times);
  const size = rows.length / d.times.length;
  for (let j = 0; j < n; j++) {
    const [gap, force] = [2 * n + j, 3 * n + j].map((at) => d.times.map((_, i) => rows[i * size + at]));
    d.forces.push(force.map((f) => (Number.isFinite(f) ? f : 0)));
    d.peakForce.push(greatest(d.forces[j], 0));
    d.compression.push(-gap.reduce((a, b) => Math.min(a, b), 0));
  }
}

const mostEdges = 3000; // more contacts are closer together than frames
const mostPictures = 20_000; // of slow balls; the motion between them is interpolated

// Sixty states for each second on the screen, more in contacts that are short on the screen, and both sides of every
// begin and end.
function sampleFilm(core: Core, d: Solved): void {
  const clock = new Clock(d.start, d.stop, d.windows);
  const count = Math.min(Math.ceil(60 * clock.length), mostPictures);
  const even = Array.from({ length: count + 1 }, (_, i) => clock.toPhysical((i / count) * clock.length));
  const inside = Math.max(Math.floor(1200 / Math.max(d.newton.run.contacts.length, 100)), 2);
  for (const [model, t] of [
    [Model.newton, d.newton],
    [Model.independent, d.icm],
  ] as const) {
    const times = new Set<number>([...even, t.known]);
    for (const c of t.shown.slice(0, mostEdges)) {
      const edge = 4 * Number.EPSILON * Math.max(Math.abs(c.begin), Math.abs(d.start));
      for (const time of edges(c, edge, t.known)) times.add(time);
      if (model === Model.newton && c.begin <= t.run.last)
        for (let i = 1; i < inside; i++) times.add(c.begin + ((c.end - c.begin) * i) / inside);
    }
    const sorted = Float64Array.from(times)
      .filter((time) => time >= d.start && time <= Math.min(t.known, d.stop))
      .sort();
    t.samples = { times: sorted, rows: core.rows(model, sorted), balls: d.scenario.balls.length };
    t.later = d.scenario.cradle ? [] : laterHeights(t);
  }
  findExtent(d);
}

function findExtent(d: Solved): void {
  const { balls, cradle } = d.scenario;
  d.bottom = cradle ? Infinity : 0;
  for (const {
    samples: { rows, times },
  } of [d.newton, d.icm]) {
    const size = rows.length / times.length;
    for (let at = 0; at < rows.length; at += size) {
      if (cradle) d.bottom = Math.min(d.bottom, rows[at] - balls[0].radius);
      balls.forEach((b, i) => (d.top = Math.max(d.top, rows[at + i] + b.radius)));
    }
  }
}
