// The results in full precision, for tests and the CSV file.
import type { Answered } from "./drop";

export function exactNumbers(d: Answered): Record<string, number | null> {
  const out: Record<string, number | null> = {};
  const put = (name: string, x: number): void => void (out[name] = Number.isFinite(x) ? x : null);
  for (const [model, t] of [
    ["newton", d.newton],
    ["icm", d.icm],
  ] as const) {
    if (!t) continue;
    put(`${model}_contacts`, t.run.nContacts);
    put(`${model}_t_end`, t.run.tEnd);
    put(`${model}_t_floor_end`, t.run.tFloorEnd);
    put(`${model}_relative_velocity`, t.run.relativeVelocity);
    put(`${model}_separation_velocity`, t.run.separationVelocity);
    put(`${model}_effective_restitution`, t.run.effective);
    t.peaks.forEach((z, i) => put(`${model}_rise_${i + 1}`, z));
    t.leaves.forEach((v, i) => put(`${model}_velocity_${i + 1}`, v));
  }
  return out;
}
