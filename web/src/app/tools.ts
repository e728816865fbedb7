// What is rarely needed, loaded at the first use.
export { toCommand, toPython } from "../scenario/snippets";
export { curveCsv, mapCsv } from "./tables_csv";
export { SvgPen } from "../support/svg_pen";
