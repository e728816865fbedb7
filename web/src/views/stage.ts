// The animation: the balls at true scale beside a close-up, both worlds at the same time and on the same scale.
import type { Drop } from "../core/drop";
import { CloseUp } from "./close_up";
import { lettering } from "../support/plot";
import type { Moment, Rect } from "./painter";
import type { Theme } from "../style/theme";
import { TrueScale } from "./true_scale";

export function drawStage(g: CanvasRenderingContext2D, w: number, h: number, d: Drop, m: Moment, theme: Theme): void {
  g.clearRect(0, 0, w, h);
  const size = Math.max(
    Math.min(Math.max(w / 42, 14), Math.max(18, Math.min(w / 52, h / 26))),
    Math.min(lettering.least, w / 38, h / 20),
  );
  const pad = 6;
  const stacked = d.scenario.cradle || (w < 480 && w < 1.3 * h);
  const trueShare = d.scenario.cradle ? 0.42 : stacked ? 0.47 : 0.37;
  const first: Rect = stacked
    ? { x: pad, y: 0, w: w - 2 * pad, h: h * trueShare }
    : { x: pad, y: 0, w: w * trueShare, h };
  const second: Rect = stacked
    ? { x: pad, y: h * trueShare + 6, w: w - 2 * pad, h: h * (1 - trueShare) - 6 }
    : { x: first.x + first.w + 18, y: 0, w: w - first.x - first.w - 24, h };
  new TrueScale(g, d, m, theme, size).draw(first, "True scale, metres", "Metres");
  new CloseUp(g, d, m, theme, size).draw(second);
}
