// Reads measured bounce heights from a CSV file:
//
//   gap (mm), height (m), uncertainty (m)
//   0, 1.02, 0.03
//   5, 1.31
//
// The first line names the columns and their units. One column is gap, restitution or ratio (R1/R2); `height` is that
// of the top ball's centre above the floor; the column `uncertainty` and its values are optional. Units of lengths are
// m (the default), cm, mm, µm or um. Columns are separated by commas, semicolons or tabs; the last two allow a decimal
// comma. Empty lines and lines that begin with # are ignored.
import type { CurveAxis } from "../scenario/story_view";

export interface Measured {
  x: number;
  height: number; // m
  uncertainty: number; // m, 0 if it is missing
}

export interface Measurements {
  axis: CurveAxis;
  list: Measured[];
}

const axisOf: Record<string, CurveAxis> = { gap: "gap", restitution: "e", ratio: "ratio" };
const units: Record<string, number> = { m: 1, cm: 0.01, mm: 1e-3, µm: 1e-6, μm: 1e-6, um: 1e-6 };
const mostLines = 10_000;

interface Column {
  name: string;
  factor: number;
}

// Throws an Error whose message names the line and the fault.
export function readMeasurements(text: string): Measurements {
  const lines = text
    .replace(/^\uFEFF/, "")
    .split(/\r?\n/)
    .map((content, i) => ({ content: content.trim(), number: i + 1 }));
  const filled = lines.filter((line) => line.content !== "" && !line.content.startsWith("#"));
  if (filled.length === 0)
    throw new Error(
      "measurements: the file is empty; its first line must name the columns, as in “gap (mm), height (m)”",
    );
  if (filled.length > mostLines)
    throw new Error(`measurements: got ${filled.length} lines, must be at most ${mostLines}`);
  const separator = ["\t", ";", ","].find((s) => filled[0].content.includes(s)) ?? ",";
  const columns = filled[0].content.split(separator).map((cell) => readColumn(cell, filled[0].number));
  const place = (name: string): number => columns.findIndex((c) => c.name === name);
  const x = columns.findIndex((c) => c.name in axisOf);
  if (x < 0)
    throw new Error(
      `line ${filled[0].number}: got the columns ${columns.map((c) => c.name).join(", ")}; one must be gap, ` +
        `restitution or ratio`,
    );
  if (place("height") < 0)
    throw new Error(
      `line ${filled[0].number}: got the columns ${columns.map((c) => c.name).join(", ")}; one must be height`,
    );
  const list = filled.slice(1).map(({ content, number }) => {
    const cells = content.split(separator);
    if (cells.length > columns.length)
      throw new Error(
        `line ${number}: got ${cells.length} values, must be at most ${columns.length}, as many as columns`,
      );
    const value = (column: number, fallback: number): number =>
      column < 0 ? fallback : readValue(cells[column] ?? "", columns[column], separator, number, fallback);
    return { x: value(x, NaN), height: value(place("height"), NaN), uncertainty: value(place("uncertainty"), 0) };
  });
  if (list.length === 0) throw new Error("measurements: there is no line of values below the names of the columns");
  return { axis: axisOf[columns[x].name], list };
}

function readColumn(cell: string, line: number): Column {
  const match = /^([a-z]+)\s*(?:[([]\s*(\S+?)\s*[)\]])?$/i.exec(cell.trim().replace(/^"(.*)"$/, "$1"));
  const name = match?.[1].toLowerCase() ?? "";
  if (!(name in axisOf) && name !== "height" && name !== "uncertainty")
    throw new Error(
      `line ${line}: got the column “${cell.trim().slice(0, 30)}”, must be gap, restitution, ratio, height or ` +
        `uncertainty, with its unit in brackets`,
    );
  const plain = name === "restitution" || name === "ratio";
  const unit = match![2] ?? (plain ? "1" : "m");
  if (plain ? unit !== "1" : !(unit in units))
    throw new Error(
      `line ${line}: got the unit “${unit.slice(0, 10)}” for ${name}, must be ${plain ? "none" : "m, cm, mm or µm"}`,
    );
  return { name, factor: plain ? 1 : units[unit] };
}

function readValue(cell: string, column: Column, separator: string, line: number, fallback: number): number {
  const plain = cell.trim().replace(/^"(.*)"$/, "$1");
  if (plain === "" && !Number.isNaN(fallback)) return fallback;
  const text = separator === "," ? plain : plain.replace(",", ".");
  const x = text === "" ? NaN : Number(text) * column.factor;
  const positive = column.name === "height" || column.name === "ratio";
  const most = column.name === "restitution" ? 1 : Infinity;
  if (!Number.isFinite(x) || x < 0 || (positive && x === 0) || x > most)
    throw new Error(
      `line ${line}, ${column.name}: got “${plain.slice(0, 20)}”, must be a number ` +
        `${positive ? "above 0" : most === 1 ? "from 0 to 1" : "not below 0"}`,
    );
  return x;
}
