// What is rarely needed, loaded at the first use.
export { toCommand, toPython } from "../scenario/snippets";
export { curveCsv, mapCsv } from "./tables_csv";
export { SvgPen } from "../support/svg_pen";
export { isLocal, qrPicture } from "./qr";
export { embedCode, titles } from "./embed";
export { worksheet } from "./worksheet";
export { ContactSound } from "./sound";
