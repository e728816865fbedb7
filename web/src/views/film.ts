// The film: its time, its controls and its drawing.
import { find, setAttribute, setText, Sheet } from "../support/dom";
import type { Drop } from "../core/drop";
import { drawStage } from "./stage";
import type { Drawing } from "../state/signals";
import type { State } from "../state/state";
import { independent, newton } from "../scenario/tables";
import { touchable } from "../support/touch";

export class Film {
  private shownFor = 0; // time for which the last picture has been shown [s]
  private written = -Infinity; // when the time was written [ms]
  readonly picture: Drawing;

  constructor(
    private readonly state: State,
    private readonly sheet: Sheet,
  ) {
    this.picture = state.drawing(() => this.draw());
    find("play").addEventListener("click", () => this.play(!state.playing));
    find("slow").addEventListener("click", () => this.setSlow(!state.view.slow));
    this.refresh();
    const scrubber = find<HTMLInputElement>("scrubber");
    touchable(scrubber);
    scrubber.addEventListener("input", () => {
      this.play(false);
      state.screen = (Number(scrubber.value) / 2000) * state.clock().length;
    });
    document.addEventListener("keydown", (e) => this.key(e));
  }

  open(): void {
    this.sheet.open();
    this.picture.refresh();
  }

  get seen(): boolean {
    return this.sheet.seen;
  }

  // Updates the buttons.
  refresh(): void {
    setText(find("play"), this.state.playing ? "Pause" : "Play");
    setAttribute(find("slow"), "aria-pressed", String(this.state.view.slow));
  }

  seek(time: number): void {
    if (!this.state.drop) return;
    this.state.screen = this.state.clock().toScreen(time);
    this.shownFor = 0;
  }

  play(on: boolean): void {
    const { state } = this;
    state.playing = on;
    this.shownFor = 0;
    if (on && state.drop && state.screen >= state.clock().length) state.screen = 0;
    this.refresh();
    state.writeLink();
  }

  private setSlow(on: boolean): void {
    const time = this.state.time();
    this.state.view.slow = on;
    this.refresh();
    this.seek(time);
    this.state.writeLink();
  }

  private step(by: number): void {
    const { state } = this;
    this.play(false);
    state.screen = Math.min(Math.max(state.screen + by, 0), state.clock().length);
  }

  // Keys of the film. A focused control that uses a key itself has precedence.
  private key(e: KeyboardEvent): void {
    const { state } = this;
    const target = e.target as HTMLElement;
    if (e.ctrlKey || e.metaKey || e.altKey || !state.drop || state.story.step) return; // in the story keys scroll
    const letter = e.key.length === 1;
    if (target.closest("input:not([type=range]), select, textarea")) return;
    if (target.closest(letter ? "button, a, summary" : "input, button, a, canvas[tabindex]")) return;
    const step = state.clock().length / 200;
    const actions: Record<string, () => void> = {
      " ": () => this.play(!state.playing),
      ArrowLeft: () => this.step(-step),
      ArrowRight: () => this.step(step),
      Home: () => this.step(-1e9),
      End: () => this.step(1e9),
      s: () => this.setSlow(!state.view.slow),
    };
    const action = actions[letter ? e.key.toLowerCase() : e.key];
    if (!action) return;
    e.preventDefault();
    action();
  }

  advance(passed: number): void {
    const { state } = this;
    const end = state.clock().length;
    if (state.screen < end) state.screen = Math.min(state.screen + passed, end);
    else {
      this.shownFor += passed;
      if (this.shownFor > 2.5) state.screen = this.shownFor = 0;
    }
  }

  private draw(): void {
    const { state, sheet } = this;
    if (!sheet.shown() || !(sheet.seen || !state.story.step)) return;
    if (sheet.seen) drawMoment(sheet.g, sheet.width, sheet.height, state);
    const now = performance.now();
    const runs = state.playing && state.screen < state.clock().length;
    if (runs && now - this.written < (Sheet.moving ? Sheet.often : Sheet.legible)) return;
    this.written = now;
    this.writeTime();
  }

  private writeTime(): void {
    const { state, sheet } = this;
    const d = state.drop!;
    const time = state.time();
    const rate = rateAt(state);
    const scrubber = find<HTMLInputElement>("scrubber");
    scrubber.value = String(Math.round((2000 * state.screen) / state.clock().length));
    const clock = clockText(time, d);
    setText(find("time"), `t = ${clock}`);
    const slower = 1 / rate;
    const speed =
      slower < 1.05
        ? "real time"
        : `${
            slower < 10
              ? slower.toFixed(1)
              : Math.round(Number(slower.toPrecision(2)))
                  .toLocaleString("en")
                  .replaceAll(",", " ")
          } × slower than real`;
    setText(find("speed"), speed);
    scrubber.setAttribute("aria-valuetext", `${clock}, ${speed}`);
    if (!state.playing || sheet.canvas.getAttribute("aria-label") === "Animation")
      sheet.canvas.setAttribute(
        "aria-label",
        `Animation at ${clock}: balls of ${newton.label} beside those of ${independent.label}`,
      );
  }
}

// How fast the film runs now: physical seconds per screen second.
export const rateAt = (state: State): number => (state.view.slow ? state.drop!.clock.rate(state.time()) : 1);

// Both models at the time of the film.
export function drawMoment(g: CanvasRenderingContext2D, w: number, h: number, state: State): void {
  const d = state.drop!;
  const time = state.time();
  const [newton, icm] = [d.motion.newton.at(time), d.motion.icm.at(time)];
  drawStage(g, w, h, d, { time, rate: rateAt(state), newton, icm }, state.theme);
}

// A time in the unit of the contacts near them; otherwise in seconds, or in milliseconds near zero.
export function clockText(time: number, d: Drop): string {
  const span = d.to - d.from;
  const near = time > d.from - 2 * span && time < d.to + 2 * span;
  const short = Math.abs(time - d.origin) < 0.01;
  const [factor, unit] = !near
    ? short
      ? [1e3, "ms"]
      : [1, "s"]
    : span < 2e-6
      ? [1e9, "ns"]
      : span < 2e-3
        ? [1e6, "µs"]
        : [1e3, "ms"];
  const places = !near ? 3 : span * factor < 10 ? 3 : span * factor < 100 ? 2 : 1;
  return `${((time - d.origin) * factor).toFixed(places).replace("-", "−")} ${unit}`;
}
