// Texts of the story, from the numbers of the present setting.
import type { Drop } from "../core/drop";
import { digits, metres, withUnit } from "../support/format";
import type { Step } from "./lecture_view";
import { ballById } from "../scenario/measured";
import { capital } from "../core/tables";
import { releaseHeight } from "./tale";
import { spell, times, why } from "./why";
import { massOf, type Ball } from "../scenario/scenario";

export interface Told {
  drop: Drop;
  guess: number | null; // m
  revealed: boolean; // whether the drop has been seen to its end
  rises: [number, number]; // of the top ball, Newton and independent collisions [m] (cradle: velocity of the last [m/s])
  gaps: { touching: number; best: number; at: number } | null; // Newton's heights at gap 0 and the highest, with its gap
  trusted: number | null; // gap above which both models agree [m]; infinite: nowhere in the map
}

const titles: Record<Step, string> = {
  predict: "How high will it fly?",
  drop: "The drop",
  slow: "Slowly, through the contact",
  count: "Count the contacts",
  gap: "Change the gap",
  map: "Where event-driven simulation may be trusted",
};

const onCradle: Partial<Record<Step, string>> = { predict: "How fast will the last one leave?", drop: "The collision" };
export const titleOf = (step: Step, cradle: boolean): string => (cradle && onCradle[step]) || titles[step];

// "basketball" where radius and mass are those of one, else what the place in the column says.
export function nameOfBall(b: Ball, place: string): string {
  const known = ["basketball", "tennis", "tabletennis"].find((id) => {
    const { mass, diameter } = ballById(id);
    const inside = ([low, high]: [number, number], x: number): boolean => x >= 0.999 * low && x <= 1.001 * high;
    return inside(mass, massOf(b)) && inside(diameter, 2 * b.radius);
  });
  return known === "basketball" ? "basketball" : known === "tennis" ? "tennis ball" : known ? "table tennis ball" : place;
}

export function storyText(step: Step, t: Told): string {
  const { scenario } = t.drop;
  if (scenario.cradle) return cradleText(step, t);
  const n = scenario.balls.length;
  const top = nameOfBall(scenario.balls[n - 1], "top ball");
  const low = nameOfBall(scenario.balls[0], "lowest ball");
  const column = n === 2 && top !== "top ball" && low !== "lowest ball" ? `A ${top} above a ${low}: both` : `${capital(spell(n))} balls, one above the other,`;
  const texts: Record<Step, () => string> = {
    predict: () =>
      `${column} are let go together, the ${top} ${metres(releaseHeight(t.drop))} above the floor. How high will the ${top} rise after the bounce? ` +
      "Drag the line there, then let them drop.",
    drop: () => (t.revealed ? outcome(t, top) : "Watch the ruler …"),
    slow: () => why(factsOf(t.drop)),
    count: () => counted(t),
    gap: () => gapText(t, top),
    map: () => mapText(t),
  };
  return texts[step]();
}

export const factsOf = (d: Drop): { balls: number; cradle: boolean; newton: Drop["newton"]["run"]; icm: Drop["icm"]["run"] } => ({
  balls: d.scenario.balls.length, cradle: d.scenario.cradle, newton: d.newton.run, icm: d.icm.run,
});

function outcome(t: Told, top: string): string {
  const [newton, icm] = t.rises;
  if (!Number.isFinite(newton)) return `The ${top} does not bounce.`;
  const from = releaseHeight(t.drop);
  const ratio = newton / from;
  const compared = ratio < 0.99 ? "lower than where it was let go" : ratio < 1.05 ? "hardly higher than where it was let go" : `${digits(ratio, 2)} times as high as where it was let go`;
  const guessed = t.guess === null ? "" : ` You said ${withUnit(t.guess, "m", 2)}${Math.abs(t.guess / newton - 1) < 0.1 ? ": well guessed!" : "."}`;
  const textbook = !Number.isFinite(icm) ? "" : Math.abs(icm / newton - 1) < 0.03 ? ` The textbook, one collision after the other, agrees: ${metres(icm)}.` : ` The textbook, one collision after the other, promises ${metres(icm)}.`;
  return `The ${top} rises to ${metres(newton)}, ${compared}.${guessed}${textbook}`;
}

function counted({ drop }: Told): string {
  const { newton, icm, scenario } = drop;
  const k = newton.run.nContacts;
  const e = Number(scenario.restitution.toPrecision(3));
  const said = icm.run.outcome === 4 || icm.run.outcome === 5 ? "the collision model counts without end" : `the collision model counts ${spell(icm.run.nContacts)}`;
  return `At ε = ${e} ${scenario.balls.length === 2 ? "the balls" : "neighbouring balls"} touch ${k === 0 ? "not at all" : times(k)}; ${said}. The bands show when they touch, for every ε: drag the line to another ε, and count again.`;
}

function gapText({ gaps }: Told, top: string): string {
  const told = gaps && Number.isFinite(gaps.touching) && Number.isFinite(gaps.best)
    ? `Let go touching, the ${top} reaches ${metres(gaps.touching)}; ${gaps.at > 0 ? `${withUnit(gaps.at, "m", 2)} apart, ${metres(gaps.best)}` : "no gap brings it higher"}. `
    : "";
  return `${told}Drag in the plot to change the gap. That balls dropped closer together rebound lower was measured in Bristol in 2015.`;
}

function mapText({ drop, trusted }: Told): string {
  if (drop.scenario.balls.length > 2)
    return `Event-driven simulation takes contacts one after another. Where the map counts more than ${spell(drop.scenario.balls.length - 1)}, one for each pair of neighbours, it leaves some out; where it counts as many, they may still overlap.`;
  const where = trusted === null ? "" : trusted === Infinity ? " In this map that is nowhere so for the present ε." : ` For the present ε that takes a gap above ${withUnit(trusted, "m", 2)}.`;
  return `Above the line both models agree to 5 %: the floor has let go before the balls meet, and collisions are events. Below it the contacts overlap, and an event-driven simulation is wrong.${where} Red, above 1, is gravity at work during the contact.`;
}

function cradleText(step: Step, t: Told): string {
  const n = t.drop.scenario.balls.length;
  const v = (x: number): string => withUnit(x, "m/s", 3, true);
  const texts: Record<Step, () => string> = {
    predict: () => `${capital(spell(n))} balls in a line, and no floor. The first arrives: with what speed will the last one leave?`,
    drop: () => (t.revealed ? `The last ball leaves with ${v(t.rises[0])}; the textbook, one collision after the other, says ${v(t.rises[1])}.` : "Watch the last ball …"),
    slow: () => why(factsOf(t.drop)),
    count: () => counted(t),
    gap: () => "Drag in the plot to change the gaps between the balls: the wider they are, the more they collide one after the other.",
    map: () => "The map counts contacts. Event-driven simulation is right where no two of them overlap.",
  };
  return texts[step]();
}
