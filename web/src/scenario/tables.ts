// Records of the core: laws, parameters of a column, models. build.mjs inserts the tables here.
export interface Quantity {
  name: string;
  unit: string; // "1": a plain number
  meaning: string;
  lowest: number | null; // null: infinite
  highest: number | null;
}

export interface Law {
  name: string;
  alternative: number;
  parameters: Quantity[]; // in the order of the core's column, with the restitution
}

export interface ModelNames {
  name: string;
  label: string;
  short: string;
}

declare const TABLES: { laws: Law[]; swept: Quantity[]; models: ModelNames[] };
export const { laws, swept, models } = TABLES;

const named = <T extends { name: string }>(list: T[], name: string): T => {
  const record = list.find((item) => item.name === name);
  if (!record) throw new Error(`the core knows no ${name}`);
  return record;
};

export const parameterOfColumn = (name: string): Quantity => named(swept, name);

// The models that the page shows.
export const newton = named(models, "newton");
export const independent = named(models, "independent");
export const namesOf = { newton, icm: independent };

export const capital = (s: string): string => s[0].toUpperCase() + s.slice(1);

// "restitution ε at impact_speed; every contact …" → "Restitution ε".
export const labelOf = (q: Quantity): string =>
  capital(
    q.meaning
      .split(/[;,(]| at (?:release|[a-z]+_[a-z]+)/)[0]
      .trim()
      .replace("'", "’"),
  );

// The symbol at the end of a label, as in "Mass m"; "": there is none.
export const symbolOf = (q: Quantity): string => /\s(\S{1,2})$/u.exec(labelOf(q))?.[1] ?? "";

// "kg/m3", "kg/m^3" → "kg/m³".
export const raised = (text: string): string =>
  text.replace(/(?<=[a-z])\^?([23])(?![.\d])/g, (_, n) => (n === "2" ? "²" : "³"));

// The unit of a record; "1" → "".
export const unitOf = (q: Quantity): string => (q.unit === "1" ? "" : raised(q.unit));
