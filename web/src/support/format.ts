// Formats numbers with units.
const prefixes: [number, string][] = [
  [1e9, "G"],
  [1e6, "M"],
  [1e3, "k"],
  [1, ""],
  [1e-3, "m"],
  [1e-6, "µ"],
  [1e-9, "n"],
];
const prefixed = new Set(["m", "s", "N", "Pa", "J", "m/s", "N/m"]);
export const takesPrefix = (unit: string): boolean => prefixed.has(unit);
const others: Record<string, [string, number][]> = {
  m: [["cm", 1e-2]],
  kg: [
    ["g", 1e-3],
    ["mg", 1e-6],
  ],
};

export const trim = (text: string): string =>
  text.includes(".") && !text.includes("e") ? text.replace(/\.?0+$/, "") : text;

export function digits(x: number, n = 3): string {
  if (!Number.isFinite(x)) return "–";
  const size = Math.abs(x);
  if (size !== 0 && (size >= 1e5 || size < 1e-3)) {
    const [mantissa, exponent] = x.toExponential(n - 1).split("e");
    const power = [...String(Number(exponent))].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)])).join("");
    const m = trim(mantissa);
    return m === "1" ? `10${power}` : `${m}·10${power}`;
  }
  return minus(x.toPrecision(n).includes("e") ? String(Math.round(x)) : x.toPrecision(n));
}

export const minus = (text: string): string => text.replace("-", "−");

// 1e-4, "m" → "100 µm". Lengths may be in centimetres, masses in grams.
export function withUnit(x: number, unit: string, n = 3, keepZeros = false): string {
  if (!Number.isFinite(x)) return "–";
  const tidy = (v: number): string => {
    const text = v.toPrecision(n);
    const plain = text.includes("e") ? String(Number(text)) : text;
    return minus(keepZeros ? plain : trim(plain));
  };
  if (unit === "") return tidy(x);
  if (x === 0) return `0 ${unit}`;
  const size = Math.abs(x);
  if (unit === "kg")
    return size < 0.9999e-3 ? `${tidy(x * 1e6)} mg` : size < 0.9999 ? `${tidy(x * 1e3)} g` : `${tidy(x)} kg`;
  if (unit === "m/s" && size >= 0.9999e-2) return `${tidy(x)} m/s`;
  if (unit === "m" && size >= 0.9999e-2 && size < 0.9999) return `${tidy(x * 100)} cm`;
  if (!takesPrefix(unit)) return `${tidy(x)} ${unit}`;
  const [factor, prefix] = prefixes.find(([f]) => size >= 0.9999 * f) ?? prefixes[prefixes.length - 1];
  return `${tidy(x / factor)} ${prefix}${unit}`;
}

// Heights in metres.
export function metres(x: number): string {
  const size = Math.abs(x);
  return size >= 0.0995 ? `${minus(size < 99.95 ? x.toPrecision(3) : String(Math.round(x)))} m` : withUnit(x, "m");
}

// Two lengths in the same unit.
export function lengths(a: number, b: number): [string, string] {
  const large = Math.max(Math.abs(a) || 0, Math.abs(b) || 0);
  const text = (x: number): string =>
    !Number.isFinite(x)
      ? "–"
      : large >= 0.9999 && Math.abs(x) >= 0.01
        ? `${minus(x.toPrecision(3))} m`
        : withUnit(x, "m", 3, true);
  return [text(a), text(b)];
}

// The units that may follow a number, with their factors.
export const unitsOf = (unit: string): Map<string, number> =>
  new Map([
    ...(takesPrefix(unit) ? prefixes : prefixes.slice(3, 4)).map(([f, p]): [string, number] => [p + unit, f]),
    ...(others[unit] ?? []),
  ]);

// "0.1 mm" → 1e-4; a bare number is in the base unit. NaN if it is neither.
export function parse(text: string, unit: string): number {
  const match = /^\s*([-+−]?[\d.,]+(?:e[-+]?\d+)?)\s*(\S*)\s*$/i.exec(text.replace("·10^", "e"));
  if (!match) return NaN;
  const x = Number(match[1].replace("−", "-").replace(",", "."));
  const own = match[2].replace(/^[uμ](?=.)/, "µ") || unit;
  return x * (unitsOf(unit).get(own) ?? NaN);
}

const subscripts = "₀₁₂₃₄₅₆₇₈₉";
export const sub = (i: number): string => [...String(i)].map((c) => subscripts[Number(c)]).join("");

// Pair j joins body j and body j + 1; body 0 is the floor.
export const forceName = (pair: number): string => `F${sub(pair)}${sub(pair + 1)}`;

export function niceTicks(low: number, high: number, wanted: number): number[] {
  const raw = (high - low) / Math.max(wanted, 1);
  const base = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((m) => m * base).find((s) => s >= raw * 0.999) ?? 10 * base;
  const ticks: number[] = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++)
    ticks.push(Number((i * step).toPrecision(12)));
  return ticks;
}

export function logTicks(low: number, high: number): number[] {
  const ticks: number[] = [];
  for (let e = Math.ceil(Math.log10(low) - 1e-9); e <= Math.log10(high) + 1e-9; e++) ticks.push(10 ** e);
  if (ticks.length >= 3) return ticks;
  const halves: number[] = [];
  for (let e = Math.floor(Math.log10(low)); e <= Math.log10(high); e++)
    for (const m of [1, 2, 5])
      if (m * 10 ** e >= low * 0.999999 && m * 10 ** e <= high * 1.000001)
        halves.push(Number((m * 10 ** e).toPrecision(3)));
  if (halves.length >= 3) return halves;
  const linear = niceTicks(low, high, 5);
  return linear.length > 1 ? linear : ticks;
}

// 1, 2 or 5 times a power of ten, not above x.
export function niceBelow(x: number): number {
  const base = 10 ** Math.floor(Math.log10(x));
  return [5, 2, 1].map((m) => m * base).find((v) => v <= x * 1.0001) ?? base;
}
