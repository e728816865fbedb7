// Words for numbers in sentences.
import { withUnit } from "../support/format";

const numerals = [
  "no",
  "one",
  "two",
  "three",
  "four",
  "five",
  "six",
  "seven",
  "eight",
  "nine",
  "ten",
  "eleven",
  "twelve",
];
export const spell = (n: number): string => numerals[n] ?? String(n);
export const times = (n: number): string =>
  n === 0 ? "not at all" : n === 1 ? "once" : n === 2 ? "twice" : `${spell(n)} times`;
export const counted = (n: number, what: string): string => `${spell(n)} ${what}${n === 1 ? "" : "s"}`;
export const duration = (t: number): string => withUnit(Math.max(t, 0), "s");

// A pair of bodies by its number; 0 is the floor and the lowest ball.
export const bodiesOf = (pair: number): string =>
  pair === 0 ? "the floor and the lowest ball" : `ball ${spell(pair)} and ball ${spell(pair + 1)}`;
