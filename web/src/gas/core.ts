// Interface to the compiled gas. Data layouts are those of bindings/wasm_gas.cpp.
interface Exports {
  memory: WebAssembly.Memory;
  gas_setting(n: number): number;
  gas_fields(): number;
  gas_place(seed: number): number;
  gas_heat(seed: number, rms: number): void;
  gas_duration(): number;
  gas_compression(speed: number, wall: number): number;
  gas_deepest(): number;
  gas_start(): number;
  gas_advance(world: number, until: number, work: number): number;
  gas_observe(world: number): number;
  gas_state(world: number): number;
  gas_take_log(world: number, open: number): number;
  gas_log(): number;
  gas_outcome(outcome: number): number;
  gas_rule(index: number): number;
  law_rate(phi: number, diameter: number, temperature: number): number;
  law_fluid(phi: number): number;
  law_of_error(phi: number, restitution: number, rule: number, ...added: Added): number;
  law_errors(phi: number, restitution: number, rule: number, ...rest: [...Added, tcNu: number]): number;
  law_largest(phi: number, restitution: number, rule: number, ...rest: [...Added, error: number]): number;
  law_measured(): number;
}

// What friction adds to the coefficient of the law of the error, its standard error, and the factor by which the error
// bar is wider outside the range of the measurements.
export type Added = [coefficient: number, bar: number, wider: number];
const nothing: Added = [0, 0, 1];

export enum World {
  hard = 0,
  newton = 1,
}

// What both engines start from, in SI units and in the order of `Field` in bindings/wasm_gas.cpp.
export interface Input {
  number: number;
  radius: number;
  mass: number;
  edge: number;
  periodic: boolean;
  gravity: number; // along y, ≤ 0
  rule: string;
  restitution: number;
  stiffness: number;
  contactDuration: number; // of the rule tc
  friction: number; // μ
  stiffnessRatio: number; // k_t/k_n
}

// In the order of gas_observe in bindings/wasm_gas.cpp.
const observed = [
  "time", // [s]
  "outcome",
  "contacts", // begun
  "pairs",
  "ended",
  "overlapped",
  "kinetic", // [J]
  "potential",
  "stored",
  "dissipated",
  "rotational",
  "compression", // largest so far, in radii
  "elastic", // collisions made elastic by the rule tc
  "soft",
  "third", // soft contacts with a third body
  "events",
] as const;
export type Observed = Record<(typeof observed)[number], number>;

// Columns of the log: begin, end, first, second, impact speed, separation speed, overlapped.
export const LOG_COLUMNS = 7;

export interface ErrorLaw {
  coefficient: number;
  coefficientError: number;
  decay: number;
}
export interface Measured {
  thinnest: number;
  densest: number;
  restitution: number;
  tcNu: number;
}
const lawRules = ["constant", "tc", "soft"];
// With friction, hard spheres have the tangential restitution of the contact law at each angle of impact.
const ruleWithFriction: Record<string, string> = { constant: "law" };

export class GasCore {
  private readonly wasm: Exports;
  private readonly rules: string[] = [];

  // `rubs`: whether the module is that of disks with friction.
  constructor(
    module: WebAssembly.Module,
    private readonly rubs = false,
  ) {
    this.wasm = new WebAssembly.Instance(module, {}).exports as unknown as Exports;
    for (let at = this.wasm.gas_rule(0); at !== 0; at = this.wasm.gas_rule(this.rules.length))
      this.rules.push(this.text(at));
  }

  private values(at: number, n: number): Float64Array {
    return new Float64Array(this.wasm.memory.buffer, at, n);
  }
  private text(at: number): string {
    const bytes = new Uint8Array(this.wasm.memory.buffer, at);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }

  set(input: Input): void {
    const at = this.wasm.gas_setting(input.number);
    const { number, radius, mass, edge, gravity, restitution, stiffness, contactDuration, friction, stiffnessRatio } =
      input;
    const periodic = input.periodic ? 1 : 0;
    this.values(at, this.wasm.gas_fields()).set([
      number,
      radius,
      mass,
      edge,
      edge,
      periodic,
      periodic,
      0,
      gravity,
      this.rules.indexOf((friction > 0 && ruleWithFriction[input.rule]) || input.rule),
      restitution,
      stiffness,
      contactDuration,
      friction,
      stiffnessRatio,
    ]);
    this.setting = at;
    this.number = number;
  }
  private setting = 0;
  private number = 0;

  // Random positions without overlap; false if the search fails.
  place(seed: number): boolean {
    return this.wasm.gas_place(seed) !== 0;
  }
  heat(seed: number, rms: number): void {
    this.wasm.gas_heat(seed, rms);
  }
  // Positions (2n), velocities (2n), with friction angular velocities (n).
  get start(): Float64Array {
    return this.values(this.setting + 8 * this.wasm.gas_fields(), this.length).slice();
  }
  private get length(): number {
    return (this.rubs ? 5 : 4) * this.number;
  }
  get duration(): number {
    return this.wasm.gas_duration();
  }
  // Greatest compression of an impact at this speed, in radii.
  compression(speed: number, wall: boolean): number {
    return this.wasm.gas_compression(speed, wall ? 1 : 0);
  }
  get deepest(): number {
    return this.wasm.gas_deepest();
  }

  begin(): number {
    return this.wasm.gas_start();
  }
  // Processes at most `work` events. Returns whether the time is reached or the simulation has ended.
  advance(world: World, until: number, work: number): boolean {
    return this.wasm.gas_advance(world, until, work) !== 0;
  }
  observe(world: World): Observed {
    const values = this.values(this.wasm.gas_observe(world), observed.length);
    return Object.fromEntries(observed.map((name, i) => [name, values[i]])) as Observed;
  }
  // As `start`; positions are unwrapped.
  state(world: World): Float64Array {
    return this.values(this.wasm.gas_state(world), this.length).slice();
  }
  // Rows since the last call, or those of contacts that have not ended.
  log(world: World, open = false): Float64Array {
    const rows = this.wasm.gas_take_log(world, open ? 1 : 0);
    return rows === 0 ? new Float64Array(0) : this.values(this.wasm.gas_log(), LOG_COLUMNS * rows).slice();
  }
  outcome(outcome: number): string {
    return this.text(this.wasm.gas_outcome(outcome));
  }

  // Enskog's collision rate [1/s].
  rate(phi: number, diameter: number, temperature: number): number {
    return this.wasm.law_rate(phi, diameter, temperature);
  }
  // D 2^D φ χ, and the slope s of the pair correlation at contact.
  fluid(phi: number): { density: number; slope: number } {
    const [density, slope] = this.values(this.wasm.law_fluid(phi), 2);
    return { density, slope };
  }
  law(phi: number, restitution: number, rule: string, added = nothing): ErrorLaw {
    const [coefficient, coefficientError, decay] = this.values(
      this.wasm.law_of_error(phi, restitution, lawRules.indexOf(rule), ...added),
      3,
    );
    return { coefficient, coefficientError, decay };
  }
  // Relative error of the cooling, and its standard error.
  error(phi: number, restitution: number, rule: string, tcNu: number, added = nothing): [number, number] {
    const at = this.wasm.law_errors(phi, restitution, lawRules.indexOf(rule), ...added, tcNu);
    const [error, bar] = this.values(at, 2);
    return [error, bar];
  }
  largestTcNu(phi: number, restitution: number, rule: string, error: number, added = nothing): number {
    return this.wasm.law_largest(phi, restitution, lawRules.indexOf(rule), ...added, error);
  }
  get measured(): Measured {
    const [thinnest, densest, restitution, tcNu] = this.values(this.wasm.law_measured(), 4);
    return { thinnest, densest, restitution, tcNu };
  }
}
