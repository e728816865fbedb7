// Sentences of a page, as text and as numbers. Rows of a table choose them.

export type Numbers = Record<string, number>;

export interface Sentence {
  id: string;
  text: string;
  numbers: Numbers; // those that the text states, in SI units
}

// A row of a table: `when` is its condition; `text` also takes the numbers as they are shown.
export type Row<F> = readonly [
  id: string,
  when: (f: F) => boolean,
  text: (f: F, shown: Record<string, string>) => string,
  numbers?: (f: F) => Numbers,
];

export const always = (): boolean => true;

// The sentence of the first row whose condition holds.
export function chosen<F>(
  rows: readonly Row<F>[],
  facts: F,
  show: (name: string, x: number) => string = (_, x) => String(x),
): Sentence | null {
  const row = rows.find(([, when]) => when(facts));
  if (!row) return null;
  const numbers = row[3]?.(facts) ?? {};
  const shown = Object.fromEntries(Object.entries(numbers).map(([name, x]) => [name, show(name, x)]));
  return { id: row[0], text: row[2](facts, shown), numbers };
}

// The sentences of all rows whose condition holds.
export const allOf = <F>(rows: readonly Row<F>[], facts: F): Sentence[] =>
  rows.flatMap((row) => chosen([row], facts) ?? []);

export const joined = (sentences: readonly Sentence[]): string => sentences.map((s) => s.text).join(" ");
