// Elements of the page: finding them, canvases at the screen's resolution.

export const find = <T extends HTMLElement>(id: string): T => document.getElementById(id) as T;

// A canvas that fills its box at the screen's resolution.
export class Sheet {
  readonly canvas: HTMLCanvasElement;
  readonly g: CanvasRenderingContext2D;
  width = 0;
  height = 0;
  constructor(id: string, resized: () => void) {
    this.canvas = find<HTMLCanvasElement>(id);
    this.g = this.canvas.getContext("2d")!;
    this.measure();
    new ResizeObserver(() => {
      if (this.measure()) resized();
    }).observe(this.canvas.parentElement!);
  }
  // Whether there is anything to see of it, on the screen or beyond its edge.
  readonly shown = (): boolean => this.width > 0;

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
