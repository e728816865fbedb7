// The second chapter: the viewer sets a height on the ruler, lets the balls drop, and sees. It has a clock of its own.
import { find, setText, type Sheet } from "../support/dom";
import { Handle } from "../support/handle";
import type { LectureView } from "../scenario/lecture_view";
import type { State } from "../state/state";
import { highestGuess } from "../scenario/lecture_view";
import { releaseHeight, type Fall } from "./story_text";
import { drawTrueScale } from "../views/true_scale";
import { drawTale, rulerTop, type TaleLayout } from "./tale";

export class Guess {
  fall: Fall = "before";
  private fallen = 0; // s in real time since they were let go
  private last = 0; // ms
  private layout: TaleLayout | null = null;
  private readonly handle: Handle;

  constructor(
    private readonly state: State,
    private readonly view: LectureView,
    private readonly sheet: Sheet,
    private readonly moves: () => boolean,
    private readonly changed: () => void,
  ) {
    find("let-go").addEventListener("click", () => this.letGo());
    this.handle = new Handle(find("tale-box"), {
      label: "Height that I expect",
      range: { low: 0, high: highestGuess },
      value: () => view.guess ?? this.layout?.asked ?? 0,
      say: () => (view.guess === null ? "no guess yet" : `${view.guess} m`),
      set: (height) => this.set(height),
      perPixel: () => 1 / (this.layout?.scale ?? Infinity),
      size: () => (state.drop ? 5 * releaseHeight(state.drop) : 1),
    });
    // A press anywhere on the ruler.
    sheet.canvas.addEventListener("click", (e) => {
      if (this.layout && this.fall === "before") this.set((this.layout.floor - e.offsetY) / this.layout.scale);
    });
  }

  // Moves the balls; returns whether there is something new to draw.
  advance(now: number): boolean {
    const { state } = this;
    const passed = Math.min((now - this.last) / 1000, 0.1);
    this.last = now;
    if (this.fall !== "falling" || !state.drop || !this.sheet.seen) return false;
    this.fallen += this.moves() ? passed : Infinity;
    if (this.fallen > 0.97 * state.drop.realTime.length) this.fall = "over";
    return true;
  }

  draw(size: number): void {
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
      this.layout = drawTale(
        sheet.g,
        sheet.width,
        sheet.height,
        { drop, falling: this.fall !== "before", guess: view.guess, reached, ...balls },
        Math.min(Math.max(size, 14), sheet.width / 22),
        state.theme,
      );
    }
    this.placeHandle();
  }

  private placeHandle(): void {
    const { layout, view, sheet } = this;
    if (!layout || this.fall !== "before") return this.handle.place(null);
    const height = view.guess ?? layout.asked;
    this.handle.place({
      x: 0.5 * (layout.left + layout.right),
      y: Math.max(layout.floor - height * layout.scale, 0),
      width: Math.min(layout.right, sheet.width) - layout.left,
      height: 44,
    });
    this.handle.refresh();
  }

  private set(height: number): void {
    const top = this.state.drop ? rulerTop(this.state.drop, this.view.guess, false) : highestGuess;
    this.view.guess = Number(Math.min(Math.max(height, 0), top).toPrecision(2));
    this.state.writeLink();
    this.changed();
  }

  private letGo(): void {
    this.fall = this.fall === "before" ? "falling" : "before";
    this.fallen = 0;
    this.changed();
  }
}
