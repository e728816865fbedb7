// Both simulations from the same initial state, advanced together, and their frames for the page. Runs in the worker.
import { GasCore, World, LOG_COLUMNS, type ErrorLaw, type Input, type Measured, type Observed } from "./core";
import { lawOf, type Law } from "./law";
import { MASS, RADIUS, RMS_SPEED, type Setting } from "./setting";

// Values that the setting determines.
export interface Start {
  setting: Setting;
  input: Input; // both engines start from it
  state: Float64Array; // positions (2n), velocities (2n)
  temperature: number; // [m²/s²]
  collisionRate: number; // Enskog's ν [1/s]
  contactDuration: number; // t_c [s]
  law: ErrorLaw;
  error: number; // of the cooling at the t_c ν of the start
  errorBar: number;
  trusted: number; // the largest t_c ν at which the error is at most TOLERANCE
  measured: Measured;
  tooSoft: number; // 0; if the disks are too soft to run, the largest t_c ν that is not
  compression: number; // of an impact at the mean speed, in radii
  base: number; // shortest time between frames [s]
  until: number; // time to which all starts are run [s]
  known: boolean; // whether the law of the error says something
  outside: string[]; // numbers that are outside the range of its measurements with friction
}
// Largest relative error of the cooling that counts as agreement.
export const TOLERANCE = 0.01;

// One simulation at one time.
export interface Seen {
  positions: Float32Array; // in the box [m]
  touched: Uint8Array; // 0: no contact since the last frame, 1: one, 2: contacts that overlap in time
  links: Int32Array; // pairs of disks whose contacts overlap
  observed: Observed;
  energy: number; // energy that is not dissipated, relative to the initial energy
  angles: Float32Array; // by which the disks have turned, for the picture; empty without friction
}
export interface Sample {
  time: number; // [s]
  collisions: number; // of each disk in the event-driven world
  energy: [number, number]; // NaN after the end of a simulation
  // Newton's energy by the law of the error, its lowest and its highest value; NaN if the law does not apply.
  predicted: [number, number, number];
  distance: number; // between both simulations [diameters]
  share: number; // fraction of Newton's contacts that overlap in time; NaN before the first contact has ended
  ratio: [number, number]; // T_r/T, temperature of the rotation over that of the translation; NaN without friction
}
export interface FrameOf {
  worlds: [Seen, Seen];
  sample: Sample;
  done: boolean;
  atRest: boolean; // the run has ended because Newton's disks are at rest
}

const most = 200; // collisions of each disk at which the film ends
const least = 1e-6; // energy at which the film ends, relative to the initial energy
const rest = 1e-3; // kinetic energy of disks at rest, relative to the initial energy

// Base time between frames: in 60 frames a disk collides 0.6 times or moves by half a diameter; in 400 frames it falls
// through the box.
const baseOf = (rate: number, { edge, gravity }: Input): number =>
  Math.max(0.6 / rate / 60, RADIUS / RMS_SPEED / 60, gravity < 0 ? Math.sqrt((2 * edge) / -gravity) / 400 : 0);

// Time at which each disk has collided `window` times by Haff's law, with Enskog's rate at the start [1/s].
const window = 10;
function untilOf(rate: number, { restitution }: Setting): number {
  const loss = (1 - restitution * restitution) / 4; // of the logarithm of √T for a collision of each disk
  return Number(((loss > 0 ? Math.expm1(loss * window) / loss : window) / rate).toPrecision(4));
}

function inputOf(core: GasCore, setting: Setting, rate: number): Input {
  const { number, phi, restitution, tcNu, rule, friction, stiffnessRatio } = setting;
  const contactDuration = tcNu / rate;
  const input: Input = {
    number,
    radius: RADIUS,
    mass: MASS,
    edge: Math.sqrt((number * Math.PI * RADIUS * RADIUS) / phi),
    periodic: !setting.walls,
    gravity: setting.gravity > 0 ? -setting.gravity : 0,
    rule,
    restitution,
    stiffness: 1,
    contactDuration,
    friction,
    stiffnessRatio,
  };
  core.set(input);
  return { ...input, stiffness: (core.duration / contactDuration) ** 2 };
}

// y = √(E(0)/E) over a rescaled time, extrapolated linearly.
class Stretched {
  private readonly times = [0];
  private readonly values = [1];
  private last = 1; // index of the first time that is not before the last requested one

  extend(by: number, y: number): void {
    this.times.push(this.times[this.times.length - 1] + by);
    this.values.push(y);
  }
  at(time: number): number {
    const { times, values } = this;
    if (time <= 0 || times.length < 2) return 1;
    while (this.last < times.length - 1 && times[this.last] < time) this.last++;
    const [t0, t1] = [times[this.last - 1], times[this.last]];
    const [y0, y1] = [values[this.last - 1], values[this.last]];
    return y0 + ((y1 - y0) / (t1 - t0)) * (time - t0);
  }
}

export class Simulation {
  readonly start: Start;
  private time = 0;
  private readonly initial: number; // energy [J]
  private readonly last: [Float64Array, Float64Array]; // last two collision times of each disk
  private stretchedAt: [number, number] = [0, 1]; // time and y at the last sample
  private before: number = 0; // time of the last frame
  readonly logs: [Float64Array[], Float64Array[]] = [[], []];

  constructor(
    private readonly core: GasCore,
    setting: Setting,
  ) {
    const { phi, restitution, rule, tcNu, number, seed, walls } = setting;
    this.law = lawOf(core, setting);
    const temperature = 0.5 * RMS_SPEED * RMS_SPEED;
    const collisionRate = core.rate(phi, 2 * RADIUS, temperature);
    const input = inputOf(core, setting, collisionRate);
    core.set(input);
    if (!core.place(seed)) throw new Error("No random places without overlap were found at this packing fraction.");
    core.heat(seed, RMS_SPEED);
    const [error, errorBar] = this.law.error(tcNu);
    const speed = Math.sqrt(Math.PI * temperature);
    // As in Python's check: compression of a pair in radii, of a wall contact in diameters.
    const compression = Math.min(
      core.compression(speed, false),
      walls ? 0.5 * core.compression(speed, true) : Infinity,
    );
    this.start = {
      setting,
      input,
      state: core.start,
      temperature,
      collisionRate,
      contactDuration: core.duration,
      law: core.law(phi, restitution, rule, this.law.added),
      known: this.law.known,
      outside: this.law.outside,
      error,
      errorBar,
      trusted: this.law.known ? core.largestTcNu(phi, restitution, rule, TOLERANCE, this.law.added) : NaN,
      measured: core.measured,
      tooSoft: compression < core.deepest ? 0 : (tcNu * core.deepest) / compression,
      compression,
      base: baseOf(collisionRate, input),
      until: untilOf(collisionRate, setting),
    };
    this.last = [new Float64Array(number).fill(-Infinity), new Float64Array(number).fill(-Infinity)];
    if (core.begin() !== 0) throw new Error("The core refuses this setting.");
    const { kinetic, potential, rotational } = core.observe(World.hard);
    this.initial = kinetic + potential + rotational;
  }
  private readonly law: Law;

  get now(): number {
    return this.time;
  }

  // Advances both simulations by a number of base times, but not beyond a later time `until`, and for at most `budget`
  // milliseconds. Returns whether the time was reached.
  // The film runs faster as the gas cools: by a factor of two for each factor of four in the energy.
  advance(steps: number, budget: number, until = 0): boolean {
    const begin = performance.now();
    this.target ||= Math.min(this.time + steps * this.start.base * this.pace, until > this.time ? until : Infinity);
    for (const world of [World.hard, World.newton])
      while (!this.core.advance(world, this.target, 500)) if (performance.now() - begin > budget) return false;
    this.time = this.target;
    this.target = 0;
    return true;
  }
  private target = 0;
  private pace = 1;

  // The last sample without the disks, for a start that is not shown.
  sample(): { sample: Sample; observed: [Observed, Observed] } {
    for (const world of [World.hard, World.newton]) this.core.log(world);
    const observed: [Observed, Observed] = [this.core.observe(World.hard), this.core.observe(World.newton)];
    return { sample: this.sampleOf(observed, NaN), observed };
  }

  // Advances both simulations to a time [s], for at most `budget` milliseconds. Returns whether it was reached.
  advanceTo(time: number, budget: number): boolean {
    const begin = performance.now();
    for (const world of [World.hard, World.newton])
      while (!this.core.advance(world, time, 500)) if (performance.now() - begin > budget) return false;
    this.time = time;
    return true;
  }

  private energyOf({ dissipated }: Observed): number {
    return 1 - dissipated / this.initial;
  }

  private sampleOf([hard, newton]: [Observed, Observed], distance: number): Sample {
    const over = [hard, newton].map(({ outcome, time }) => outcome !== 0 && time < this.time);
    const energies = [hard, newton].map((o) => this.energyOf(o));
    const { number, friction } = this.start.setting;
    const ratio = ({ rotational, kinetic }: Observed): number => (friction > 0 ? (2 * rotational) / kinetic : NaN);
    return {
      time: this.time,
      collisions: (2 * hard.pairs) / number,
      energy: [over[0] ? NaN : energies[0], over[1] ? NaN : energies[1]],
      predicted: this.predict(energies[0], over[0]),
      distance: over[0] || over[1] ? NaN : distance,
      share: newton.ended > 0 ? newton.overlapped / newton.ended : NaN,
      ratio: [over[0] ? NaN : ratio(hard), over[1] ? NaN : ratio(newton)],
    };
  }

  frame(): FrameOf {
    const hard = this.see(World.hard);
    const newton = this.see(World.newton);
    const { setting, base } = this.start;
    if (setting.gravity === 0)
      this.pace = 2 ** Math.min(Math.floor(Math.log2(Math.sqrt(1 / Math.max(newton.energy, 1e-12)))), 10);
    const ended = [hard, newton].map(({ observed }) => observed.outcome !== 0 && observed.time < this.time);
    const sample = this.sampleOf([hard.observed, newton.observed], this.distance());
    this.before = this.time;
    const atRest =
      setting.gravity > 0 &&
      newton.observed.kinetic + newton.observed.rotational < rest * this.initial &&
      newton.energy < 1 - rest;
    const done =
      atRest ||
      sample.collisions >= most ||
      newton.energy < least ||
      (ended[0] && ended[1]) ||
      this.time > 40_000 * base;
    return { worlds: [hard, newton], sample, done, atRest };
  }

  // The law gives e = (rate of the rule)/(rate of Newton's equations) − 1 for y = √(E(0)/E) at equal energies. Newton's
  // simulation therefore reaches an energy later by the factor 1 + e, and by half a contact duration, because no disks
  // touch initially.
  private predict(energy: number, ended: boolean): [number, number, number] {
    const { setting, contactDuration } = this.start;
    if (ended || setting.walls || !this.law.known) return [NaN, NaN, NaN];
    const y = 1 / Math.sqrt(energy);
    const [from, before] = this.stretchedAt;
    if (this.time > from) {
      const [error, bar] = this.law.error((2 * this.law.slower * setting.tcNu) / (y + before));
      this.curves.forEach((curve, i) => curve.extend((1 + error + [0, -bar, bar][i]) * (this.time - from), y));
    }
    this.stretchedAt = [this.time, y];
    return this.curves.map((curve, i) => curve.at(this.time - [0.5, 0.25, 0.75][i] * contactDuration) ** -2) as [
      number,
      number,
      number,
    ];
  }
  private readonly curves = [new Stretched(), new Stretched(), new Stretched()];

  private distance(): number {
    const n = 2 * this.start.setting.number;
    const hard = this.unwrapped[World.hard];
    const newton = this.unwrapped[World.newton];
    let sum = 0;
    for (let i = 0; i < n; i++) sum += (hard[i] - newton[i]) ** 2;
    return Math.sqrt((2 * sum) / n) / (2 * RADIUS);
  }
  private readonly unwrapped: Float64Array[] = [];
  private readonly angles: Float64Array[] = [];

  private see(world: World): Seen {
    const { number, walls } = this.start.setting;
    const { edge } = this.start.input;
    const state = this.core.state(world);
    this.unwrapped[world] = state;
    const positions = new Float32Array(2 * number);
    // The spin changes at contacts, of which there are few between two frames.
    const turned = (this.angles[world] ??= new Float64Array(state.length - 4 * number));
    turned.forEach((_, i) => (turned[i] += state[4 * number + i] * (this.time - this.before)));
    for (let i = 0; i < positions.length; i++)
      positions[i] = walls ? state[i] : state[i] - edge * Math.floor(state[i] / edge);
    const rows = this.core.log(world);
    if (rows.length > 0) this.logs[world].push(rows);
    const touched = new Uint8Array(number);
    const links: number[] = [];
    if (world === World.hard) this.markCollisions(rows, touched, links);
    else for (const list of [rows, this.core.log(world, true)]) markContacts(list, touched, links);
    const observed = this.core.observe(world);
    return {
      positions,
      touched,
      links: Int32Array.from(links),
      observed,
      energy: this.energyOf(observed),
      angles: Float32Array.from(turned),
    };
  }

  // Collisions are instantaneous. For comparison a disk is coloured for t_c after a collision, differently if it has
  // collided again within this time.
  private markCollisions(rows: Float64Array, touched: Uint8Array, links: number[]): void {
    const [last, previous] = this.last;
    const tc = this.start.contactDuration;
    const collided = (i: number, time: number): boolean => {
      previous[i] = last[i];
      last[i] = time;
      return last[i] - previous[i] < tc;
    };
    for (let row = 0; row < rows.length; row += LOG_COLUMNS) {
      const [time, , first, second] = rows.subarray(row, row + LOG_COLUMNS);
      const [a, b] = [collided(first, time), second >= 0 && collided(second, time)];
      if ((a || b) && second >= 0) links.push(first, second);
    }
    for (let i = 0; i < touched.length; i++) {
      if (this.time - last[i] >= tc && last[i] <= this.before) continue;
      touched[i] = last[i] - previous[i] < tc ? 2 : 1;
    }
  }
}

function markContacts(rows: Float64Array, touched: Uint8Array, links: number[]): void {
  for (let row = 0; row < rows.length; row += LOG_COLUMNS) {
    const [, , first, second, , , overlapped] = rows.subarray(row, row + LOG_COLUMNS);
    const mark = overlapped ? 2 : 1;
    touched[first] = Math.max(touched[first], mark);
    if (second >= 0) touched[second] = Math.max(touched[second], mark);
    if (overlapped && second >= 0) links.push(first, second);
  }
}
