// Elements of the page, and canvases at the screen's resolution.
import { later } from "./later";

export const find = <T extends HTMLElement>(id: string): T => document.getElementById(id) as T;

export const make = <K extends keyof HTMLElementTagNameMap>(
  name: K,
  properties: Partial<HTMLElementTagNameMap[K]> = {},
): HTMLElementTagNameMap[K] => Object.assign(document.createElement(name), properties);

// A canvas of this size at twice the screen's resolution.
export function sharpCanvas(width: number, height: number): [HTMLCanvasElement, CanvasRenderingContext2D] {
  const canvas = make("canvas", { width: 2 * width, height: 2 * height });
  const g = canvas.getContext("2d")!;
  g.scale(2, 2);
  return [canvas, g];
}

// Moves the focus to the bar above when the focused control disappears.
export const refocus = (): void => {
  const bar = find("panel-bar").hidden ? document.querySelector<HTMLElement>("#menu summary")! : find("panel-choice");
  bar.focus({ preventScroll: true });
};

// Setting an equal text would cost a layout.
export function setText(node: Node, text: string): void {
  if (node.textContent === text) return;
  const { firstChild } = node;
  if (firstChild instanceof Text && !firstChild.nextSibling) firstChild.data = text;
  else node.textContent = text;
}

export function setHidden(element: HTMLElement, hidden: boolean): void {
  if (element.hidden !== hidden) element.hidden = hidden;
}

export function setAttribute(element: Element, name: string, value: string): void {
  if (element.getAttribute(name) !== value) element.setAttribute(name, value);
}

const contents = new WeakMap<Element, string>();

// Whether an element had other contents until now; `key` stands for the new ones.
export function changes(element: Element, key: string): boolean {
  if (contents.get(element) === key) return false;
  contents.set(element, key);
  return true;
}

// A number and its unit, "1.28 m", or a subscript, "ε_eff".
const special = /(\d[\d.]* (?:[cmµn]?m(?:\/s)?|[mµn]?s|%)(?![\w/])|_[a-z]+)/;
const specialElement = (part: string): HTMLElement =>
  part.startsWith("_")
    ? Object.assign(document.createElement("sub"), { textContent: part.slice(1) })
    : Object.assign(document.createElement("span"), { className: "whole", textContent: part });

// Sets the text of an element without line breaks between numbers and units. Existing nodes are reused if possible,
// which costs less.
export function setSentence(element: HTMLElement, text: string): void {
  const parts = text.split(special);
  const old = element.childNodes;
  const kind = (part: string, i: number): string => (i % 2 === 0 ? "#text" : part.startsWith("_") ? "SUB" : "SPAN");
  if (old.length === parts.length && parts.every((part, i) => old[i].nodeName === kind(part, i)))
    parts.forEach((part, i) => setText(old[i], part.replace(/^_/, "")));
  else element.replaceChildren(...parts.map((part, i) => (i % 2 === 0 ? part : specialElement(part))));
}

// A canvas that fills its box at the screen's resolution.
export class Sheet {
  readonly canvas: HTMLCanvasElement;
  readonly g: CanvasRenderingContext2D;
  width = 0;
  height = 0;
  static printing = false;
  static inStory = false;
  private inWindow = false;
  private near = false; // within one window of it
  constructor(id: string, resized: () => void) {
    this.canvas = find<HTMLCanvasElement>(id);
    this.g = this.canvas.getContext("2d")!;
    later(() => this.observe(resized));
  }

  // Prepares the first picture without waiting for observers.
  open(): void {
    this.inWindow = true;
    this.measure();
  }

  private observe(resized: () => void): void {
    new ResizeObserver(() => {
      if (this.measure()) resized();
    }).observe(this.canvas.parentElement!);
    const watch = (rootMargin: string, see: (inside: boolean) => void): void => {
      new IntersectionObserver(
        (entries) => {
          see(entries[entries.length - 1].isIntersecting);
          resized();
        },
        { rootMargin },
      ).observe(this.canvas.parentElement!);
    };
    watch("0px", (inside) => {
      this.inWindow = inside;
      this.canvas.toggleAttribute("data-away", !inside);
    });
    watch("100%", (inside) => (this.near = inside));
  }
  get seen(): boolean {
    return this.inWindow || Sheet.printing;
  }
  // While a slider moves, canvases out of the window are not drawn.
  static moving = false;
  static readonly legible = 80; // time for which a number must be shown to be legible [ms]
  static often = 100; // time between updates of texts while a slider moves [ms]
  // Adapts the time between updates to the time that writing took [ms]: a slow machine writes less often.
  static wrote(took: number): void {
    Sheet.often = Math.min(Math.max(20 * took, 100), 300);
  }
  // Whether the canvas is displayed, even out of the window; in the story only near the window.
  readonly shown = (): boolean => this.width > 0 && (this.seen || (!Sheet.moving && (this.near || !Sheet.inStory)));

  // Whether its contents are computed. Some time after the last change this is so also far from the window, for
  // scrolling and printing.
  static idle = false;
  readonly wanted = (): boolean => this.shown() || (this.width > 0 && Sheet.idle);

  private measure(): boolean {
    const { clientWidth: w, clientHeight: h } = this.canvas.parentElement!;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const [pw, ph] = [Math.round(w * ratio), Math.round(h * ratio)];
    if (this.canvas.width === pw && this.canvas.height === ph) return false;
    this.canvas.width = pw;
    this.canvas.height = ph;
    this.width = w;
    this.height = h;
    this.g.setTransform(ratio, 0, 0, ratio, 0, 0);
    return true;
  }
}
