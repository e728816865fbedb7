// Scenarios to start from.
import { ballBallStiffness, basketballStiffness, typical } from "./measured";
import { densityFor, paper, type Ball, type Scenario } from "./scenario";
import type { MapView } from "./view";

export interface Preset {
  id: string;
  name: string;
  about: string;
  scenario: Scenario;
  map?: Partial<MapView>;
}

const solid = (radius: number, mass: number): Ball => ({ radius, density: densityFor(mass, radius) });
const scenario = (changes: Partial<Scenario>): Scenario => {
  const base = paper();
  const s = { ...base, ...changes, constants: { ...base.constants, ...changes.constants } };
  return { ...s, velocities: changes.velocities ?? s.balls.map(() => 0) };
};

const basketball = typical("basketball");
const tennis = typical("tennis");

// The first one opens the page.
export const presets: Preset[] = [
  {
    id: "basketball",
    name: "Basketball and tennis ball",
    about:
      "The classroom classic, let go touching, 30 cm above the floor: balls in the middle of what their rules " +
      "allow (see Measured balls). " +
      "The floor contact has the basketball’s stiffness, the upper contact that of both balls in series; neither was " +
      "measured. Let go touching, the tennis ball rises little higher than it fell; a gap of two centimetres, and it " +
      "flies.",
    scenario: scenario({
      restitution: 0.76,
      constants: { stiffness: basketballStiffness },
      own: { stiffness: [ballBallStiffness] },
      height: Number((0.3 + basketball.radius).toPrecision(4)), // a metre rule shows all heights
      gaps: [0],
      balls: [solid(basketball.radius, basketball.mass), solid(tennis.radius, tennis.mass)],
    }),
    map: { axis: "gap", show: "count" },
  },
  {
    id: "fig2",
    name: "Paper, Figs. 2 and 3: four contacts",
    about: "R₁ = 10 cm, R₂ = 1 cm, Δh = 0.1 mm, ε = 0.7. The density 840 kg/m³ is inferred; the paper prints none.",
    scenario: scenario({}),
    map: { axis: "gap", show: "count" },
  },
  {
    id: "fig4",
    name: "Paper, Fig. 4: contacts over ε and R₁/R₂",
    about: "The lower ball's radius varies; the upper one and the height of the lower centre stay.",
    scenario: scenario({}),
    map: { axis: "ratio", show: "count" },
  },
  {
    id: "fig5",
    name: "Paper, Fig. 5: one contact is not enough",
    about: "ε = 0.9, Δh = 0.5 mm: one contact, and yet the effective ε is far below ε.",
    scenario: scenario({ restitution: 0.9, gaps: [5e-4] }),
    map: { axis: "gap", show: "effective" },
  },
  {
    id: "fig6",
    name: "Paper, Fig. 6: equal balls",
    about: "ε = 0.8 over R₁/R₂: only near equal radii does the effective ε exceed ε.",
    scenario: scenario({
      restitution: 0.8,
      balls: [
        { radius: 0.0142, density: 840 },
        { radius: 0.01, density: 840 },
      ],
    }),
    map: { axis: "ratio", show: "effective" },
  },
  {
    id: "fig7",
    name: "Paper, Fig. 7: viscoelastic spheres",
    about: "Hertzian contacts with viscous loss: Y = 5·10⁷ Pa, ν = 0.45, R₂ = 0.25 cm; ε is given at 3 m/s.",
    scenario: scenario({
      law: "viscoelastic",
      balls: [
        { radius: 0.1, density: 840 },
        { radius: 0.0025, density: 840 },
      ],
    }),
    map: { axis: "gap", show: "count" },
  },
  {
    id: "astro",
    name: "Astro-Blaster: four rubber balls",
    about: "A stack of super balls, each lighter than the one below.",
    scenario: scenario({
      restitution: 0.85,
      constants: { stiffness: 5e5 },
      height: 0.5,
      gaps: [5e-5, 5e-5, 5e-5],
      balls: [solid(0.027, 0.078), solid(0.019, 0.027), solid(0.0135, 0.0098), solid(0.009, 0.0029)],
    }),
    map: { axis: "gap", show: "count" },
  },
  {
    id: "steel",
    name: "Steel beads",
    about: "Y = 210 GPa, ν = 0.3, ε = 0.95 at 1 m/s, dropped from 10 cm, 20 µm apart.",
    scenario: scenario({
      law: "viscoelastic",
      restitution: 0.95,
      constants: { youngs_modulus: 2.1e11, poisson_ratio: 0.3, impact_speed: 1 },
      height: 0.1,
      gaps: [2e-5],
      balls: [
        { radius: 0.005, density: 7850 },
        { radius: 0.0015, density: 7850 },
      ],
    }),
    map: { axis: "gap", show: "effective" },
  },
  {
    id: "glass",
    name: "Glass beads",
    about: "Y = 65 GPa, ν = 0.22, ε = 0.97 at 1 m/s, dropped from 10 cm, 20 µm apart.",
    scenario: scenario({
      law: "viscoelastic",
      restitution: 0.97,
      constants: { youngs_modulus: 6.5e10, poisson_ratio: 0.22, impact_speed: 1 },
      height: 0.1,
      gaps: [2e-5],
      balls: [
        { radius: 0.004, density: 2500 },
        { radius: 0.001, density: 2500 },
      ],
    }),
    map: { axis: "gap", show: "effective" },
  },
  {
    id: "cradle",
    name: "Newton’s cradle: five steel balls",
    about: "One ball arrives at 1 m/s. Touching balls do not pass the impulse on one after another.",
    scenario: scenario({
      law: "viscoelastic",
      restitution: 0.97,
      constants: { youngs_modulus: 2.1e11, poisson_ratio: 0.3, impact_speed: 1 },
      cradle: true,
      gaps: [0.05, 0, 0, 0],
      velocities: [1, 0, 0, 0, 0],
      balls: [0, 0, 0, 0, 0].map(() => ({ radius: 0.01, density: 7850 })),
    }),
    map: { axis: "gap", show: "count" },
  },
];
