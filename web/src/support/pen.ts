// The canvas of a picture with its colours and the size of its letters [px], and what all pictures draw.
import type { Theme } from "../style/theme";

export interface Frame {
  left: number;
  top: number;
  width: number;
  height: number;
}

export class Pen {
  constructor(
    readonly g: CanvasRenderingContext2D,
    readonly theme: Theme,
    readonly size: number,
  ) {}

  // `scale`: of the letters, relative to those of the picture.
  font(scale = 1, weight = 400): void {
    this.g.font = `${weight} ${Math.round(this.size * scale)}px ${this.theme.font}`;
  }

  widthOf(text: string): number {
    return this.g.measureText(text).width;
  }

  text(
    text: string,
    x: number,
    y: number,
    color: string,
    align: CanvasTextAlign = "left",
    baseline: CanvasTextBaseline = "middle",
  ): void {
    this.place(align, baseline);
    this.g.fillStyle = color;
    this.g.fillText(text, x, y);
  }

  // Text with a halo, which is legible over other drawings.
  label(
    text: string,
    x: number,
    y: number,
    color: string,
    align: CanvasTextAlign = "center",
    baseline: CanvasTextBaseline = "middle",
    halo = this.theme.ground,
  ): void {
    this.place(align, baseline);
    this.g.lineWidth = 5;
    this.g.lineJoin = "round";
    this.g.strokeStyle = halo;
    this.g.strokeText(text, x, y);
    this.g.fillStyle = color;
    this.g.fillText(text, x, y);
  }

  private place(align: CanvasTextAlign, baseline: CanvasTextBaseline): void {
    this.g.textAlign = align;
    this.g.textBaseline = baseline;
  }

  line(x0: number, y0: number, x1: number, y1: number, color: string, width = 1, dash: number[] = []): void {
    this.stroked(color, width, dash, () => {
      this.g.moveTo(x0, y0);
      this.g.lineTo(x1, y1);
    });
  }

  // A line through points, interrupted where one is not finite.
  curve(points: readonly [number, number][], color: string, width: number, dash: number[] = []): void {
    this.stroked(color, width, dash, () => {
      let down = false;
      for (const [x, y] of points) {
        const known = Number.isFinite(x) && Number.isFinite(y);
        if (known && down) this.g.lineTo(x, y);
        else if (known) this.g.moveTo(x, y);
        down = known;
      }
    });
  }

  // The path of `trace` as a line.
  stroked(color: string, width: number, dash: number[], trace: () => void): void {
    const { g } = this;
    g.strokeStyle = color;
    g.lineWidth = width;
    g.setLineDash(dash);
    g.beginPath();
    trace();
    g.stroke();
    g.setLineDash([]);
  }

  // Fills a closed line.
  area(points: readonly [number, number][], color: string, alpha = 1): void {
    const { g } = this;
    g.beginPath();
    for (const point of points) g.lineTo(...point);
    g.fillStyle = color;
    g.globalAlpha = alpha;
    g.fill();
    g.globalAlpha = 1;
  }

  // A rectangle that lets something of what is below it through.
  veil(left: number, top: number, width: number, height: number, color: string, alpha: number): void {
    this.g.globalAlpha = alpha;
    this.g.fillStyle = color;
    this.g.fillRect(left, top, width, height);
    this.g.globalAlpha = 1;
  }

  // Draws within a frame only.
  within({ left, top, width, height }: Frame, draw: () => void): void {
    const { g } = this;
    g.save();
    g.beginPath();
    g.rect(left, top, width, height);
    g.clip();
    draw();
    g.restore();
  }
}

// The path of a diamond.
export function diamond(g: CanvasRenderingContext2D, x: number, y: number, half: number): void {
  g.beginPath();
  g.moveTo(x, y - half);
  g.lineTo(x + half, y);
  g.lineTo(x, y + half);
  g.lineTo(x - half, y);
  g.closePath();
}
