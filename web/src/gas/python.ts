// The comparison of the page as a program in Python, from other random starts.
import { INERTIA, MASS, RADIUS, RMS_SPEED } from "./setting";
import type { Facts } from "./facts";

export function pythonOf({ start: { setting, input, until }, starts }: Facts): string {
  const { number, phi, restitution, rule, walls, gravity, seed, friction, stiffnessRatio } = setting;
  const density = MASS / ((4 / 3) * Math.PI * RADIUS ** 3);
  const system = [
    `${number}, ${phi}, radius=${RADIUS}, density=${density}, rms_speed=${RMS_SPEED}, dimension=2, seed=seed`,
    ...(walls ? [`boundary="wall"`] : []),
    ...(gravity > 0 ? [`gravity=(0.0, -${gravity})`] : []),
    ...(friction > 0 ? [`rms_spin="equal", inertia_factor=${INERTIA}`] : []),
  ];
  const rubbing = friction > 0 ? `, friction=hl.Friction(${friction}, stiffness_ratio=${stiffnessRatio})` : "";
  const model = friction > 0 && rule === "constant" ? "law" : rule;
  return (
    "import hardlimit as hl; print(hl.fidelity(" +
    `lambda seed: hl.ParticleSystem.random(${system.join(", ")}), ` +
    `law=hl.LinearDashpot(stiffness=${input.stiffness}, restitution=${restitution}${rubbing}), ` +
    `until=${until}, models=["newton", "${model}"], replicas=${Math.max(starts.length, 2)}, seed=${seed}, engine="events"))`
  );
}
