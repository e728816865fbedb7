// A link as a QR code.
import encodeQR from "qr";

const ns = "http://www.w3.org/2000/svg";

export const svgElement = (name: string, attributes: Record<string, string | number>, text = ""): SVGElement => {
  const element = document.createElementNS(ns, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  element.textContent = text;
  return element;
};

// Dark fields of the code, by rows; a margin of four fields belongs to it.
export const qrFields = (text: string): boolean[][] => encodeQR(text, "raw", { ecc: "low", border: 4 });

// Black on white in every theme, because cameras expect it.
export function qrPicture(text: string): SVGElement {
  const fields = qrFields(text);
  const side = fields.length;
  const d = fields.flatMap((row, y) => row.flatMap((dark, x) => (dark ? [`M${x} ${y}h1v1h-1z`] : []))).join("");
  const label = "QR code of the link";
  const picture = svgElement("svg", { viewBox: `0 0 ${side} ${side}`, class: "qr", role: "img", "aria-label": label });
  picture.append(
    svgElement("rect", { width: side, height: side, fill: "#fff" }),
    svgElement("path", { d, fill: "#000" }),
  );
  return picture;
}

// Whether a link leads to the reader's own computer, where nobody else can open it.
export const isLocal = (link: string): boolean =>
  /^(localhost|127\.\d+\.\d+\.\d+|\[::1\])$/.test(new URL(link).hostname) || new URL(link).protocol === "file:";
