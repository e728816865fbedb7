// Reads the TOML file of a column for `hardlimit drop`. Unknown, missing or invalid entries are refused in one line.
// Values outside the ranges of the page are moved to the nearest limit, and what the page cannot show is omitted, with
// a note.
import { parse as parseToml, TomlError } from "smol-toml";
import { parse, unitsOf } from "../support/format";
import {
  constants,
  densityFor,
  GRAVITY,
  laws,
  MOST_BALLS,
  paper,
  ranges,
  settle,
  within,
  type Ball,
  type Range,
  type Scenario,
} from "./scenario";
import { parameterOfColumn, raised, type Law, type Quantity } from "./tables";

// Takes the name for messages and the value of an entry, and returns the value to use.
type Check<T> = (name: string, value: unknown) => T;
type Checks = Record<string, Check<unknown>>;
type Table = Record<string, unknown>;

function refuse(name: string, what: string, must: string): never {
  throw new Error(`${name}: ${what}, must be ${must}`.replace(/\s+/g, " "));
}

function got(value: unknown): string {
  const shown =
    typeof value === "string" ? `“${value}”` : typeof value === "object" ? JSON.stringify(value) : String(value);
  return value === undefined ? "missing" : `got ${shown.slice(0, 60)}`;
}

const flag: Check<boolean> = (name, value) =>
  typeof value === "boolean" ? value : refuse(name, got(value), "true or false");
const entries: Check<Table> = (name, value) =>
  typeof value === "object" && !Array.isArray(value) ? (value as Table) : refuse(name, got(value), "a table");
const listOf =
  <T>(check: Check<T>): Check<T[]> =>
  (name, value) =>
    Array.isArray(value) ? value.map((x, i) => check(`${name}[${i}]`, x)) : refuse(name, got(value), "a list");
const oneOrListOf =
  <T>(check: Check<T>): Check<T | T[]> =>
  (name, value) =>
    (Array.isArray(value) ? listOf(check) : check)(name, value);

const table =
  <C extends Checks>(checks: C): Check<{ [K in keyof C]?: ReturnType<C[K]> }> =>
  (name, value) => {
    const checked = Object.entries(entries(name, value)).map(([key, x]) => {
      const whole = name ? `${name}.${key}` : key;
      if (!Object.hasOwn(checks, key))
        refuse(whole, "unknown to this page", `one of ${Object.keys(checks).join(", ")}`);
      return [key, checks[key](whole, x)];
    });
    return Object.fromEntries(checked);
  };

// A number in SI units, or a text with a unit that the page's fields accept, within the range of the core.
const quantity =
  (r: Range, { lowest, highest }: Quantity, notes: string[]): Check<number> =>
  (name, value) => {
    const x = typeof value === "string" ? parse(raised(value), r.unit) : typeof value === "number" ? value : NaN;
    const units = [...unitsOf(r.unit).keys()];
    if (!Number.isFinite(x))
      refuse(
        name,
        got(value),
        r.unit === ""
          ? "a number"
          : `a number in ${r.unit}${units.length > 1 ? `, or a text with ${units.join(", ")}` : ""}`,
      );
    const low = lowest ?? -Infinity;
    if (x < low || (x === low && !r.zero) || x > (highest ?? Infinity))
      refuse(name, got(value), `${r.zero ? "≥" : ">"} ${low}${highest === null ? "" : ` and ≤ ${highest}`}`);
    return within(r, name, x, notes);
  };

const parameter = (name: keyof typeof ranges & string, notes: string[]): Check<number> =>
  quantity(ranges[name], parameterOfColumn(name), notes);

const ball =
  (notes: string[]): Check<Ball> =>
  (name, value) => {
    const { radius, density, mass } = table({
      radius: parameter("radius", notes),
      density: parameter("density", notes),
      mass: parameter("mass", notes),
    })(name, value);
    if (radius === undefined) return refuse(`${name}.radius`, "missing", "given");
    if ((density === undefined) === (mass === undefined))
      refuse(`${name}.density | mass`, mass === undefined ? "missing" : "got both", "exactly one of them");
    return { radius, density: density ?? densityFor(mass!, radius) };
  };

const lawTable =
  (notes: string[]): Check<{ law: Law; values: Record<string, number> }> =>
  (name, value) => {
    const { name: lawName, ...parameters } = entries(name, value);
    const law =
      laws.find((l) => l.name === lawName) ??
      refuse(`${name}.name`, got(lawName), `one of ${laws.map((l) => l.name).join(", ")}`);
    const checks = law.parameters.map((p) => [
      p.name,
      quantity(p.name === "restitution" ? ranges.restitution : constants[p.name].range, p, notes),
    ]);
    const values = table<Record<string, Check<number>>>(Object.fromEntries(checks))(name, parameters) as Record<
      string,
      number
    >;
    for (const p of law.parameters) if (!(p.name in values)) refuse(`${name}.${p.name}`, "missing", "given");
    return { law, values };
  };

// eslint-disable-next-line @typescript-eslint/explicit-function-return-type -- that of the table of checks
const column = (notes: string[]) =>
  table({
    balls: listOf(ball(notes)),
    cradle: flag,
    height: parameter("height", notes),
    gravity: quantity(
      { low: 0, high: Infinity, log: false, unit: "m/s²", zero: true },
      parameterOfColumn("gravity"),
      notes,
    ),
    gaps: oneOrListOf(parameter("gap", notes)),
    velocities: oneOrListOf(parameter("velocity", notes)),
    law: lawTable(notes),
    laws: listOf(lawTable(notes)),
  });

// Throws an Error whose message is one line.
export function fromToml(text: string, notes: string[]): Scenario {
  const {
    balls = [],
    cradle = false,
    height,
    gravity,
    gaps,
    velocities = 0,
    law,
    laws: each,
  } = column(notes)("", contentOf(text));
  const n = balls.length;
  const contacts = cradle ? n - 1 : n;
  const lawTables = each ?? (law ? [law] : []);
  const rules: [boolean, string, string, string][] = [
    [n < 2 || n > MOST_BALLS, "balls", got(n), `2 to ${MOST_BALLS} tables [[balls]] on this page`],
    [cradle && height !== undefined, "height", got(height), "left out for a cradle"],
    [cradle && (gravity ?? 0) !== 0, "gravity", got(gravity), "0 or left out for a cradle"],
    [!cradle && height === undefined, "height", "missing", "the height [m] of the lowest centre at release"],
    [!cradle && gaps === undefined, "gaps", "missing", `a list of ${n - 1}`],
    [!law === !each, "law | laws", law ? "got both" : "missing", "one [law], or one [[laws]] for each contact"],
    [
      lawTables.length !== 1 && lawTables.length !== contacts,
      "laws",
      got(lawTables.length),
      `1 or ${contacts} tables [[laws]]`,
    ],
    [
      lawTables.some((g) => g.law !== lawTables[0].law),
      "laws",
      got(lawTables.map((g) => g.law.name)),
      "the same law for all contacts on this page",
    ],
  ];
  for (const [wrong, ...refusal] of rules) if (wrong) refuse(...refusal);
  if (!cradle && gravity !== undefined && gravity !== GRAVITY)
    notes.push(`gravity = ${gravity} m/s² is not ${GRAVITY} m/s², which this page uses`);
  const s: Scenario = {
    ...paper(),
    cradle,
    balls,
    gaps: repeated("gaps", gaps ?? 0, n - 1),
    velocities: repeated("velocities", velocities, n),
    law: lawTables[0].law.name,
  };
  if (height !== undefined) s.height = height;
  for (const { name } of lawTables[0].law.parameters) {
    const [first, ...others] = lawTables.map((g) => g.values[name]);
    const alike = others.every((x) => x === first);
    if (name === "restitution") {
      s.restitution = first;
      if (!alike) notes.push(`restitution: the contacts differ, and this page has one value: ${first} used`);
    } else {
      s.constants[name] = first;
      if (!alike) s.own[name] = others;
    }
  }
  settle(s, notes);
  return s;
}

function repeated(name: string, values: number | number[], count: number): number[] {
  if (typeof values === "number") return Array.from({ length: count }, () => values);
  return values.length === count ? values : refuse(name, got(values), `a list of ${count}`);
}

function contentOf(text: string): Table {
  try {
    return parseToml(text);
  } catch (error) {
    if (!(error instanceof TomlError)) throw error;
    const [what] = error.message.replace(/^.*?: /, "").split("\n");
    throw new Error(`not valid TOML: ${what} (at line ${error.line}, column ${error.column})`);
  }
}
