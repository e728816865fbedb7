// Reads the TOML file of a column, as `hardlimit drop` does: tables, arrays of tables, numbers, texts with units, lists.
import { parse } from "../support/format";
import { densityFor, laws, MOST_BALLS, constants, paper, settle, type Scenario } from "./scenario";

type Value = number | boolean | string | Value[];
type Table = Record<string, Value>;

interface File {
  top: Table;
  balls: Table[];
  laws: Table[];
}

// Throws an Error whose message is one line.
export function fromToml(text: string, notes: string[]): Scenario {
  const { top, balls, laws: given } = tablesOf(text);
  if (balls.length < 2 || balls.length > MOST_BALLS) throw new Error(`balls: got ${balls.length}, must be 2 to ${MOST_BALLS} on this page`);
  const s = paper();
  s.cradle = top.cradle === true;
  const gravity = quantity(top, "gravity", "m/s²", s.cradle ? 0 : 9.81);
  if (gravity !== (s.cradle ? 0 : 9.81)) notes.push(`gravity = ${gravity} m/s² is not 9.81 m/s², which this page uses`);
  if (!s.cradle) s.height = quantity(top, "height", "m");
  s.balls = balls.map((b) => {
    const radius = quantity(b, "radius", "m");
    return { radius, density: "mass" in b ? densityFor(quantity(b, "mass", "kg"), radius) : quantity(b, "density", "kg/m³") };
  });
  s.gaps = list(top.gaps ?? 0, "m", balls.length - 1, "gaps");
  s.velocities = list(top.velocities ?? 0, "m/s", balls.length, "velocities");
  readLaws(s, given, notes);
  settle(s, notes);
  return s;
}

function readLaws(s: Scenario, given: Table[], notes: string[]): void {
  const contacts = s.balls.length - (s.cradle ? 1 : 0);
  if (given.length !== 1 && given.length !== contacts) throw new Error(`law | laws: got ${given.length}, must be one [law], or ${contacts} [[laws]]`);
  const law = laws.find((l) => l.name === given[0].name);
  if (!law) throw new Error(`law.name: got ${String(given[0].name)}, must be one of ${laws.map((l) => l.name).join(", ")}`);
  s.law = law.name;
  s.own = {};
  for (const p of law.parameters) {
    const values = given.map((table) => quantity(table, p.name, p.unit === "1" ? "" : p.unit));
    const alike = values.every((x) => x === values[0]);
    if (p.name === "restitution") {
      s.restitution = values[0];
      if (!alike) notes.push(`restitution: the contacts differ, and this page has one value: ${values[0]} used`);
    } else if (p.name in constants) {
      s.constants[p.name] = values[0];
      if (!alike && !s.cradle) s.own[p.name] = values.slice(1);
    }
  }
}

function quantity(table: Table, name: string, unit: string, fallback = NaN): number {
  const value = table[name] ?? fallback;
  const x = typeof value === "string" ? parse(value.replace(/\^?3$/, "³").replace(/\^?2$/, "²"), unit) : Number(value);
  if (!Number.isFinite(x)) throw new Error(`${name}: ${name in table ? `got ${String(value)}, must be a number${unit && ` in ${unit}`}` : "missing"}`);
  return x;
}

function list(value: Value, unit: string, count: number, name: string): number[] {
  const values = Array.isArray(value) ? value : Array.from({ length: count }, () => value);
  if (values.length !== count) throw new Error(`${name}: got ${values.length}, must be ${count}`);
  return values.map((x) => quantity({ [name]: x }, name, unit));
}

function tablesOf(text: string): File {
  const file: File = { top: {}, balls: [], laws: [] };
  let at = file.top;
  const joined = text.replace(/\[\s*\n[^\]]*\]/g, (lines) => lines.replace(/\n/g, " ")); // a list over several lines
  joined.split(/\r?\n/).forEach((content, i) => {
    const line = content.replace(/("[^"]*")|#.*/g, "$1").trim();
    const head = /^\[\[?\s*(\w+)\s*\]\]?$/.exec(line)?.[1];
    const [, key, value] = /^(\w+)\s*=\s*(.+)$/.exec(line) ?? [];
    if (head === "balls") file.balls.push((at = {}));
    else if (head === "law" || head === "laws") file.laws.push((at = {}));
    else if (key) at[key] = valueOf(value, i + 1);
    else if (line !== "") throw new Error(`line ${i + 1}: got “${line.slice(0, 30)}”, must be a table of a column or “name = value”`);
  });
  return file;
}

function valueOf(text: string, line: number): Value {
  const inner = /^\[(.*)\]$/.exec(text)?.[1];
  if (inner !== undefined) return inner.split(",").map((x) => x.trim()).filter((x) => x !== "").map((x) => valueOf(x, line));
  const quoted = /^"([^"]*)"$|^'([^']*)'$/.exec(text);
  if (quoted) return quoted[1] ?? quoted[2];
  if (text === "true" || text === "false") return text === "true";
  const x = Number(text.replaceAll("_", ""));
  if (!Number.isFinite(x)) throw new Error(`line ${line}: got “${text.slice(0, 30)}”, must be a number, a text, true, false or a list`);
  return x;
}
