// Commercial balls: measured properties with sources, and the stiffness that follows.
import { massOf, type Ball } from "./scenario";

export interface MeasuredBall {
  id: string;
  name: string;
  short: string; // in a sentence
  by: string; // association that wrote the rules
  mass: [number, number]; // kg, lowest and highest allowed
  diameter: [number, number]; // m
  restitution: [number, number]; // from the rebound heights below
  bounce: string; // the test that gives the restitution
  contact: { time: number; how: string } | null; // s on a rigid floor, approximately
  source: string;
}

// ε of a ball dropped from `drop` that rebounds to `rise`; both are heights of its lowest point.
const fromHeights = (drop: number, rise: [number, number]): [number, number] => [
  Math.sqrt(rise[0] / drop),
  Math.sqrt(rise[1] / drop),
];

const psi = 6894.757; // Pa
export const basketballRadius = 0.7645 / (2 * Math.PI); // m, the middle of the circumferences allowed
const pressure = 8 * psi;

// A ball flattened by x has a contact area π(2Rx − x²) ≈ 2πRx; its pressure p gives the force F = 2πRp x.
export const airStiffness = (radius: number, overpressure: number): number => 2 * Math.PI * radius * overpressure;

// Contact time of the linear law on the floor: ε = exp(−β t), t = 2 atan2(ω, β)/ω, ω² = k/m − β² (see docs/laws).
export function contactTime(mass: number, stiffness: number, restitution: number): number {
  const w0 = Math.sqrt(stiffness / mass);
  return timeAt(w0, lossAngle(restitution));
}

// β = ω0 sin φ gives ε = exp(−(π − 2φ) tan φ), which falls steadily with φ.
function lossAngle(restitution: number): number {
  let low = 0;
  let high = Math.PI / 2;
  for (let i = 0; i < 60; i++) {
    const middle = 0.5 * (low + high);
    if (Math.exp(-(Math.PI - 2 * middle) * Math.tan(middle)) > restitution) low = middle;
    else high = middle;
  }
  return 0.5 * (low + high);
}
const timeAt = (w0: number, angle: number): number => (Math.PI - 2 * angle) / (w0 * Math.cos(angle));

// The stiffness for which a floor contact under the linear law lasts this long.
export function stiffnessFor(mass: number, time: number, restitution: number): number {
  return mass * timeAt(time, lossAngle(restitution)) ** 2;
}

export const middle = ([a, b]: [number, number]): number => 0.5 * (a + b);

export const measuredBalls: MeasuredBall[] = [
  {
    id: "basketball",
    name: "Basketball, size 7",
    short: "basketball",
    by: "FIBA",
    mass: [0.567, 0.65],
    diameter: [0.749 / Math.PI, 0.78 / Math.PI],
    restitution: fromHeights(1.8, [1.2 - 0.243, 1.4 - 0.243]),
    bounce: "dropped from 1.8 m (its lowest point), its top comes back to 1.2 to 1.4 m",
    contact: {
      time: contactTime(middle([0.567, 0.65]), airStiffness(basketballRadius, pressure), 0.76),
      how:
        "calculated, not measured: from the pressure, 7.5 to 8.5 psi (NBA, Official Rules, Rule 1, Section " +
        "II), k = 2πRp = 42 kN/m",
    },
    source:
      "FIBA, Official Basketball Rules 2000, Art. 3.3 (mass, circumference, rebound), as other publications quote " +
      "it; the rule book itself was not consulted. Those of 2020 for the equipment, quoted likewise, are " +
      "narrower: 580 g to 620 g and 75 cm to 77 cm around",
  },
  {
    id: "tennis",
    name: "Tennis ball, type 2",
    short: "tennis ball",
    by: "ITF",
    mass: [0.056, 0.0594],
    diameter: [0.0654, 0.0686],
    restitution: fromHeights(2.54, [1.35, 1.47]),
    bounce: "dropped from 2.54 m on concrete, it comes back to 1.35 to 1.47 m",
    contact: {
      time: 5e-3,
      how: "approximate; for measured courses of the force see R. Cross, Sports Engineering 2, 23 (1999)",
    },
    source: "ITF, Rules of Tennis, Appendix I (mass, size, rebound)",
  },
  {
    id: "tabletennis",
    name: "Table tennis ball",
    short: "table tennis ball",
    by: "ITTF",
    mass: [0.0027, 0.0027],
    diameter: [0.04, 0.04],
    restitution: fromHeights(0.305, [0.24, 0.26]),
    bounce:
      "dropped from 30.5 cm on a steel block, it comes back to 24 to 26 cm; a ball that is not of celluloid to 26.5 cm",
    contact: null,
    source: "ITTF, Laws of Table Tennis 2.03 (mass, diameter) and Technical Leaflet T3, B.7 (bounce)",
  },
];

export const ballById = (id: string): MeasuredBall => measuredBalls.find((b) => b.id === id)!;

// The measured ball that has this radius and mass.
export function measuredLike(b: Ball): MeasuredBall | undefined {
  const inside = ([low, high]: [number, number], x: number): boolean => x >= 0.999 * low && x <= 1.001 * high;
  return measuredBalls.find(({ mass, diameter }) => inside(mass, massOf(b)) && inside(diameter, 2 * b.radius));
}

// Name of a measured ball with this radius and mass, such as "basketball"; otherwise `place`.
export const nameOfBall = (b: Ball, place: string): string => measuredLike(b)?.short ?? place;

// Rebound heights of the centre [m] of a measured ball that is dropped alone: its lowest point falls by the release
// height minus the radius and rises by ε² of that, with the ε of its rules.
export function aloneRise(b: Ball, release: number): { low: number; high: number; by: string } | null {
  const known = measuredLike(b);
  if (!known) return null;
  const [low, high] = known.restitution.map((e) => b.radius + e * e * (release - b.radius));
  return { low, high, by: known.by };
}

// A ball with the mean values of its rules.
export const typical = (id: string): { radius: number; mass: number } => {
  const b = ballById(id);
  return { radius: Number((0.5 * middle(b.diameter)).toPrecision(4)), mass: Number(middle(b.mass).toPrecision(3)) };
};

// Stiffness of the basketball on the floor.
export const basketballStiffness = Number(airStiffness(basketballRadius, pressure).toPrecision(2));

// Both balls deform in a contact: two springs in series.
export const inSeries = (a: number, b: number): number => 1 / (1 / a + 1 / b);
const tennis = ballById("tennis");
export const tennisStiffness = stiffnessFor(middle(tennis.mass), tennis.contact!.time, middle(tennis.restitution));
export const ballBallStiffness = Number(inSeries(basketballStiffness, tennisStiffness).toPrecision(3));

export const experiments = [
  "Y. Berdeni, A. Champneys and R. Szalai, The two-ball bounce problem, Proc. R. Soc. A 471, 20150286 (2015): let " +
    "go with no gap, the upper ball rises less than with one.",
  "S. P. Bartz, Delayed rebounds in the two-ball bounce problem, arXiv 2007.15005 (2020): a low first bounce may " +
    "be followed by a higher second one.",
];
