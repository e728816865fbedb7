// Colours of the canvases, read from the style sheet, and the colours of maps.
export interface Theme {
  dark: boolean;
  ground: string;
  ink: string;
  muted: string;
  line: string;
  faint: string;
  newton: string;
  icm: string;
  balls: string[];
  pairs: string[]; // F01, F12, …
  font: string;
}

// The computed color-scheme does not show this: with forced colours it is always "light dark".
const isDark = (root: HTMLElement): boolean => root.dataset.theme === "dark";

// A colour of the style sheet. As the text of a property light-dark(…, …) is not resolved.
export const colorOf = (root: HTMLElement, name: string, dark = isDark(root)): string =>
  getComputedStyle(root)
    .getPropertyValue(`--${name}`)
    .trim()
    .replace(/^light-dark\((.*),\s*(.*)\)$/, dark ? "$2" : "$1");

export function themeOf(root: HTMLElement, dark = isDark(root)): Theme {
  const css = getComputedStyle(root);
  const get = (name: string): string => colorOf(root, name, dark);
  return {
    dark,
    ground: get("ground"),
    ink: get("ink"),
    muted: get("muted"),
    line: get("line"),
    faint: get("faint"),
    newton: get("newton"),
    icm: get("icm"),
    balls: [1, 2, 3, 4, 5, 6].map((i) => get(`ball${i}`)),
    pairs: [0, 1, 2, 3, 4, 5].map((i) => get(`pair${i}`)),
    font: css.fontFamily,
  };
}

export type Rgb = [number, number, number];

// OKLCH → sRGB; lightness alone orders the colours, so they can be distinguished without colour vision.
function oklch(l: number, c: number, hue: number): Rgb {
  const h = (hue * Math.PI) / 180;
  const a = c * Math.cos(h);
  const b = c * Math.sin(h);
  const cube = (x: number): number => x * x * x;
  const p = cube(l + 0.3963377774 * a + 0.2158037573 * b);
  const q = cube(l - 0.1055613458 * a - 0.0638541728 * b);
  const r = cube(l - 0.0894841775 * a - 1.291485548 * b);
  const linear = [
    4.0767416621 * p - 3.3077115913 * q + 0.2309699292 * r,
    -1.2684380046 * p + 2.6097574011 * q - 0.3413193965 * r,
    -0.0041960863 * p - 0.7034186147 * q + 1.707614701 * r,
  ];
  return linear.map((x) => {
    const y = Math.min(Math.max(x, 0), 1);
    return Math.round(255 * (y <= 0.0031308 ? 12.92 * y : 1.055 * y ** (1 / 2.4) - 0.055));
  }) as Rgb;
}

export const MOST_COUNTED = 15;

// 0 … 15 contacts: dark to light, purple over orange to straw.
const counts: Rgb[] = Array.from({ length: MOST_COUNTED + 1 }, (_, n) => {
  if (n === 0) return [44, 46, 50] as Rgb;
  const t = (n - 1) / (MOST_COUNTED - 1);
  const eased = t ** 0.8;
  return oklch(0.36 + 0.59 * eased, 0.055 + 0.115 * Math.sin(Math.PI * (1 - 0.88 * eased)), -80 + 180 * eased);
});

export const countColor = (n: number): Rgb => counts[Math.min(Math.max(Math.round(n), 0), MOST_COUNTED)];

// ε_eff/ε from 0 (dark) to 1 (light); above 1, where gravity acts during the contact, a quiet grey-blue.
const ratios: Rgb[] = Array.from({ length: 101 }, (_, i) =>
  oklch(0.22 + 0.7 * (i / 100), 0.05 + 0.09 * Math.sin((Math.PI * i) / 100), 265 - 165 * (i / 100)),
);
const above: Rgb = [176, 196, 208];

export const ratioColor = (x: number): Rgb => (x > 1.0000001 ? above : ratios[Math.round(100 * Math.max(x, 0))]);

export const invalidColor: Rgb = [128, 128, 128];
export const noRatioColor: Rgb = counts[0];
// By luck between yes and no in lightness; in the order of the core's answers.
export const verdictColors: Rgb[] = [oklch(0.88, 0.07, 230), oklch(0.66, 0.1, 250), oklch(0.36, 0.1, 40), invalidColor];
export const css = ([r, g, b]: Rgb): string => `rgb(${r} ${g} ${b})`;
export const inkOn = ([r, g, b]: Rgb): string => (0.299 * r + 0.587 * g + 0.114 * b > 140 ? "#14161a" : "#ffffff");
