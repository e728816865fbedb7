// The second chapter: the viewer predicts the rebound height on a ruler and lets the balls drop, with a clock of its
// own.
import { find, setText, type Sheet } from "../support/dom";
import { Handle } from "../support/handle";
import type { StoryView } from "../scenario/story_view";
import { observed, type Drawing } from "../state/signals";
import type { State } from "../state/state";
import { highestPrediction } from "../scenario/story_view";
import type { Fall } from "../report/facts";
import { releaseHeight } from "../scenario/scenario";
import { drawTrueScale } from "../views/true_scale";
import { drawPrediction, rulerTop, type PredictionLayout } from "./prediction_drawing";

export class Prediction {
  fall: Fall = "before";
  private fallen = 0; // real time since the balls were let go [s]
  readonly picture: Drawing;
  private last = 0; // ms
  private layout: PredictionLayout | null = null;
  private readonly handle: Handle;

  constructor(
    private readonly state: State,
    private readonly view: StoryView,
    private readonly sheet: Sheet,
    private readonly moves: () => boolean,
    private readonly textSize: () => number,
  ) {
    observed(this, ["fall", "fallen"]);
    this.picture = state.drawing(() => this.draw());
    find("let-go").addEventListener("click", () => this.letGo());
    this.handle = new Handle(find("prediction-box"), {
      label: "Height that I expect",
      range: { low: 0, high: highestPrediction },
      value: () => view.guess ?? this.layout?.promptHeight ?? 0,
      text: () => (view.guess === null ? "no guess yet" : `${view.guess} m`),
      set: (height) => this.set(height),
      perPixel: () => 1 / (this.layout?.scale ?? Infinity),
      size: () => (state.drop ? 5 * releaseHeight(state.drop.scenario) : 1),
    });
    // A press anywhere on the ruler.
    sheet.canvas.addEventListener("click", (e) => {
      if (this.layout && this.fall === "before") this.set((this.layout.floor - e.offsetY) / this.layout.scale);
    });
  }

  open(): void {
    this.sheet.open();
    this.picture.refresh();
  }

  // Moves the balls.
  advance(now: number): void {
    const { state } = this;
    const passed = Math.min((now - this.last) / 1000, 0.1);
    this.last = now;
    if (this.fall !== "falling" || !state.drop || !this.sheet.seen) return;
    this.fallen += this.moves() ? passed : Infinity;
    if (this.fallen > 0.97 * state.drop.realTime.length) this.fall = "over";
  }

  private draw(): void {
    const { state, sheet, view } = this;
    const drop = state.drop!;
    const button = { before: drop.scenario.cradle ? "Let it go" : "Let them drop", falling: "Stop", over: "Try again" }[
      this.fall
    ];
    setText(find("let-go"), button);
    if (sheet.width < 40 || !sheet.seen) return;
    const time =
      this.fall === "before" ? drop.start : this.fall === "over" ? drop.stop : drop.realTime.toPhysical(this.fallen);
    const balls = { newton: drop.motion.newton.at(time), icm: drop.motion.icm.at(time) };
    this.layout = null;
    if (drop.scenario.cradle) {
      sheet.g.clearRect(0, 0, sheet.width, sheet.height);
      drawTrueScale(
        sheet.g,
        { x: 0, y: 0, w: sheet.width, h: sheet.height },
        drop,
        { time, rate: 1, ...balls },
        state.theme,
        "",
      );
    } else {
      const reached = [drop.newton, drop.icm].map((t) =>
        this.fall === "over" ? t.peaks[t.peaks.length - 1] : NaN,
      ) as [number, number];
      this.layout = drawPrediction(
        sheet.g,
        sheet.width,
        sheet.height,
        { drop, falling: this.fall !== "before", guess: view.guess, reached, ...balls },
        Math.min(Math.max(this.textSize(), 14), sheet.width / 22),
        state.theme,
      );
    }
    this.placeHandle();
  }

  private placeHandle(): void {
    const { layout, view, sheet } = this;
    if (!layout || this.fall !== "before") return this.handle.place(null);
    const height = view.guess ?? layout.promptHeight;
    this.handle.place({
      x: 0.5 * (layout.left + layout.right),
      y: Math.max(layout.floor - height * layout.scale, 0),
      width: Math.min(layout.right, sheet.width) - layout.left,
      height: 44,
    });
    this.handle.refresh();
  }

  private set(height: number): void {
    const top = this.state.drop ? rulerTop(this.state.drop, this.view.guess, false) : highestPrediction;
    this.view.guess = Number(Math.min(Math.max(height, 0), top).toPrecision(2));
    this.state.writeLink();
  }

  private letGo(): void {
    this.fall = this.fall === "before" ? "falling" : "before";
    this.fallen = 0;
  }
}
