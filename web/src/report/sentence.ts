// A sentence of the page: what it says as text and as numbers. Tables of cases choose it.

export type Numbers = Record<string, number>;

export interface Sentence {
  id: string;
  text: string;
  numbers: Numbers; // those that the text states, in SI units
}

// One row of a table. The first row whose condition holds gives the sentence.
export interface Case<F> {
  id: string;
  when(f: F): boolean;
  say(f: F): string;
  numbers?(f: F): Numbers;
}

export function chosen<F>(cases: readonly Case<F>[], facts: F): Sentence | null {
  const found = cases.find((c) => c.when(facts));
  return found ? { id: found.id, text: found.say(facts), numbers: found.numbers?.(facts) ?? {} } : null;
}

// All rows whose condition holds, in order.
export const allOf = <F>(cases: readonly Case<F>[], facts: F): Sentence[] =>
  cases.filter((c) => c.when(facts)).map((c) => chosen([c], facts)!);

export const joined = (sentences: Sentence[]): string => sentences.map((s) => s.text).join(" ");
