// Takes several seconds: very many collisions of viscoelastic spheres.
export const long =
  "?example=fig2&law=viscoelastic&e=0.380&Y=28100000000&nu=0.44&v=2.922&r=0.05637,0.00501,0.005172,0.007586,0.03809," +
  "0.03158&rho=2252,426.9,6008,2250,401.5,4057&gap=0.00000582,0.01038,0,0.000245,0.00119&h=1.82";

// A random setting within the ranges of the controls, with ties and extremes.
export function randomScenario(random, lib) {
  const { ranges, clampTo, constants, laws: known, paper, massOf, densityFor, settle } = lib;
  const within = (r) => {
    const u = random();
    if (u < 0.06) return r.zero ? 0 : r.low;
    if (u > 0.96) return r.high;
    const v = random();
    return r.log ? r.low * (r.high / r.low) ** v : r.low + (r.high - r.low) * v;
  };
  const s = paper();
  const balls = 2 + Math.floor(5 * random() ** 2);
  s.law = known[Math.floor(known.length * random())].name;
  s.restitution = Math.max(within(ranges.restitution), 0.1);
  s.cradle = random() < 0.15;
  s.height = within({ low: 0.05, high: 2, log: true });
  for (const [name, c] of Object.entries(constants))
    s.constants[name] = c.range.log ? clampTo(c.range, c.start * 10 ** (4 * random() - 2)) : within(c.range);
  if (s.constants.poisson_ratio > 0.49) s.constants.poisson_ratio = 0.49;
  let radius = within({ low: 0.005, high: 0.2, log: true });
  s.balls = Array.from({ length: balls }, () => {
    const ball = { radius, density: densityFor(within({ low: 1e-3, high: 5, log: true }), radius) };
    if (random() < 0.7) radius = Math.max(0.003, radius * (0.3 + 0.7 * random()));
    return ball;
  });
  s.gaps = Array.from({ length: balls - 1 }, () => (random() < 0.25 ? 0 : within({ low: 1e-7, high: 0.1, log: true })));
  s.velocities = s.balls.map((_, i) => (s.cradle ? (i === 0 ? 1 : random() < 0.3 ? random() - 0.5 : 0) : 0));
  if (s.balls.some((b) => !(massOf(b) > 0))) throw new Error("no mass");
  settle(s);
  return s;
}
