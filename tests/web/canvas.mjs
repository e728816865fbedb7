// A canvas that records what is drawn on it, for tests of pictures without a browser.

const pixels = (font) => Number(/(\d+(?:\.\d+)?)px/.exec(font)?.[1] ?? 10);

// Records in the order of drawing: {kind: "fill" | "stroke" | "text" | …, path, color, clip, …}. All numbers are
// finite.
export class Canvas {
  drawn = [];
  path = [];
  clips = [];
  saved = [];
  font = "10px sans";
  globalAlpha = 1;

  note(kind, more) {
    this.drawn.push({ kind, alpha: this.globalAlpha, clip: this.clips.at(-1) ?? null, ...more });
  }
  check(...numbers) {
    for (const x of numbers) if (!Number.isFinite(x)) throw new Error(`a canvas is told ${x}`);
  }

  save() {
    this.saved.push(this.clips.length);
  }
  restore() {
    this.clips.length = this.saved.pop();
  }
  beginPath() {
    this.path = [];
  }
  closePath() {}
  moveTo(x, y) {
    this.check(x, y);
    this.path.push({ move: true, x, y });
  }
  lineTo(x, y) {
    this.check(x, y);
    this.path.push({ x, y });
  }
  rect(x, y, w, h) {
    this.check(x, y, w, h);
    this.path.push({ x, y }, { x: x + w, y }, { x: x + w, y: y + h }, { x, y: y + h });
  }
  arc(x, y, radius) {
    this.check(x, y, radius);
    if (radius < 0) throw new Error(`a circle of radius ${radius}`);
    this.path.push({ x, y, radius });
  }
  clip() {
    this.clips.push(this.path);
  }
  fill() {
    this.note("fill", { path: this.path, color: this.fillStyle });
  }
  stroke() {
    this.note("stroke", { path: this.path, color: this.strokeStyle, width: this.lineWidth });
  }
  fillRect(x, y, w, h) {
    this.check(x, y, w, h);
    this.note("rect", { x, y, w, h, color: this.fillStyle });
  }
  strokeRect(x, y, w, h) {
    this.check(x, y, w, h);
  }
  clearRect() {}
  drawImage() {}
  putImageData() {}
  setLineDash(list) {
    this.check(...list);
  }
  // Mean width of a sans serif font.
  measureText(text) {
    return { width: 0.56 * pixels(this.font) * [...text].length };
  }
  fillText(text, x, y) {
    this.check(x, y);
    const { width } = this.measureText(text);
    const height = pixels(this.font);
    const left = x - { left: 0, center: 0.5, right: 1 }[this.textAlign ?? "left"] * width;
    const top = y - { top: 0, middle: 0.5, bottom: 1 }[this.textBaseline ?? "bottom"] * height;
    this.note("text", { text, left, top, right: left + width, bottom: top + height, color: this.fillStyle });
  }
  strokeText(text, x, y) {
    this.check(x, y);
  }
}

export const theme = {
  dark: false,
  ground: "#fff",
  ink: "#000",
  muted: "muted",
  line: "line",
  faint: "faint",
  newton: "newton",
  icm: "icm",
  font: "sans",
  balls: [1, 2, 3, 4, 5, 6].map((i) => `ball${i}`),
  pairs: [0, 1, 2, 3, 4, 5].map((i) => `pair${i}`),
};

// Intersections of a horizontal line with a closed path, from left to right.
export function crossings(path, y) {
  const places = [];
  path.forEach((a, i) => {
    const b = path[(i + 1) % path.length];
    if (a.y <= y !== b.y <= y) places.push(a.x + ((y - a.y) / (b.y - a.y)) * (b.x - a.x));
  });
  return places.sort((a, b) => a - b);
}
