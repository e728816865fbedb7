// A worksheet to print: the setting, a sketch, questions with space for answers, the link. It shows no answer.
import {
  clampTo,
  constantAt,
  constants,
  constantsOf,
  firstGap,
  GRAVITY,
  hasOwn,
  massOf,
  ranges,
  type Scenario,
} from "../scenario/scenario";
import { inPercent } from "../scenario/tolerance";
import { digits, sub, withUnit } from "../support/format";
import { qrPicture, svgElement } from "./qr";

export interface Question {
  text: string;
  lines: number; // space for the answer
  table?: string[][]; // to be filled in
  axes?: [x: string, y: string]; // of an empty diagram
}

const top = (s: Scenario): string => (s.balls.length === 2 ? "upper" : "top");

// Gaps to try, on both sides of the way that ball 2 falls during the floor contact.
const gapsToTry = (reach: number): number[] => [
  0,
  ...[0.01, 0.1, 1, 10].map((factor) => clampTo(ranges.gap, Number((factor * reach).toPrecision(1)))),
];

// `reach`: the way that ball 2 falls during the floor contact [m].
export function questionsOf(s: Scenario, tolerance: number, reach: number): Question[] {
  return [...(s.cradle ? cradle(s) : drop(s, gapsToTry(reach))), ...both(s, tolerance)];
}

function drop(s: Scenario, gaps: number[]): Question[] {
  const n = s.balls.length;
  const fall = `h − R${sub(1)} = ${withUnit(s.height - s.balls[0].radius, "m", 4)}`;
  return [
    {
      text:
        `The lowest point of ball 1 falls by ${fall}. With which speed v does the ball reach the floor ` +
        `(g = ${GRAVITY} m/s², no air)?`,
      lines: 2,
    },
    {
      text:
        `Textbook: every contact is one instant. Ball 1 leaves the floor with ε v while ball 2 still falls with v. ` +
        `Momentum is conserved, and the balls separate with ε times the speed at which they met. Which velocities do ` +
        `balls 1 and 2 have then?`,
      lines: 5,
    },
    {
      text:
        (n > 2 ? "Continue in the same way, pair by pair, up to the top. " : "") +
        `How high does the centre of the ${top(s)} ball rise? How many times the height of its release is that?`,
      lines: 3,
    },
    {
      text: "Before you look: what do you expect of real balls, which deform? Higher, lower, the same? Why?",
      lines: 3,
    },
    {
      text: "Open the page and let the balls drop. Read the heights of the top ball and the number of contacts.",
      lines: 0,
      table: [
        ["", "rises to (m)", "ball–ball contacts"],
        ["your calculation", "", ""],
        ["independent collisions", "", ""],
        ["Newton’s equations", "", ""],
      ],
    },
    {
      text:
        "Read from the plot of forces how long the floor contact lasts. When does ball 2 meet ball 1, counted from " +
        "the first touch of the floor? Is the floor contact over by then? What does the textbook leave out?",
      lines: 4,
    },
    {
      text: "Change the gap between the balls and read the height of the top ball.",
      lines: 0,
      table: [
        [s.gaps.length > 1 ? "all gaps" : "gap Δh", ...gaps.map((x) => (x > 0 ? withUnit(x, "m") : "0"))],
        ["Newton (m)", ...gaps.map(() => "")],
        ["independent collisions (m)", ...gaps.map(() => "")],
      ],
    },
    { text: "Draw both heights over the gap.", lines: 0, axes: ["gap (logarithmic)", "height (m)"] },
  ];
}

function cradle(s: Scenario): Question[] {
  const n = s.balls.length;
  return [
    {
      text:
        "Textbook: the contacts follow one another, each in one instant. Momentum is conserved, and two balls " +
        "separate with ε times the speed at which they met. Which velocities do balls 1 and 2 have after they met?",
      lines: 4,
    },
    { text: `Continue ball by ball. With which velocity does ball ${n} leave?`, lines: 4 },
    { text: "Before you look: do the other balls stay at rest, if they touch? Give a reason.", lines: 3 },
    {
      text: "Open the page and let the first ball go. Read the final velocities.",
      lines: 0,
      table: [
        ["", ...s.balls.map((_, i) => `ball ${i + 1} (m/s)`)],
        ["your calculation", ...s.balls.map(() => "")],
        ["independent collisions", ...s.balls.map(() => "")],
        ["Newton’s equations", ...s.balls.map(() => "")],
      ],
    },
    {
      text:
        "Read from the plot of forces which contacts last at the same time. What does the textbook calculation " +
        "leave out?",
      lines: 4,
    },
  ];
}

function both(s: Scenario, tolerance: number): Question[] {
  const gap = s.cradle && s.gaps.length > 1 ? "gap between the balls at rest" : "gap";
  return [
    {
      text:
        `From which ${gap} on, if any, do both models agree to ${inPercent(tolerance)}? Estimate it first from the duration of a ` +
        `contact and the speeds.`,
      lines: 3,
    },
    {
      text:
        "Make the contacts ten times as stiff. What changes in the duration of a contact, and what in the result? " +
        "Explain it.",
      lines: 4,
    },
    {
      text: "A program treats contacts of a thousand grains as instants. When may it? Write one rule.",
      lines: 3,
    },
  ];
}

const make = <K extends keyof HTMLElementTagNameMap>(name: K, text = "", className = ""): HTMLElementTagNameMap[K] =>
  Object.assign(document.createElement(name), { textContent: text, className });

function tableOf(rows: string[][], heads: boolean): HTMLTableElement {
  const table = make("table");
  rows.forEach((row, j) => {
    const tr = table.insertRow();
    row.forEach((text, i) => {
      const cell = make(heads && (j === 0 || i === 0) && text ? "th" : "td", text);
      if (cell instanceof HTMLTableCellElement && cell.tagName === "TH") cell.scope = j === 0 ? "col" : "row";
      tr.append(cell);
    });
  });
  return table;
}

function settingOf(s: Scenario): HTMLTableElement {
  const rows = s.balls.map((b, i) => [`Ball ${i + 1}`, withUnit(b.radius, "m", 4), withUnit(massOf(b), "kg", 4)]);
  return tableOf([["", "radius R", "mass m"], ...rows], true);
}

function valuesOf(s: Scenario): string {
  const contact = (i: number): string =>
    constantsOf(s)
      .map((name) => `${constants[name].symbol} = ${withUnit(constantAt(s, name, i), constants[name].range.unit, 4)}`)
      .join(", ");
  const contacts = hasOwn(s)
    ? s.balls.map((_, i) => `${i === 0 ? "floor" : `balls ${i} and ${i + 1}`}: ${contact(i)}`).join("; ")
    : contact(0);
  const gaps = s.gaps.slice(firstGap(s)).map((x) => (x > 0 ? withUnit(x, "m", 4) : "0"));
  const same = new Set(gaps).size === 1 ? gaps[0] : gaps.join(", ");
  return (
    `Coefficient of restitution ε = ${digits(s.restitution)}; gap Δh = ${same}; ` +
    (s.cradle
      ? `ball 1 arrives at ${withUnit(s.velocities[0], "m/s")}`
      : `height of the lowest centre h = ${withUnit(s.height, "m", 4)}`) +
    `. Contacts, ${s.law} law: ${contacts}.`
  );
}

// The balls at release, not to scale in height.
function sketch(s: Scenario): SVGElement {
  const largest = Math.max(...s.balls.map((b) => b.radius));
  const radii = s.balls.map((b) => 16 + (34 * b.radius) / largest);
  const between = 10;
  const length = radii.reduce((sum, r) => sum + 2 * r, 0) + between * s.gaps.length;
  const parts: SVGElement[] = [];
  const write = (text: string, x: number, y: number): void =>
    void parts.push(svgElement("text", { x, y, "font-size": 15, fill: "#000" }, text));
  const line = (x1: number, y1: number, x2: number, y2: number, dash = ""): void =>
    void parts.push(svgElement("line", { x1, y1, x2, y2, stroke: "#000", "stroke-dasharray": dash }));
  let at = s.cradle ? 10 : length + 4; // along the line, from the first or the lowest ball
  radii.forEach((r, i) => {
    const [cx, cy] = s.cradle ? [at + r, 60] : [60, at - r];
    parts.push(svgElement("circle", { cx, cy, r, fill: "#fff", stroke: "#000", "stroke-width": 2 }));
    write(String(i + 1), cx - 4, cy + 5);
    if (!s.cradle && i > 0) write(s.gaps.length > 1 ? `Δh${sub(i)}` : "Δh", 118, at + 0.5 * between + 5);
    at += (s.cradle ? 1 : -1) * (2 * r + between);
  });
  const height = s.cradle ? 120 : length + 84;
  if (!s.cradle) {
    const center = length + 4 - radii[0];
    line(0, height - 4, 160, height - 4);
    line(60, center, 150, center, "4 3");
    line(140, center, 140, height - 4);
    write("h", 146, 0.5 * (center + height));
    write("floor", 0, height - 10);
  }
  const width = s.cradle ? length + 20 : 170;
  const label = s.cradle
    ? "The balls in a row at release"
    : "The balls above the floor at release, not to scale in height";
  const picture = svgElement("svg", {
    viewBox: `0 0 ${width} ${height}`,
    class: "sketch",
    role: "img",
    "aria-label": label,
  });
  picture.append(...parts);
  return picture;
}

function diagram([x, y]: [string, string]): SVGElement {
  const lines = Array.from({ length: 11 }, (_, i) => `M${40 * i + 20} 20v200M20 ${20 * i + 20}h400`).join("");
  const label = "Empty diagram";
  const picture = svgElement("svg", { viewBox: "0 0 460 250", class: "diagram", role: "img", "aria-label": label });
  picture.append(
    svgElement("path", { d: lines, stroke: "#bbb", fill: "none" }),
    svgElement("path", { d: "M20 10V220H430", stroke: "#000", fill: "none" }),
    svgElement("text", { x: 26, y: 14, "font-size": 13 }, y),
    svgElement("text", { x: 300, y: 240, "font-size": 13 }, x),
  );
  return picture;
}

export function worksheet(s: Scenario, link: string, tolerance: number, reach: number): HTMLElement[] {
  const head = make("div", "", "sheet-head");
  const words = make("div");
  words.append(make("p", "Name: ____________________   Date: ______________"), settingOf(s), make("p", valuesOf(s)));
  head.append(sketch(s), words);
  const list = make("ol");
  for (const { text, lines, table, axes } of questionsOf(s, tolerance, reach)) {
    const item = make("li");
    item.append(make("p", text));
    if (table) item.append(tableOf(table, true));
    if (axes) item.append(diagram(axes));
    for (let i = 0; i < lines; i++) item.append(make("div", "", "line"));
    list.append(item);
  }
  const foot = make("div", "", "sheet-foot");
  const address = make("p", "The page with this setting: ");
  address.append(Object.assign(make("a", link), { href: link }));
  foot.append(qrPicture(link), address);
  return [make("h1", s.cradle ? "Newton’s cradle" : "A drop of stacked balls"), head, list, foot];
}
