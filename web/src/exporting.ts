// Files to keep: the picture, the numbers, the scenario.
import { Model, type Core } from "./core";
import type { Drop } from "./drop";
import { exactNumbers } from "./numbers";
import { toToml } from "./scenario";

export function save(name: string, content: Blob): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

// Trajectories of both models: the film's time scale puts many rows where much happens.
export function csv(core: Core, d: Drop): string {
  const n = d.scenario.balls.length;
  const times = new Set<number>(d.times);
  for (let i = 0; i <= 600; i++) times.add(d.clock.toPhysical((i / 600) * d.clock.length));
  const sorted = [...times].filter((t) => t >= d.start && t <= d.stop).sort((a, b) => a - b);
  const lines = toToml(d.scenario).trimEnd().split("\n").filter((x) => x !== "").map((x) => `# ${x}`);
  lines.push("# time: s after " + (d.scenario.cradle ? "release" : "the first floor touch") + "; lengths m, velocities m/s, forces N, energies J");
  for (const [key, value] of Object.entries(exactNumbers(d))) lines.push(`# ${key} = ${value ?? "nan"}`);
  const head = ["time"];
  const models = [["newton", Model.newton], ["icm", Model.independent]] as const;
  for (const [name] of models) {
    for (let i = 1; i <= n; i++) head.push(`${name}_position_${i}`);
    for (let i = 1; i <= n; i++) head.push(`${name}_velocity_${i}`);
    if (name === "newton") for (let j = 0; j < n; j++) head.push(`newton_gap_${j}${j + 1}`, `newton_force_${j}${j + 1}`);
    head.push(`${name}_dissipated`);
  }
  lines.push(head.join());
  const [newton, icm] = models.map(([, model]) => core.sample(model, sorted));
  sorted.forEach((t, k) => {
    const row = [t, ...newton[k].position, ...newton[k].velocity];
    for (let j = 0; j < n; j++) row.push(newton[k].gap[j], newton[k].force[j]);
    row.push(newton[k].dissipated, ...icm[k].position, ...icm[k].velocity, icm[k].dissipated);
    lines.push(row.map((x) => (Number.isFinite(x) ? String(x) : "nan")).join());
  });
  return lines.join("\n") + "\n";
}
