// The table of results: the numbers of both models.
import type { Answered, Track } from "../core/drop";
import { independent } from "../scenario/tables";
import { digits, lengths, withUnit } from "../support/format";

export interface Row {
  id: string;
  name: string;
  title: string; // what the name means
  values: [string, string];
  numbers: [number, number]; // NaN: there is none
  lead: boolean;
}

const rebound =
  "greatest height of its centre above the floor after its first bounce. The next floor contact of the lowest " +
  "ball counts no more; collisions still to come between the balls do";
const pending = "…";

// Greatest height of a ball in the film if above its rebound height, else null.
export const laterHeight = (t: Track, i: number): number | null =>
  t.later[i] > t.peaks[i] * (1 + 1e-6) ? t.later[i] : null;

export function rowsOf(d: Answered): Row[] {
  const { newton, icm, scenario } = d;
  const n = scenario.balls.length;
  const list: Row[] = [];
  const add = (
    id: string,
    name: string,
    title: string,
    number: (t: Track) => number,
    texts: (a: number, b: number) => [string, string],
    lead = false,
  ): void => {
    const numbers: [number, number] = [number(newton), icm ? number(icm) : NaN];
    const [a, b] = texts(...numbers);
    list.push({ id, name, title, numbers, values: [a, icm ? b : pending], lead });
  };
  const each =
    (f: (x: number) => string) =>
    (a: number, b: number): [string, string] => [f(a), f(b)];
  const speed = each((x) => withUnit(x, "m/s", 3, true));
  add("contacts", "Ball–ball contacts", "contacts of the sequence", (t) => t.run.nContacts, each(String), true);
  if (scenario.cradle) {
    for (let i = n - 1; i >= 0; i--)
      add(
        `v${i}`,
        `Ball ${i + 1} leaves with`,
        "velocity after the last contact",
        (t) => t.leaves[i],
        speed,
        i === n - 1,
      );
    return list;
  }
  add("top", "Top ball rises to", rebound, (t) => t.peaks[n - 1], lengths, true);
  if ([newton, icm].some((t) => t && laterHeight(t, n - 1) !== null))
    add(
      "later",
      "… and later to",
      "after the lowest ball has met the floor again, while the film runs",
      (t) => laterHeight(t, n - 1) ?? NaN,
      lengths,
    );
  add("low", "Lowest ball rises to", "the same for the lowest ball", (t) => t.peaks[0], lengths);
  if (n > 2) {
    add(
      "vtop",
      "Top ball leaves with",
      "upward velocity after the last contact of the sequence; – where it is at rest or not known",
      (t) => t.leaves[n - 1],
      speed,
    );
    return list;
  }
  const e = scenario.restitution;
  add(
    "vr",
    "Relative velocity v′_r",
    "upper minus lower velocity when the last contact of the sequence ends",
    (t) => t.run.relativeVelocity,
    speed,
  );
  add("vs", "Separation velocity", "the same once no force acts", (t) => t.run.separationVelocity, speed);
  add(
    "eff",
    "ε_eff",
    `restitution that would give v′ᵣ with ${independent.label}`,
    (t) => t.run.effective,
    each((x) => digits(x)),
  );
  add(
    "ratio",
    "ε_eff/ε",
    `1: ${independent.label} are right`,
    (t) => t.run.effective / e,
    each((x) => digits(x)),
  );
  add(
    "sep",
    "ε_eff/ε at separation",
    "the same from the separation velocity",
    (t) => t.run.effectiveSeparation / e,
    each((x) => digits(x)),
  );
  add(
    "floor",
    "Floor contact lasts",
    "first contact of the lowest ball with the floor",
    (t) => (t === icm ? 0 : t.run.tFloorEnd),
    each((x) => withUnit(x, "s")),
  );
  return list;
}
