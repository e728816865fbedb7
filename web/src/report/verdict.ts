// The verdict on event-driven simulation of this column, in the words of hl.compare(column).verdict. The answer and its
// numbers come from the core.
import type { Comparison } from "../core/core";
import type { Track } from "../core/drop";
import type { Case, Numbers } from "./sentence";

export interface VerdictFacts extends Comparison {
  newtonRun: Track["run"];
  icmRun: Track["run"];
  floor: boolean;
}

const before = (f: VerdictFacts): string => (f.floor ? " before the second floor contact" : "");
const outcome = (run: Track["run"]): string => run.message.split(":")[0];

export const verdictCases: Case<VerdictFacts>[] = [
  {
    id: "newton-unclear",
    when: (f) => f.ground === "newton-unclear",
    say: (f) => `No verdict: the outcome of Newton’s equations is “${outcome(f.newtonRun)}”.`,
  },
  {
    id: "independent-unclear",
    when: (f) => f.ground === "independent-unclear",
    say: (f) => `No verdict: the outcome of the event-driven model is “${outcome(f.icmRun)}”.`,
  },
  {
    id: "no-contact",
    when: (f) => f.ground === "no-contact",
    say: () => "No verdict: the balls do not meet before the second floor contact.",
  },
  {
    id: "newton-at-rest",
    when: (f) => f.ground === "newton-at-rest",
    say: () => "No: under Newton’s equations a contact never ends, but event-driven collisions are instantaneous.",
  },
  {
    id: "collapse",
    when: (f) => f.ground === "collapse",
    say: () =>
      "No: the event-driven sequence ends in an inelastic collapse, infinitely many collisions in a finite time; that of Newton’s equations does not.",
  },
  {
    id: "independent-at-rest",
    when: (f) => f.ground === "independent-at-rest",
    say: () =>
      "No: the event-driven sequence comes to rest by infinitely many collisions in a finite time; that of Newton’s equations does not.",
  },
  {
    id: "only-newton-meets",
    when: (f) => f.ground === "only-newton-meets",
    say: (f) => `No: the balls meet under Newton’s equations but not in the event-driven model${before(f)}.`,
  },
  {
    id: "only-independent-meets",
    when: (f) => f.ground === "only-independent-meets",
    say: (f) => `No: the balls meet in the event-driven model but not under Newton’s equations${before(f)}.`,
  },
  {
    id: "by-luck",
    when: (f) => f.answer === "by luck",
    say: (f) => `Only by luck: ${contacts(f)}, yet ${difference(f)}.`,
    numbers,
  },
  { id: "yes", when: (f) => f.answer === "yes", say: (f) => `Yes: ${contacts(f)}, and ${difference(f)}.`, numbers },
  {
    id: "no",
    when: () => true,
    say: (f) => `No: ${contacts(f)}${f.overlapping ? ";" : ", yet"} ${difference(f)}.`,
    numbers,
  },
];

function numbers(f: VerdictFacts): Numbers {
  return {
    overlapping: f.overlapping,
    contacts: f.newtonRun.nContacts,
    error: f.error,
    independent: f.independent,
    newton: f.newton,
    tolerance: f.tolerance,
  };
}

function contacts(f: VerdictFacts): string {
  return (
    overlaps(f.overlapping, f.newtonRun.nContacts) +
    (f.later ? ", under one model the last one follows the second floor contact" : "")
  );
}

function overlaps(overlap: number, n: number): string {
  if (overlap === 0) return "no contacts overlap in time";
  const number = overlap < n ? `${overlap} of ${n}` : n === 1 ? "the" : n === 2 ? "both" : `all ${n}`;
  return `${number} ball–ball contact${n > 1 ? "s" : ""} ${overlap === 1 || n === 1 ? "overlaps" : "overlap"} another contact in time`;
}

function difference(f: VerdictFacts): string {
  if (f.ground === "newton-touches-again")
    return "under Newton’s equations the second floor contact begins before the balls separate";
  if (f.ground === "independent-touches-again")
    return "in the event-driven model the second floor contact begins before the balls separate";
  const what = f.ball < 0 ? "separation velocity" : `final velocity of ball ${f.ball + 1}`;
  return f.error <= f.tolerance
    ? `the event-driven ${what} is right to ${roundedUp(f.error)}`
    : `the event-driven ${what} is ${both(f.independent, f.newton)}`;
}

// Two velocities with as many digits as needed to differ.
function both(a: number, b: number): string {
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
export function general(x: number, n: number): string {
  if (x === 0) return Object.is(x, -0) ? "-0" : "0";
  const [mantissa, power] = x.toExponential(n - 1).split("e");
  const exponent = Number(power);
  const bare = (text: string): string => (text.includes(".") ? text.replace(/\.?0+$/, "") : text);
  if (exponent >= -4 && exponent < n) return bare(x.toFixed(Math.max(n - 1 - exponent, 0)));
  return `${bare(mantissa)}e${exponent < 0 ? "-" : "+"}${String(Math.abs(exponent)).padStart(2, "0")}`;
}
