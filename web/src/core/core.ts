// Interface to the compiled core. Data layouts are those of bindings/wasm.cpp.
import { columnOf, type Scenario } from "../scenario/scenario";

interface Exports {
  memory: WebAssembly.Memory;
  column_buffer(): number;
  reply_buffer(): number;
  scratch(n: number): number;
  solve(model: number, until: number, mostEvents: number): number;
  contacts_of(model: number, out: number): void;
  row_size(): number;
  sample(model: number, n: number, times: number, out: number): void;
  rebound_heights(model: number, out: number): void;
  final_velocities(model: number, out: number): void;
  compare_models(tolerance: number): void;
  agreement_gaps(n: number, restitution: number, low: number, high: number, tolerance: number, out: number): void;
  scan_points(axis: number, n: number, points: number, out: number): void;
  scan_timeline(model: number, n: number, restitution: number, out: number, room: number): number;
  outcome_message(outcome: number): number;
}

export enum Model {
  newton = 0,
  adiabatic = 1,
  independent = 2,
}

export interface Contact {
  pair: number; // 0: floor and lowest ball
  begin: number; // s after the first floor touch (cradle: after release)
  end: number; // NaN: never, or not before the run stopped
}

export interface Run {
  outcome: number;
  message: string; // of the outcome
  nContacts: number;
  tEnd: number;
  tFloorEnd: number;
  relativeVelocity: number;
  separationVelocity: number;
  first: number;
  last: number;
  events: number; // contacts that were followed
  impactSpeed: number;
  effective: number; // ε_eff at the end of the sequence
  effectiveSeparation: number;
  largestCompression: number; // over the smaller radius; NaN: instantaneous collisions
  tooDeep: number; // pair whose compression ended the run; −1: none
  meetsAgain: boolean; // upper balls still approach each other when the lowest is back on the floor
  contacts: Contact[]; // the first MOST_CONTACTS
}

// In the order of Answer and Ground in core/column/comparison.hpp.
export const answers = ["yes", "by luck", "no", "undecided"] as const;
const grounds = [
  "numbers",
  "newton-unclear",
  "independent-unclear",
  "no-contact",
  "newton-at-rest",
  "collapse",
  "independent-at-rest",
  "only-newton-meets",
  "only-independent-meets",
  "newton-touches-again",
  "independent-touches-again",
] as const;

// Whether independent collisions agree with Newton's equations, and why.
export interface Comparison {
  answer: (typeof answers)[number];
  ground: (typeof grounds)[number];
  overlapping: number; // ball–ball contacts that overlap another contact in time
  error: number; // relative difference of the velocities; NaN: there is none
  independent: number; // the velocities compared [m/s]
  newton: number;
  ball: number; // whose final velocity is compared; −1: the separation velocity
  later: boolean; // contacts after the second floor contact count
  tolerance: number; // largest error that counts as agreement
}

// Plots show no more; a collapse of instantaneous collisions has up to a million.
const MOST_CONTACTS = 20_000;

// One state of n balls, bottom first.
export interface State {
  position: Float64Array; // of the centres [m]
  velocity: Float64Array; // upwards [m/s]
  gap: Float64Array; // floor first [m]
  force: Float64Array; // floor first [N]
  energy: Float64Array; // kinetic and potential, of each ball [J]
  stored: number; // in the contacts [J]
  dissipated: number; // so far [J]
}

// A copy of one row of the core's output.
export function stateOf(row: Float64Array, n: number): State {
  const part = (k: number): Float64Array => row.slice(k * n, (k + 1) * n);
  return {
    position: part(0),
    velocity: part(1),
    gap: part(2),
    force: part(3),
    energy: part(4),
    stored: row[5 * n],
    dissipated: row[5 * n + 1],
  };
}

// One row of the timeline, for one ε.
export interface TimelineRow {
  restitution: number;
  nContacts: number;
  tEnd: number;
  tFloorEnd: number;
  contacts: Contact[];
}

// Of Outcome in core/base/outcome.hpp.
export const failures = { invalid: 3, unresolved: 5, neverLands: 6, tooDeep: 7 };

export const SCAN_VALUES = 3; // contacts, ε_eff/ε at t_f, ε_eff/ε at separation

export class Core {
  private readonly x: Exports;
  private balls = 0;

  constructor(module: WebAssembly.Module) {
    this.x = new WebAssembly.Instance(module, {}).exports as unknown as Exports;
  }

  // Memory may move when the module grows, so views are created for each use.
  private view(pointer: number, n: number): Float64Array {
    return new Float64Array(this.x.memory.buffer, pointer, n);
  }

  setColumn(column: Float64Array): void {
    this.view(this.x.column_buffer(), column.length).set(column);
    this.balls = column[2];
  }

  set(scenario: Scenario): void {
    this.setColumn(columnOf(scenario));
  }

  // `mostEvents`: limit on independent collisions; 0: that of Python.
  solve(model: Model, until = NaN, mostEvents = 0): Run | null {
    if (!this.x.solve(model, until, mostEvents)) return null;
    const r = this.view(this.x.reply_buffer(), 15).slice();
    const n = r[8];
    const pointer = this.x.scratch(3 * n + 1);
    this.x.contacts_of(model, pointer);
    const flat = this.view(pointer, 3 * n);
    const contacts: Contact[] = [];
    for (let i = 0; i < Math.min(n, MOST_CONTACTS); i++)
      contacts.push({ pair: flat[3 * i], begin: flat[3 * i + 1], end: flat[3 * i + 2] });
    return {
      outcome: r[0],
      message: this.message(r[0]),
      nContacts: r[1],
      tEnd: r[2],
      tFloorEnd: r[3],
      relativeVelocity: r[4],
      separationVelocity: r[5],
      first: r[6],
      last: r[7],
      events: n,
      impactSpeed: r[9],
      effective: r[10],
      effectiveSeparation: r[11],
      largestCompression: r[12],
      tooDeep: r[13],
      meetsAgain: r[14] !== 0,
      contacts,
    };
  }

  // States of the last run of this model, one row each; times outside it are moved to its ends.
  rows(model: Model, times: ArrayLike<number>): Float64Array {
    const n = times.length;
    const size = this.x.row_size();
    const pointer = this.x.scratch(n * (size + 1));
    this.view(pointer, n).set(times);
    this.x.sample(model, n, pointer, pointer + 8 * n);
    return this.view(pointer + 8 * n, n * size).slice();
  }

  sample(model: Model, times: ArrayLike<number>): State[] {
    const size = this.x.row_size();
    const rows = this.rows(model, times);
    return Array.from({ length: times.length }, (_, i) => stateOf(rows.subarray(i * size, (i + 1) * size), this.balls));
  }

  // How high the centres rise in the last run of this model [m]; NaN where there is no bounce, and for a cradle.
  reboundHeights(model: Model): number[] {
    const pointer = this.x.scratch(this.balls);
    this.x.rebound_heights(model, pointer);
    return Array.from(this.view(pointer, this.balls));
  }

  // Velocities of the balls after their last contact in the last run of this model [m/s]; NaN where there are none.
  finalVelocities(model: Model): number[] {
    const pointer = this.x.scratch(this.balls);
    this.x.final_velocities(model, pointer);
    return Array.from(this.view(pointer, this.balls));
  }

  // Compares the last runs by Newton's equations and by independent collisions.
  compare(tolerance: number): Comparison {
    this.x.compare_models(tolerance);
    const r = this.view(this.x.reply_buffer(), 8);
    return {
      answer: answers[r[0]],
      ground: grounds[r[1]],
      overlapping: r[2],
      error: r[3],
      independent: r[4],
      newton: r[5],
      ball: r[6],
      later: r[7] !== 0,
      tolerance,
    };
  }

  // For each ε the gap from which on both models agree, up to `high` [m]; infinite: not even there.
  agreementGaps(restitution: number[], low: number, high: number, tolerance: number): Float64Array {
    const n = restitution.length;
    const pointer = this.x.scratch(2 * n);
    this.view(pointer, n).set(restitution);
    this.x.agreement_gaps(n, pointer, low, high, tolerance, pointer + 8 * n);
    return this.view(pointer + 8 * n, n).slice();
  }

  // (ε, y) pairs → SCAN_VALUES numbers each.
  scan(axis: number, points: Float64Array): Float64Array {
    const n = points.length / 2;
    const pointer = this.x.scratch(points.length + SCAN_VALUES * n);
    this.view(pointer, points.length).set(points);
    const out = pointer + 8 * points.length;
    this.x.scan_points(axis, n, pointer, out);
    return this.view(out, SCAN_VALUES * n).slice();
  }

  timeline(model: Model, restitution: number[]): TimelineRow[] {
    const n = restitution.length;
    for (let room = n * 200 + 1000; ; room *= 2) {
      const pointer = this.x.scratch(n + room);
      this.view(pointer, n).set(restitution);
      const used = this.x.scan_timeline(model, n, pointer, pointer + 8 * n, room);
      const rows = readTimeline(this.view(pointer + 8 * n, used), restitution);
      if (rows.length === n) return rows;
    }
  }

  private message(outcome: number): string {
    const bytes = new Uint8Array(this.x.memory.buffer, this.x.outcome_message(outcome));
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }
}

function readTimeline(d: Float64Array, restitution: number[]): TimelineRow[] {
  const rows: TimelineRow[] = [];
  for (let at = 0; at < d.length;) {
    const row: TimelineRow = {
      restitution: restitution[rows.length],
      nContacts: d[at],
      tEnd: d[at + 1],
      tFloorEnd: d[at + 2],
      contacts: [],
    };
    const count = d[at + 3];
    at += 4;
    for (let i = 0; i < count; i++, at += 3) row.contacts.push({ pair: d[at], begin: d[at + 1], end: d[at + 2] });
    rows.push(row);
  }
  return rows;
}
