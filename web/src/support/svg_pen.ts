// An SVG picture drawn with the calls of a canvas: those that the plots of this page make, and no others.
// No library is used: svgcanvas 2.6.0 takes 24 kB minified and needs a document; this takes 3 kB.

interface Style {
  fillStyle: string;
  strokeStyle: string;
  lineWidth: number;
  lineJoin: string;
  globalAlpha: number;
  font: string;
  textAlign: string;
  textBaseline: string;
  imageSmoothingEnabled: boolean;
  dash: number[];
  clipped: string; // id of the clip path; "": none
}

const first: Style = {
  fillStyle: "#000000",
  strokeStyle: "#000000",
  lineWidth: 1,
  lineJoin: "miter",
  globalAlpha: 1,
  font: "10px sans-serif",
  textAlign: "start",
  textBaseline: "alphabetic",
  imageSmoothingEnabled: true,
  dash: [],
  clipped: "",
};
const anchors: Record<string, string> = { center: "middle", right: "end", end: "end" };
// Shift of the baseline, relative to the size of the text. Programs differ in `dominant-baseline`.
const shifts: Record<string, number> = { middle: 0.35, top: 0.8, bottom: -0.2 };

export const escaped = (text: string): string =>
  text.replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]!);

type Attributes = Record<string, string | number>;
const element = (name: string, attributes: Attributes, content = ""): string =>
  `<${name}${Object.entries(attributes)
    .map(([key, value]) => ` ${key}="${typeof value === "number" ? value : escaped(value)}"`)
    .join("")}${content ? `>${content}</${name}>` : "/>"}`;
const short = (x: number): number => Number(x.toFixed(3));

export class SvgPen {
  private readonly parts: string[] = [];
  private readonly saved: Style[] = [];
  private clips = 0;
  private path = "";

  // `measure`: width of a text in a CSS font [px].
  constructor(
    private readonly width: number,
    private readonly height: number,
    private readonly measure: (text: string, font: string) => number,
  ) {
    Object.assign(this, first);
  }
  private get style(): Style {
    return this as unknown as Style;
  }

  // `title` and `description` are read by screen readers; `ground` fills the picture.
  toString(title: string, description: string, ground: string): string {
    const { width, height } = this;
    const texts = element("title", {}, escaped(title)) + element("desc", {}, escaped(description));
    const back = element("rect", { width, height, fill: ground });
    const xmlns = "http://www.w3.org/2000/svg";
    const attributes = { xmlns, width, height, viewBox: `0 0 ${width} ${height}`, role: "img" };
    return element("svg", attributes, `\n${[texts, back, ...this.parts].join("\n")}\n`) + "\n";
  }

  save(): void {
    const kept = { ...first };
    for (const key of Object.keys(first) as (keyof Style)[]) Object.assign(kept, { [key]: this.style[key] });
    this.saved.push(kept);
  }
  restore(): void {
    Object.assign(this, this.saved.pop());
  }
  setLineDash(dash: number[]): void {
    this.style.dash = dash;
  }
  clearRect(): void {
    this.parts.length = 0;
  }
  measureText(text: string): { width: number } {
    return { width: this.measure(text, this.style.font) };
  }

  beginPath(): void {
    this.path = "";
  }
  moveTo(x: number, y: number): void {
    this.go("M", x, y);
  }
  lineTo(x: number, y: number): void {
    this.go(this.path ? "L" : "M", x, y);
  }
  private go(how: string, x: number, y: number): void {
    if (Number.isFinite(x + y)) this.path += `${how}${short(x)} ${short(y)}`;
  }
  rect(x: number, y: number, w: number, h: number): void {
    this.path += `M${short(x)} ${short(y)}h${short(w)}v${short(h)}h${short(-w)}z`;
  }
  // Only whole circles.
  arc(x: number, y: number, radius: number): void {
    const [left, d] = [short(x - radius), short(2 * radius)];
    if (Number.isFinite(left + y))
      this.path += `M${left} ${short(y)}a${radius} ${radius} 0 1 0 ${d} 0a${radius} ${radius} 0 1 0 ${-d} 0`;
  }
  closePath(): void {
    this.path += "z";
  }
  clip(): void {
    const id = `clip${++this.clips}`;
    this.parts.push(element("clipPath", { id }, element("path", { d: this.path })));
    this.style.clipped = id;
  }

  fill(): void {
    this.put("path", { d: this.path, ...this.filled() });
  }
  stroke(): void {
    if (this.path) this.put("path", { d: this.path, ...this.stroked() });
  }
  fillRect(x: number, y: number, w: number, h: number): void {
    this.put("rect", { ...boxOf(x, y, w, h), ...this.filled() });
  }
  fillText(text: string, x: number, y: number): void {
    this.write(text, x, y, this.filled());
  }
  strokeText(text: string, x: number, y: number): void {
    this.write(text, x, y, this.stroked());
  }
  drawImage(image: HTMLCanvasElement, x: number, y: number, w: number, h: number): void {
    const sharp: Attributes = this.style.imageSmoothingEnabled ? {} : { style: "image-rendering:pixelated" };
    this.put("image", { ...boxOf(x, y, w, h), preserveAspectRatio: "none", ...sharp, href: image.toDataURL() });
  }

  private filled(): Attributes {
    return { fill: this.style.fillStyle };
  }
  private stroked(): Attributes {
    const { strokeStyle, lineWidth, lineJoin, dash } = this.style;
    const dashes: Attributes = dash.length > 0 ? { "stroke-dasharray": dash.map(short).join(" ") } : {};
    return {
      fill: "none",
      stroke: strokeStyle,
      "stroke-width": short(lineWidth),
      "stroke-linejoin": lineJoin,
      ...dashes,
    };
  }
  private write(text: string, x: number, y: number, look: Attributes): void {
    const { font, textAlign, textBaseline } = this.style;
    const [, weight = "400", size = "10", family = font] = /^(?:(\d+) )?([\d.]+)px (.*)$/.exec(font) ?? [];
    const place = { x: short(x), y: short(y + (shifts[textBaseline] ?? 0) * Number(size)) };
    const anchor: Attributes = anchors[textAlign] ? { "text-anchor": anchors[textAlign] } : {};
    this.put(
      "text",
      { ...place, ...anchor, "font-family": family, "font-size": size, "font-weight": weight, ...look },
      text,
    );
  }
  private put(name: string, attributes: Attributes, text = ""): void {
    const { globalAlpha, clipped } = this.style;
    const alpha: Attributes = globalAlpha === 1 ? {} : { opacity: globalAlpha };
    const clip: Attributes = clipped ? { "clip-path": `url(#${clipped})` } : {};
    this.parts.push(element(name, { ...attributes, ...alpha, ...clip }, escaped(text)));
  }
}

const boxOf = (x: number, y: number, width: number, height: number): Attributes => ({
  x: short(x),
  y: short(y),
  width: short(width),
  height: short(height),
});
