// The law of the error of this setting: that of smooth disks from the core, and what friction adds to it, from a table
// of Python's theory (web/friction_table.py). docs/error_law.md has both.
import type { Added, GasCore } from "./core";
import table from "./friction_table.json";
import { INERTIA, type Setting } from "./setting";

export interface Law {
  known: boolean; // otherwise it says nothing: friction with this rule, or outside the table
  added: Added; // by friction
  outside: string[]; // numbers that are outside the range of the measurements with friction
  slower: number; // √T at a given energy over that at the ratio T_r/T of the start
  error: (tcNu: number) => [error: number, bar: number];
}

// Place of a value between two entries of an ascending list: index and weight of the upper one.
function place(list: readonly number[], x: number): [number, number] {
  const last = list.length - 1;
  const next = list.findIndex((value) => value >= x);
  const k = Math.max(1, next < 0 ? last : next);
  return [k, Math.min(Math.max((x - list[k - 1]) / (list[k] - list[k - 1]), 0), 1)];
}

// The row of the table, interpolated linearly in each variable.
function row(restitution: number, coefficient: number, ratio: number): number[] {
  const [axes, at] = [
    [table.restitution, table.coefficient, table.ratio],
    [restitution, coefficient, ratio],
  ];
  const places = axes.map((axis, i) => place(axis, at[i]));
  const sum = table.rows[0].map(() => 0);
  for (let corner = 0; corner < 8; corner++) {
    let [index, weight] = [0, 1];
    places.forEach(([k, w], i) => {
      const upper = (corner >> i) & 1;
      index = index * axes[i].length + k - 1 + upper;
      weight *= upper ? w : 1 - w;
    });
    if (weight > 0) table.rows[index].forEach((x, i) => (sum[i] += weight * x));
  }
  return sum;
}

const near = 0.02; // relative distance from the measured range that counts as none
// The factor of the error bar, and the numbers that are outside the range of the measurements.
function beyond(values: Record<Measured, number>): { wider: number; outside: string[] } {
  let wider = 1;
  const outside: string[] = [];
  for (const [name, value] of Object.entries(values) as [Measured, number][]) {
    const [low, high] = table.measured[name];
    if (value >= low * (1 - near) && value <= high * (1 + near)) continue;
    wider += 2 * Math.abs(Math.log2(value / Math.min(Math.max(value, low), high)));
    outside.push(name);
  }
  return { wider, outside };
}
type Measured = "μ" | "ρ" | "ε";

// The relation of Python's hardlimit.boxes.error_law.with_friction.
function byFriction(core: GasCore, setting: Setting): Omit<Law, "error"> {
  const { phi, restitution, friction, stiffnessRatio } = setting;
  const weakest = table.coefficient[0]; // below it the terms are in proportion to μ
  const weak = Math.min(friction / weakest, 1);
  const [energy, turned, pressed, spring, ratio] = row(restitution, Math.max(friction, weakest), stiffnessRatio);
  const decay = (e: number): number => core.law(phi, e, "tc").decay;
  const { density, slope } = core.fluid(phi);
  const parts = [turned / density, (slope * pressed) / density, -(table.third[0] + table.third[1] * phi) * spring];
  const change = parts.reduce((sum, part) => sum + part, energy);
  const coefficient = weak * Math.sqrt(decay(restitution) / decay(1)) * change;
  const [constant, growing, ...shares] = table.bar;
  const x = 1 - restitution ** 2;
  const bar = weak * Math.hypot(constant + growing * x, ...parts.map((part, i) => shares[i] * part));
  const { wider, outside } = beyond({ μ: friction, ρ: (1 + 1 / INERTIA) * stiffnessRatio, ε: restitution });
  return { known: true, added: [coefficient, bar, wider], outside, slower: Math.sqrt(1.5 / (1 + 0.5 * ratio)) };
}

export function lawOf(core: GasCore, setting: Setting): Law {
  const { phi, restitution, rule, friction } = setting;
  const none: Added = [0, 0, 1];
  // With friction it is that of collisions with the restitution of the contact law.
  if (friction > 0 && (rule !== "constant" || restitution < table.restitution[0]))
    return { known: false, added: none, outside: [], slower: 1, error: () => [NaN, NaN] };
  const terms = friction > 0 ? byFriction(core, setting) : { known: true, added: none, outside: [], slower: 1 };
  return { ...terms, error: (tcNu) => core.error(phi, restitution, rule, tcNu, terms.added) };
}
