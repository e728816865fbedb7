// All sentences of the laboratory and of the story: a table for each place, with the rows id, condition, text and
// numbers. The verdict has the words of hl.compare(column).verdict; its answer and numbers come from the core.
import type { Track } from "../core/drop";
import type { Step } from "../scenario/story_view";
import { constantsOf } from "../scenario/scenario";
import { capital, independent } from "../scenario/tables";
import { inPercent } from "../scenario/tolerance";
import { digits, lengths, metres, withUnit } from "../support/format";
import { allOf, always, chosen, type Numbers, type Row, type Sentence } from "../support/sentence";
import {
  agree,
  alone,
  answered,
  bothPlain,
  bothValues,
  comparedWithRelease,
  contactFacts,
  count,
  cradle,
  heights,
  icm,
  lastVelocity,
  lowName,
  newton,
  outcomes,
  overlapping,
  ratioOf,
  release,
  rises,
  speed,
  top,
  topName,
  type BothFacts,
  type ContactFacts,
  type Facts,
  type RunFacts,
  type StoryFacts,
  type VerdictFacts,
} from "./facts";
import { bodiesOf, counted, duration, spell, times } from "./words";

// ---- the headline: Newton's equations ----------------------------------------------------------------------

// Compression over the smaller radius above which a contact law is questionable.
const SHALLOW = 0.05;

// Number of contacts of the sequence; later contacts may affect the heights.
function contacts(t: Track): string {
  const n = t.run.nContacts;
  const text = counted(n, "contact");
  return t.run.meetsAgain && n > 0 ? `${text} before the lowest ball is back on the floor, more after it` : text;
}

const atRest = (f: Facts): boolean => f.newton.run.outcome === outcomes.atRest;
const noContact = (f: Facts): boolean => f.newton.run.nContacts === 0;
const rise = (f: Facts): Numbers => ({ contacts: f.newton.run.nContacts, height: top(f.newton) });

export const newtonRows: Row<Facts>[] = [
  [
    "too-deep",
    (f) => f.newton.run.outcome === outcomes.tooDeep,
    ({ newton: { run } }) =>
      `No answer by Newton’s equations: after ${duration(run.last)} ${bodiesOf(run.tooDeep)} are compressed ` +
      "by half of the smaller radius, which no contact law describes.",
    ({ newton: { run } }) => ({ time: run.last, pair: run.tooDeep }),
  ],
  [
    "unresolved",
    (f) => f.newton.run.outcome === outcomes.unresolved,
    ({ newton: { run } }) =>
      `No answer by Newton’s equations: after two million steps and ${counted(run.events, "contact")} ` +
      "there is no end in sight.",
    (f) => ({ events: f.newton.run.events }),
  ],
  ["cradle-no-contact", (f) => f.cradle && noContact(f), () => "No two balls meet."],
  [
    "cradle",
    (f) => f.cradle,
    ({ newton: t }) =>
      `${capital(counted(t.run.nContacts, "contact"))}; the last ball leaves with ${speed(lastVelocity(t))}.`,
    ({ newton: t }) => ({ contacts: t.run.nContacts, velocity: lastVelocity(t) }),
  ],
  [
    "at-rest",
    (f) => atRest(f) && rises(f.newton),
    (f) =>
      `${capital(counted(f.newton.run.nContacts, "contact"))} between balls; one contact, of balls or with the ` +
      `floor, ` +
      `never ends because gravity holds it closed. After its first bounce the top ball reaches ${heights(f)[0]}.`,
    rise,
  ],
  ["at-rest-flat", atRest, () => "A contact never ends because gravity holds it closed; the top ball does not bounce."],
  [
    "no-contact-rises",
    (f) => noContact(f) && rises(f.newton),
    (f) =>
      "The balls do not meet before the lowest one is back on the floor; " +
      `the top ball reaches ${heights(f)[0]} after a later bounce.`,
    rise,
  ],
  ["no-contact", noContact, () => "The balls do not meet before the lowest one is back on the floor."],
  [
    "no-bounce",
    (f) => !rises(f.newton),
    (f) => `${capital(contacts(f.newton))}; the top ball does not bounce before the floor is met again.`,
    (f) => ({ contacts: f.newton.run.nContacts }),
  ],
  ["rises", always, (f) => `${capital(contacts(f.newton))}, and the top ball rises to ${heights(f)[0]}.`, rise],
];

// Added to the sentence above.
export const warningRows: Row<Facts>[] = [
  [
    "compressed",
    ({ newton: { run } }) => run.largestCompression >= SHALLOW && run.outcome !== outcomes.tooDeep,
    ({ newton: { run } }) =>
      `An estimate: pressed in by ${digits(100 * run.largestCompression, 2)} % of a radius, laws hold below ` +
      `${inPercent(SHALLOW)}: stiffen the balls.`,
    (f) => ({ compression: f.newton.run.largestCompression }),
  ],
];

// ---- the headline: independent collisions ------------------------------------------------------------------

// How a height compares with Newton's.
const ratioRows: Row<{ ratio: number; tolerance: number }>[] = [
  ["alone", (f) => !(f.ratio > 0 && f.ratio < Infinity), () => ""],
  ["same", (f) => Math.abs(f.ratio - 1) <= f.tolerance, (f) => `, the same to ${inPercent(f.tolerance)}`],
  ["times", (f) => f.ratio >= 1.995, (f) => `, ${digits(f.ratio, 2)} times as high`],
  ["higher", (f) => f.ratio > 1, (f) => `, ${digits(100 * (f.ratio - 1), 2)} % higher`],
  ["lower", always, (f) => `, ${digits(100 * (1 - f.ratio), 2)} % lower`],
];

const ICM = capital(independent.label);
const compared = (f: BothFacts): string => chosen(ratioRows, { ratio: ratioOf(f), tolerance: f.tolerance })!.text;
const heightCompared = (f: BothFacts): string => heights(f)[1] + compared(f);
const collapses = (f: BothFacts): boolean => f.icm.run.outcome === outcomes.collapse;
const comesToRest = (f: BothFacts): boolean => f.icm.run.outcome === outcomes.atRest;
const icmNumber = (f: BothFacts): Numbers => ({ contacts: f.icm.run.nContacts });
const icmHeight = (f: BothFacts): Numbers => ({ height: top(f.icm), ratio: ratioOf(f) });
const icmRise = (f: BothFacts): Numbers => ({ ...icmNumber(f), ...icmHeight(f) });
const endless = `${ICM}: infinitely many in a finite time, `;

export const icmRows: Row<BothFacts>[] = [
  [
    "unresolved",
    (f) => f.icm.run.outcome === outcomes.unresolved,
    (f) => `${ICM}: ${f.icm.run.events} were followed, and there is no end in sight.`,
    (f) => ({ events: f.icm.run.events }),
  ],
  ["cradle-no-contact", (f) => f.cradle && f.icm.run.nContacts === 0, () => `${ICM}: no two balls meet.`],
  [
    "cradle-collapse",
    (f) => f.cradle && collapses(f),
    (f) => `${endless}an inelastic collapse; the last ball then has ${speed(lastVelocity(f.icm))}.`,
    (f) => ({ velocity: lastVelocity(f.icm) }),
  ],
  [
    "cradle",
    (f) => f.cradle,
    (f) => `${ICM}: ${spell(f.icm.run.nContacts)}, and ${speed(lastVelocity(f.icm))}.`,
    (f) => ({ ...icmNumber(f), velocity: lastVelocity(f.icm) }),
  ],
  [
    "collapse",
    (f) => collapses(f) && rises(f.icm),
    (f) => `${endless}an inelastic collapse; the top ball has reached ${heightCompared(f)}.`,
    icmHeight,
  ],
  ["collapse-flat", collapses, () => `${endless}an inelastic collapse.`],
  [
    "at-rest",
    (f) => comesToRest(f) && rises(f.icm),
    (f) => `${endless}and the balls come to rest; the top ball has reached ${heightCompared(f)}.`,
    icmHeight,
  ],
  ["at-rest-flat", comesToRest, () => `${endless}and the balls come to rest.`],
  [
    "no-contact-rises",
    (f) => f.icm.run.nContacts === 0 && rises(f.icm),
    (f) =>
      `${ICM}: none before the lowest ball is back on the floor; ` +
      `up to ${heights(f)[1]} after a later bounce${compared(f)}.`,
    icmRise,
  ],
  ["no-contact", (f) => f.icm.run.nContacts === 0, () => `${ICM}: the top ball is not met.`],
  [
    "no-bounce",
    (f) => !rises(f.icm),
    (f) => `${ICM}: ${contacts(f.icm)}, and the top ball does not bounce.`,
    icmNumber,
  ],
  [
    "rises-later",
    (f) => f.icm.run.meetsAgain,
    (f) => `${ICM}: ${contacts(f.icm)}; up to ${heightCompared(f)}.`,
    icmRise,
  ],
  ["rises", always, (f) => `${ICM}: ${spell(f.icm.run.nContacts)}, and up to ${heightCompared(f)}.`, icmRise],
];

// ---- the verdict -------------------------------------------------------------------------------------------

const because =
  (ground: VerdictFacts["ground"]) =>
  (f: VerdictFacts): boolean =>
    f.ground === ground;
const inTime = (f: VerdictFacts): string => (f.floor ? " before the second floor contact" : "");
const outcome = (run: VerdictFacts["icmRun"]): string => run.message.split(":")[0];
const notNewtons = "in a finite time; that of Newton’s equations does not.";

function overlaps({ overlapping, newtonRun: { nContacts: n }, later }: VerdictFacts): string {
  const last = later ? ", under one model the last one follows the second floor contact" : "";
  if (overlapping === 0) return `no contacts overlap in time${last}`;
  const number = overlapping < n ? `${overlapping} of ${n}` : n === 1 ? "the" : n === 2 ? "both" : `all ${n}`;
  const verb = overlapping === 1 || n === 1 ? "overlaps" : "overlap";
  return `${number} ball–ball contact${n > 1 ? "s" : ""} ${verb} another contact in time${last}`;
}

function difference(f: VerdictFacts): string {
  const touches = "the second floor contact begins before the balls separate";
  if (f.ground === "newton-touches-again") return `under Newton’s equations ${touches}`;
  if (f.ground === "independent-touches-again") return `in the event-driven model ${touches}`;
  const what = f.ball < 0 ? "separation velocity" : `final velocity of ball ${f.ball + 1}`;
  return f.error <= f.tolerance
    ? `the event-driven ${what} is right to ${roundedUp(f.error)}`
    : `the event-driven ${what} is ${twoVelocities(f.independent, f.newton)}`;
}

// Two velocities with as many digits as needed to differ.
function twoVelocities(a: number, b: number): string {
  let texts: string[] = [];
  for (let n = 3; n < 18; n++) {
    texts = [a, b].map((x) => general(x, n).replaceAll("-", "−"));
    if (texts[0] !== texts[1]) break;
  }
  return `${texts[0]} m/s instead of ${texts[1]} m/s`;
}

// An error in per cent with one digit, rounded up.
function roundedUp(error: number): string {
  const percent = 100 * error;
  if (percent <= 0.001) return "0.001 %";
  const unit = 10 ** Math.floor(Math.log10(percent));
  return `${general(Math.ceil((percent / unit) * (1 - 1e-12)) * unit, 1)} %`;
}

// n significant digits without trailing zeros, as %.ng of C.
function general(x: number, n: number): string {
  if (x === 0) return Object.is(x, -0) ? "-0" : "0";
  const [mantissa, power] = x.toExponential(n - 1).split("e");
  const exponent = Number(power);
  const bare = (text: string): string => (text.includes(".") ? text.replace(/\.?0+$/, "") : text);
  if (exponent >= -4 && exponent < n) return bare(x.toFixed(Math.max(n - 1 - exponent, 0)));
  return `${bare(mantissa)}e${exponent < 0 ? "-" : "+"}${String(Math.abs(exponent)).padStart(2, "0")}`;
}

const verdictNumbers = (f: VerdictFacts): Numbers => ({
  overlapping: f.overlapping,
  contacts: f.newtonRun.nContacts,
  error: f.error,
  independent: f.independent,
  newton: f.newton,
  tolerance: f.tolerance,
});

export const verdictRows: Row<VerdictFacts>[] = [
  [
    "newton-unclear",
    because("newton-unclear"),
    (f) => `No verdict: the outcome of Newton’s equations is “${outcome(f.newtonRun)}”.`,
  ],
  [
    "independent-unclear",
    because("independent-unclear"),
    (f) => `No verdict: the outcome of the event-driven model is “${outcome(f.icmRun)}”.`,
  ],
  ["no-contact", because("no-contact"), () => "No verdict: the balls do not meet before the second floor contact."],
  [
    "newton-at-rest",
    because("newton-at-rest"),
    () => "No: under Newton’s equations a contact never ends, but event-driven collisions are instantaneous.",
  ],
  [
    "collapse",
    because("collapse"),
    () => "No: the event-driven sequence ends in an inelastic collapse, infinitely many collisions " + notNewtons,
  ],
  [
    "independent-at-rest",
    because("independent-at-rest"),
    () => "No: the event-driven sequence comes to rest by infinitely many collisions " + notNewtons,
  ],
  [
    "only-newton-meets",
    because("only-newton-meets"),
    (f) => `No: the balls meet under Newton’s equations but not in the event-driven model${inTime(f)}.`,
  ],
  [
    "only-independent-meets",
    because("only-independent-meets"),
    (f) => `No: the balls meet in the event-driven model but not under Newton’s equations${inTime(f)}.`,
  ],
  [
    "by-luck",
    (f) => f.answer === "by luck",
    (f) => `Only by luck: ${overlaps(f)}, yet ${difference(f)}.`,
    verdictNumbers,
  ],
  ["yes", (f) => f.answer === "yes", (f) => `Yes: ${overlaps(f)}, and ${difference(f)}.`, verdictNumbers],
  ["no", always, (f) => `No: ${overlaps(f)}${f.overlapping ? ";" : ", yet"} ${difference(f)}.`, verdictNumbers],
];

// ---- why the models differ or agree ------------------------------------------------------------------------

const pushes = (f: ContactFacts): string => `The floor pushes for ${duration(f.floor!.end)}`;
const letsGo = (f: ContactFacts, balls: string): string =>
  `${pushes(f)} and has let go when ${balls} meet after ${duration(f.first)}`;
// For contacts that do not overlap. The collision model may still have other collisions.
const inTurn = ({ icm, between }: ContactFacts, what = "one collision after the other"): string => {
  const pairs = icm?.contacts.filter((c) => c.pair > 0 && c.begin <= icm.last).map((c) => c.pair);
  return what + (pairs?.join() === between.map((c) => c.pair).join() ? ", as the collision model has it" : "");
};
const together = ({ most }: ContactFacts): string =>
  `Up to ${spell(most)} contacts press at the same time; the collision model takes them one after another.`;
const touchOften = ({ list, longest }: ContactFacts): string => {
  const lasts = Number.isFinite(longest) ? `, ${list.length === 1 ? "for" : "for up to"} ${duration(longest)}` : "";
  return `touch ${times(list.length)}${lasts}`;
};
const floorEnd = (f: ContactFacts): Numbers => ({ floorEnd: f.floor!.end });
const firstAndFloor = (f: ContactFacts): Numbers => ({ ...floorEnd(f), first: f.first });
const mostTogether = (f: ContactFacts): Numbers => ({ ...firstAndFloor(f), most: f.most });
const listNumbers = (f: ContactFacts): Numbers => ({ contacts: f.list.length, longest: f.longest });

const cradleRows: Row<ContactFacts>[] = [
  ["cradle-none", (f) => f.list.length === 0, () => "No two balls meet."],
  [
    "cradle-once",
    (f) => f.list.length === 1,
    (f) => `Two balls ${touchOften(f)}, and no other pair does: ${inTurn(f, "a single collision")}.`,
    (f) => ({ longest: f.longest }),
  ],
  [
    "cradle-in-turn",
    (f) => f.most < 2,
    (f) => `The balls ${touchOften(f)}, never two pairs at a time: ${inTurn(f)}.`,
    listNumbers,
  ],
  [
    "cradle-together",
    always,
    (f) =>
      `The balls ${touchOften(f)}, up to ${spell(f.most)} pairs at the same time; ` +
      "the collision model passes the impulse on one pair at a time.",
    (f) => ({ ...listNumbers(f), most: f.most }),
  ],
];

const failureRows: Row<ContactFacts>[] = [
  ["too-deep", (f) => f.newton.tooDeep >= 0, () => "The contacts need to be stiffer for an answer."],
  [
    "unresolved",
    (f) => f.newton.outcome === outcomes.unresolved,
    () => "Newton’s equations have more contacts here than can be followed.",
  ],
];

const two = (f: ContactFacts): boolean => f.balls === 2;
const afterFloor = (f: ContactFacts): boolean => two(f) && f.first >= f.floor!.end;
const floorRows: Row<ContactFacts>[] = [
  [
    "never-meet",
    (f) => f.between.length === 0 || f.newton.nContacts === 0,
    ({ newton: { tFloorEnd }, icm }) => {
      const begin = Number.isFinite(tFloorEnd) ? `The floor pushes for ${duration(tFloorEnd)}, and the` : "The";
      const other = icm === null ? "" : icm.nContacts > 0 ? "; in the collision model they do" : ", in neither model";
      return `${begin} balls do not meet before the lowest one is back on the floor${other}.`;
    },
    ({ newton: { tFloorEnd } }): Numbers => (Number.isFinite(tFloorEnd) ? { floorEnd: tFloorEnd } : {}),
  ],
  ["floor-stays", (f) => !f.floor || f.floor.end === Infinity, () => "The floor never lets go of the lowest ball."],
  [
    "two-after-once",
    (f) => afterFloor(f) && f.between.length === 1,
    (f) => `${letsGo(f, "the balls")}: ${inTurn(f)}.`,
    firstAndFloor,
  ],
  [
    "two-after-often",
    afterFloor,
    (f) =>
      `${letsGo(f, "the balls")}; even so they touch ${times(f.between.length)}` +
      `${f.icm ? `, the collision model says ${times(f.icm.nContacts)}` : ""}.`,
    (f) => ({ ...firstAndFloor(f), contacts: f.between.length }),
  ],
  ["two-pending", (f) => two(f) && !f.icm, (f) => `${pushes(f)}.`, floorEnd],
  [
    "two-not-met",
    (f) => two(f) && !(f.instant >= 0),
    (f) => `${pushes(f)}; in the collision model the balls do not meet at all.`,
    floorEnd,
  ],
  [
    "two-at-once",
    (f) => two(f) && f.instant === 0,
    (f) =>
      `${pushes(f)}; the collision model lets the balls meet at the very instant of the floor touch, as the second collision.`,
    floorEnd,
  ],
  [
    "two-meet",
    two,
    (f) =>
      `${pushes(f)}; the collision model lets the balls meet after ${duration(f.instant)}, ` +
      `${f.instant < f.floor!.end ? "while the floor is still pushing" : "when it has let go"}.`,
    (f) => ({ ...floorEnd(f), instant: f.instant }),
  ],
  [
    "many-together",
    (f) => f.most >= 2 && f.first < f.floor!.end,
    (f) => `${pushes(f)}; the first two balls meet after ${duration(f.first)}, while it still does. ${together(f)}`,
    mostTogether,
  ],
  [
    "many-together-later",
    (f) => f.most >= 2,
    (f) => `${letsGo(f, "the first two balls")}. ${together(f)}`,
    mostTogether,
  ],
  [
    "many-in-turn",
    always,
    (f) => `${letsGo(f, "the first two balls")}; ${inTurn(f, "no two contacts overlap")}.`,
    firstAndFloor,
  ],
];

// Two balls that meet while the floor pushes: how they touch.
const byNewton = "By Newton’s equations ";
const lasting = ({ between: [{ end }], first }: ContactFacts): number => end - first;
const touchOnce = (f: ContactFacts): string => `${byNewton}they touch once, for ${duration(lasting(f))}, `;
const lastEnd = ({ between }: ContactFacts): number => between[between.length - 1].end;
const touchRows: Row<ContactFacts>[] = [
  [
    "touch-often",
    (f) => f.between.length > 1,
    (f) => {
      const end = Number.isFinite(lastEnd(f)) ? duration(lastEnd(f)) : "the time when they stay together";
      return `${byNewton}they touch ${times(f.between.length)}, between ${duration(f.first)} and ${end}.`;
    },
    (f) => ({ contacts: f.between.length, first: f.first, end: lastEnd(f) }),
  ],
  ["touch-for-ever", (f) => f.between[0].end === Infinity, () => `${byNewton}the balls stay together.`],
  [
    "touch-beyond-floor",
    (f) => f.between[0].end > f.floor!.end,
    (f) => `${touchOnce(f)}until after the floor has let go.`,
    (f) => ({ lasts: lasting(f) }),
  ],
  ["touch-on-floor", always, (f) => `${touchOnce(f)}all of it while the floor pushes.`, (f) => ({ lasts: lasting(f) })],
];

// All rows whose condition holds are added.
const breakdownRows: Row<ContactFacts>[] = [
  [
    "breaks-down",
    (f) => f.icm?.outcome === outcomes.collapse,
    () =>
      "The collision model breaks down: its collisions follow each other ever faster, infinitely many in a finite " +
      "time, " +
      "as the balls come to rest on each other.",
  ],
  [
    "too-many",
    (f) => f.icm?.outcome === outcomes.unresolved,
    (f) => `The collision model breaks down: the collisions of its ${spell(f.balls)} balls become too many to count.`,
  ],
];

// One or two sentences from the contacts of this setting.
export function why(facts: RunFacts): Sentence[] {
  const f = contactFacts(facts);
  const failure = chosen(failureRows, f);
  if (failure) return [failure];
  const first = chosen(f.cradle ? cradleRows : floorRows, f)!;
  const how = first.id.startsWith("two-") && f.first < f.floor!.end ? [chosen(touchRows, f)!] : [];
  return [first, ...how, ...allOf(breakdownRows, f)];
}

// ---- the story ---------------------------------------------------------------------------------------------

const newtonRises = (t: StoryFacts): string => `By Newton’s equations the ${topName(t)} rises to ${metres(newton(t))}`;
const newtonLeaves = (t: StoryFacts): string => `By Newton’s equations the last ball leaves with ${speed(newton(t))}`;
const agreement = (t: StoryFacts): string => inPercent(t.report.tolerance);
const has = (x: number): boolean => Number.isFinite(x);
const gapInWords = (gap: number): string => (gap === 0 ? "touching" : `${withUnit(gap, "m")} apart`);

// Heights that agree are followed by the verdict, unless it goes without saying.
const doubted = ({ report: { verdict } }: StoryFacts): boolean => verdict !== null && verdict.answer !== "yes";
const apart = (t: StoryFacts): string => (doubted(t) ? " The velocities are judged apart." : "");

// Said where a chapter has other balls than the one before.
const otherBalls: Row<StoryFacts>[] = [
  [
    "balls-lent",
    (t) => t.lent,
    ({ drop: { scenario } }) => {
      const [lower, upper] = scenario.balls.map((b) => withUnit(b.radius, "m"));
      const gap = gapInWords(scenario.gaps[0]);
      return `For this chapter the balls change: hard ones, with radii of ${lower} and ${upper}, let go ${gap}.`;
    },
    ({ drop: { scenario } }) => ({
      lower: scenario.balls[0].radius,
      upper: scenario.balls[1].radius,
      gap: scenario.gaps[0],
    }),
  ],
  ["balls-back", (t) => t.back, (t) => `The ${lowName(t)} and the ${topName(t)} are back.`],
];

const worlds: Row<StoryFacts>[] = [
  [
    "worlds",
    always,
    () =>
      "Newton’s equations: balls that touch push each other, as springs do, for as long as they touch. " +
      "The textbook’s collision model, independent collisions (ICM): each collision is over in an instant, " +
      "one after the other.",
  ],
];

const watch: Row<StoryFacts>[] = [
  ["watch-cradle", cradle, (t) => `${newtonLeaves(t)}, in the textbook with ${speed(icm(t))}.`, bothValues],
  [
    "watch-agree",
    agree,
    (t) =>
      `The ${topName(t)} rises to ${metres(newton(t))}, and the textbook says the same to ` +
      `${agreement(t)}.${apart(t)}`,
    bothValues,
  ],
  ["watch-differ", always, (t) => `${newtonRises(t)}; the textbook promises ${metres(icm(t))}.`, bothValues],
];

const before = (t: StoryFacts): boolean => t.fall === "before";
const falling = (t: StoryFacts): boolean => t.fall === "falling";
const over = (t: StoryFacts): boolean => t.fall === "over";
const textbook = "The textbook, one collision after the other, ";
const predicted = (t: StoryFacts): string => {
  if (t.guess === null) return "";
  return ` You said ${withUnit(t.guess, "m", 2)}${Math.abs(t.guess / newton(t) - 1) < 0.1 ? ": well guessed!" : "."}`;
};
const rose = (t: StoryFacts): string => `${newtonRises(t)}, ${comparedWithRelease(t)}.${predicted(t)}`;
const column = (t: StoryFacts): string =>
  count(t) === 2 && topName(t) !== "top ball" && lowName(t) !== "lowest ball"
    ? `A ${topName(t)} above a ${lowName(t)}: both`
    : `${capital(spell(count(t)))} balls, one above the other,`;

const predict: Row<StoryFacts>[] = [
  [
    "predict-cradle",
    (t) => before(t) && cradle(t),
    (t) =>
      `${capital(spell(count(t)))} balls in a line, and no floor. The first arrives: ` +
      "with what speed will the last one leave?",
  ],
  [
    "predict",
    before,
    (t) =>
      `${column(t)} are let go together, the ${topName(t)} ${metres(release(t))} above the floor. ` +
      `How high will the ${topName(t)} rise after the bounce? Drag the line there, then let them drop.`,
    (t) => ({ release: release(t) }),
  ],
  ["drop-wait-cradle", (t) => cradle(t) && falling(t), () => "Watch the last ball …"],
  [
    "drop-cradle",
    cradle,
    (t) =>
      `The last ball leaves with ${speed(newton(t))}; the textbook, one collision after the other, says ` +
      `${speed(icm(t))}.`,
    bothValues,
  ],
  ["drop-wait", falling, () => "Watch the ruler: once by Newton’s equations, once as the textbook has it …"],
  [
    "drop-agree",
    agree,
    (t) => `${rose(t)} ${textbook}says the same to ${agreement(t)}: ${metres(icm(t))}.${apart(t)}`,
    bothValues,
  ],
  ["drop-differ", always, (t) => `${rose(t)} ${textbook}promises ${metres(icm(t))}.`, bothValues],
];

const pressed = (t: StoryFacts): number => t.drop.newton.run.largestCompression;

// Said of balls whose mass, size and bounce are known, but not their stiffness.
const bands: Row<StoryFacts>[] = [
  [
    "band",
    (t) => t.drop.band !== null && bothPlain(t),
    ({ drop: { band } }) => {
      const [soft, stiff] = band!.map(metres);
      return (
        "How high exactly is not known: we know of no measurement of how stiff these two balls are where they touch. " +
        `By Newton’s equations half the stiffness assumed here gives ${soft}, twice as much ${stiff}. ` +
        "In the textbook the stiffness does not matter."
      );
    },
    ({ drop: { band } }) => ({ soft: band![0], stiff: band![1] }),
  ],
  [
    "band-deep",
    (t) => t.drop.band !== null && bothPlain(t) && pressed(t) >= SHALLOW,
    (t) =>
      `The balls are pressed in by up to ${digits(100 * pressed(t), 2)} % of the ${topName(t)}’s radius; simple laws ` +
      `of contact are meant for less than ${inPercent(SHALLOW)}.`,
    (t) => ({ compression: pressed(t) }),
  ],
];

// ---- the story: slowly, through the contact ----------------------------------------------------------------

const restitution = ({ drop: { scenario } }: StoryFacts): string => String(Number(scenario.restitution.toPrecision(3)));
const restitutionNumbers = ({ drop: { scenario: s } }: StoryFacts): Numbers => ({
  restitution: s.restitution,
  ...(constantsOf(s).includes("impact_speed") && { impact_speed: s.constants.impact_speed }),
});
const statedAt = ({ drop: { scenario } }: StoryFacts): string =>
  constantsOf(scenario).includes("impact_speed") ? ` at ${withUnit(scenario.constants.impact_speed, "m/s")}` : "";
const lone: Row<StoryFacts>[] = [
  [
    "lone",
    (t) => t.drop.lone !== null,
    (t) => {
      const { arrives, leaves, end } = t.drop.lone!;
      return (
        `Drop the ${lowName(t)} alone: it meets the floor with ${speed(arrives)}, is pressed together, and ` +
        `leaves with ${speed(leaves)}. That takes ${duration(end)}, not an instant.`
      );
    },
    ({ drop: { lone } }) => ({ arrives: lone!.arrives, leaves: lone!.leaves, end: lone!.end }),
  ],
];
const restitutionRows: Row<StoryFacts>[] = [
  [
    "restitution-cradle",
    cradle,
    (t) =>
      `The coefficient of restitution ε is the share of their relative speed that two balls keep in a ` +
      `collision${statedAt(t)}: 1 loses nothing, 0 keeps them together. Here ε = ${restitution(t)}.`,
    restitutionNumbers,
  ],
  [
    "restitution",
    always,
    (t) =>
      `The coefficient of restitution ε is the share of its speed that a ball keeps in a collision with the ` +
      `floor${statedAt(t)}: 1 loses nothing, 0 stays down. Here ε = ${restitution(t)}; move the slider.`,
    restitutionNumbers,
  ],
];

// Whether the upper of two balls touches the lower one while the floor pushes it.
function meetsOnFloor(t: StoryFacts): boolean {
  const { newton, icm } = t.drop;
  const { floor, first } = contactFacts({ balls: count(t), cradle: cradle(t), newton: newton.run, icm: icm.run });
  return count(t) === 2 && floor !== undefined && first < floor.end;
}
const leavesOut: Row<StoryFacts>[] = [
  [
    "out-unanswered",
    (t) => !answered(t),
    () => "Newton’s equations have no answer here, so the textbook cannot be judged.",
  ],
  ["out-no-contact", (t) => t.drop.newton.run.nContacts === 0, () => "No two balls touch here in time to be compared."],
  [
    "out-floor",
    (t) => overlapping(t) > 0 && meetsOnFloor(t),
    (t) =>
      `The textbook lets the ${lowName(t)} finish its bounce before the ${topName(t)} arrives. By Newton’s equations ` +
      `the floor pushes the ${lowName(t)} while the balls touch: two contacts last at the same time, which a rule ` +
      "for one collision after the other cannot describe.",
  ],
  [
    "out-many",
    (t) => overlapping(t) > 0,
    () => "Several contacts last at the same time; the textbook takes them one after another.",
  ],
  ["out-nothing", always, () => "No two contacts last at the same time here."],
];
// How much slower the lower ball is when the upper one meets it.
const slower: Row<StoryFacts>[] = [
  [
    "out-slower",
    (t) => {
      const { meets, lone } = t.drop;
      return answered(t) && overlapping(t) > 0 && meetsOnFloor(t) && lone !== null && meets < 0.99 * lone.leaves;
    },
    (t) => {
      const { meets, lone } = t.drop;
      const way = meets < 0 ? "still moves down with" : "moves up with only";
      return (
        `When they first touch, the ${lowName(t)} ${way} ${speed(Math.abs(meets))}; alone it would leave the floor ` +
        `with ${speed(lone!.leaves)}.`
      );
    },
    ({ drop: { meets, lone } }) => ({ meets, leaves: lone!.leaves }),
  ],
];
const forceRows: Row<StoryFacts>[] = [
  [
    "forces-cradle",
    cradle,
    () => "F₁₂ is the force between the first ball and the second. Move through the film and watch it.",
  ],
  [
    "forces",
    always,
    (t) =>
      `F₀₁ is the force of the floor on the ${lowName(t)}, F₁₂ that between the ${lowName(t)} and the ` +
      `${count(t) === 2 ? topName(t) : "next ball"}. Move through the film and watch both.`,
  ],
];

const touch = ({ drop: { scenario, newton } }: StoryFacts): string =>
  `At ε = ${Number(scenario.restitution.toPrecision(3))} ` +
  `${scenario.balls.length === 2 ? "the balls" : "neighbouring balls"} touch ${times(newton.run.nContacts)}` +
  (newton.run.meetsAgain ? " before the lowest ball is back on the floor" : "");
const counts = ({ drop: { newton, icm } }: StoryFacts): Numbers => ({
  newton: newton.run.nContacts,
  icm: icm.run.nContacts,
});
const countAgain = "The bands show when they touch, for every ε: drag the line to another ε, and count again.";
const asOften = "as often as in the collision model";
const countRows: Row<StoryFacts>[] = [
  [
    "count-without-end",
    ({ drop: { icm } }) => [outcomes.collapse, outcomes.atRest].includes(icm.run.outcome),
    (t) => `${touch(t)}; the collision model counts without end. ${countAgain}`,
    counts,
  ],
  [
    "count-too-many",
    ({ drop: { icm } }) => icm.run.outcome === outcomes.unresolved,
    (t) => `${touch(t)}; the collisions of the collision model become too many to count. ${countAgain}`,
    counts,
  ],
  [
    "count-differs",
    ({ drop: { newton, icm } }) => newton.run.nContacts !== icm.run.nContacts,
    (t) => `${touch(t)}; the collision model counts ${counted(t.drop.icm.run.nContacts, "collision")}. ${countAgain}`,
    counts,
  ],
  [
    "count-overlaps",
    (t) => overlapping(t) > 0,
    (t) => {
      const single = t.drop.newton.run.nContacts === 1;
      const verb = overlapping(t) === 1 ? "overlaps" : "overlap";
      const which = single ? "the contact overlaps" : `${spell(overlapping(t))} of the contacts ${verb}`;
      return `${touch(t)}, ${asOften}; but here ${which} another one in time. ${countAgain}`;
    },
    (t) => ({ ...counts(t), overlapping: overlapping(t) }),
  ],
  ["count-same", always, (t) => `${touch(t)}, ${asOften}. ${countAgain}`, counts],
];

const changeGap = "Drag in the plot to change the gap.";
const measured =
  `${changeGap} Other balls, measured in Bristol in 2015, did the same: ` + "closer together they rebounded lower.";
const touching = (t: StoryFacts): string => `Let go touching, the ${topName(t)} reaches ${metres(t.gaps!.touching)}`;
const gap: Row<StoryFacts>[] = [
  [
    "gap-cradle",
    cradle,
    () =>
      "Drag in the plot to change the gaps between the balls: the wider they are, " +
      "the more they collide one after the other.",
  ],
  ["gap-unknown", (t) => !t.gaps || !has(t.gaps.touching) || !has(t.gaps.best), () => changeGap],
  [
    "gap-none-better",
    (t) => t.gaps!.best <= t.gaps!.touching * (1 + t.report.tolerance),
    (t) => `${touching(t)}; no gap of this curve brings it more than ${agreement(t)} higher. ${changeGap}`,
    (t) => ({ touching: t.gaps!.touching, tolerance: t.report.tolerance }),
  ],
  [
    "gap-better",
    always,
    (t) => {
      const [low, high] = lengths(t.gaps!.touching, t.gaps!.best);
      return `Let go touching, the ${topName(t)} reaches ${low}; ${withUnit(t.gaps!.at, "m", 2)} apart, ${high}. ${measured}`;
    },
    (t) => ({ ...t.gaps! }),
  ],
];

const noHeights = "We know no published heights of these balls together; your own can be loaded in the laboratory.";
const experiment: Row<StoryFacts>[] = [
  [
    "alone",
    (t) => alone(t) !== null,
    (t) => {
      const { low, high, by } = alone(t)!;
      return (
        `${noHeights} Alone, the ${topName(t)} would come back to ${metres(low)} to ${metres(high)}, ` +
        `by the bounce that the rules of the game (${by}) ask of it.`
      );
    },
    (t) => ({ low: alone(t)!.low, high: alone(t)!.high }),
  ],
  ["no-experiment", always, () => noHeights],
];

const tolerance = (t: StoryFacts): Numbers => ({ tolerance: t.report.tolerance });
const widest = (t: StoryFacts): Numbers => ({ ...tolerance(t), widest: t.trusted!.widest });
const overlapsHere = (t: StoryFacts): string => {
  const [n, k] = [t.drop.newton.run.nContacts, overlapping(t)];
  return `Of the ${counted(n, "contact")} of these balls ${k === 1 ? "one overlaps" : `${spell(k)} overlap`} another one.`;
};
const colours: Row<StoryFacts>[] = [
  [
    "colours",
    (t) => count(t) === 2 && !cradle(t),
    () =>
      "Event-driven simulation computes many grains as the textbook does two: one collision after the other. " +
      "Each point of the map is a drop with its own ε and gap. Its colour compares: the effective restitution ε_eff " +
      "is the ε with which the textbook’s balls would separate as fast as Newton’s do. At ε_eff/ε = 1 the textbook " +
      "is right. Choose points.",
  ],
];
const map: Row<StoryFacts>[] = [
  [
    "map-cradle",
    cradle,
    () =>
      "The map counts contacts. Event-driven simulation takes them one after another, as if no two of them " +
      "overlapped in time.",
  ],
  [
    "map-many-unanswered",
    (t) => count(t) > 2 && !(answered(t) && t.drop.newton.run.nContacts > 0),
    () =>
      "The map counts contacts, of which any two may overlap in time. Event-driven simulation takes them one after " +
      "another.",
  ],
  [
    "map-many",
    (t) => count(t) > 2,
    (t) =>
      "The map counts contacts, of which any two may overlap in time. Event-driven simulation takes them one after " +
      `another. ${overlapsHere(t)}`,
    (t) => ({ contacts: t.drop.newton.run.nContacts, overlapping: overlapping(t) }),
  ],
  [
    "map-pending",
    (t) => t.trusted === null,
    (t) => `The line will show from which gap on both models agree to ${agreement(t)}.`,
    tolerance,
  ],
  [
    "map-unknown",
    (t) => Number.isNaN(t.trusted!.gap),
    (t) =>
      `The line shows from which gap on both models agree to ${agreement(t)}. At the present ε there is none: at the ` +
      `widest gap, ${withUnit(t.trusted!.widest, "m", 2)}, there is nothing to compare.`,
    widest,
  ],
  [
    "map-nowhere",
    (t) => t.trusted!.gap === Infinity,
    (t) =>
      `At the present ε the models agree to ${agreement(t)} at none of the gaps tried, ` +
      `the widest being ${withUnit(t.trusted!.widest, "m", 2)}. Choose another tolerance, or stiffer balls.`,
    widest,
  ],
  [
    "map-not-at-the-top",
    (t) => t.trusted!.gap < 0,
    (t) =>
      `At the present ε the models agree to ${agreement(t)} at a gap of ${withUnit(-t.trusted!.gap, "m", 2)}, but not ` +
      `at the widest one, ${withUnit(t.trusted!.widest, "m", 2)}. So the map has no line above which they agree.`,
    (t) => ({ ...widest(t), gap: -t.trusted!.gap }),
  ],
  [
    "map",
    always,
    (t) =>
      `Above the line both models agree to ${agreement(t)}; at the present ε that takes a gap above ` +
      `${withUnit(t.trusted!.gap, "m", 2)}. Just below the line they differ by more.`,
    (t) => ({ ...tolerance(t), gap: t.trusted!.gap }),
  ],
];

// What the reader can say at the end.
const contactsLast = "What you have seen: a contact takes time.";
const seen: Row<StoryFacts>[] = [
  [
    "seen-floor",
    (t) => answered(t) && overlapping(t) > 0 && meetsOnFloor(t),
    (t) => {
      const n = t.drop.newton.run.nContacts;
      return (
        `${contactsLast} The ${topName(t)} arrives while the floor still pushes the ${lowName(t)}, before the first ` +
        `contact has ended${n > 1 ? `, and the two touch ${times(n)}` : ""}. The textbook has one collision after the ` +
        "other. It can be relied on only where each contact has ended before the next begins."
      );
    },
    (t) => ({ contacts: t.drop.newton.run.nContacts }),
  ],
  [
    "seen-many",
    (t) => answered(t) && overlapping(t) > 0,
    () =>
      `${contactsLast} Here several last at the same time; the textbook has one collision after the other. It can be ` +
      "relied on only where each contact has ended before the next begins.",
  ],
  [
    "seen-apart",
    (t) => answered(t) && t.drop.newton.run.nContacts > 0,
    () => `${contactsLast} Here no two last at the same time, which is what the textbook takes for granted.`,
  ],
];

// A chapter on an outcome for which it has no words of its own says what the laboratory says.
function headline(t: StoryFacts, step: Step): Sentence[] {
  const said = step === "predict" && has(newton(t)) ? predicted(t).trim() : "";
  const guess = said ? [{ id: "guess", text: said, numbers: { guess: t.guess! } }] : [];
  return [t.report.newton[0], ...t.report.icm, ...guess];
}

// The sentences on the result, and the verdict after heights that agree.
function result(rows: Row<StoryFacts>[], t: StoryFacts): Sentence[] {
  const first = chosen(rows, t)!;
  return first.id.endsWith("-agree") && doubted(t) ? [first, t.report.verdict!] : [first];
}

// The paragraphs of each chapter.
const chapters: Record<Step, (t: StoryFacts) => Sentence[][]> = {
  predict: (t) =>
    over(t) && !bothPlain(t) ? [headline(t, "predict"), []] : [result(predict, t), over(t) ? allOf(bands, t) : []],
  watch: (t) => [allOf(worlds, t), bothPlain(t) ? result(watch, t) : headline(t, "watch")],
  slow: (t) => [
    [...allOf(lone, t), chosen(restitutionRows, t)!],
    t.report.why, // the report's reasons
    [chosen(leavesOut, t)!, ...allOf(slower, t), chosen(forceRows, t)!],
  ],
  count: (t) => [
    [
      ...allOf(otherBalls, t),
      ...(answered(t) && t.drop.newton.run.nContacts > 0 ? [chosen(countRows, t)!] : headline(t, "count")),
    ],
  ],
  gap: (t) => [
    [...allOf(otherBalls, t), chosen(gap, t)!],
    [...(cradle(t) ? [] : [chosen(experiment, t)!]), ...allOf(bands, t)],
  ],
  map: (t) => {
    const about = [...allOf(otherBalls, t), ...allOf(colours, t)];
    const last = chosen(seen, t);
    return [...(about.length > 0 ? [about, [chosen(map, t)!]] : [[chosen(map, t)!], []]), last ? [last] : []];
  },
};
export const paragraphs = (step: Step, t: StoryFacts): Sentence[][] => chapters[step](t);
export const story = (step: Step, t: StoryFacts): Sentence[] => paragraphs(step, t).flat();

const titles: Record<Step, string> = {
  predict: "How high will it fly?",
  watch: "One bounce, two models",
  slow: "Slowly, through the contact",
  count: "Count the contacts",
  gap: "Change the gap",
  map: "Where event-driven simulation may be trusted",
};

export const titleOf = (step: Step, onCradle: boolean): string =>
  onCradle && step === "predict" ? "How fast will the last one leave?" : titles[step];
