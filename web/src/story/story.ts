// The story in six steps: content, navigation and its drawing of the drop.
import { find, tell, type Sheet } from "../support/dom";
import type { Film } from "../views/film";
import type { Frames } from "../app/frames";
import { sameScenario, steps, type LectureView, type PanelName, type Step } from "./lecture_view";
import { presets } from "../scenario/presets";
import type { State } from "../app/state";
import { storyText, titleOf, type Told } from "./story_text";
import { drawTale, rulerTop, type TaleLayout } from "./tale";

// Panels of a step besides its text.
const shows: Record<Step, (PanelName | "tale")[]> = {
  predict: ["tale"],
  drop: ["tale"],
  slow: ["film", "forces"],
  count: ["forces", "timeline"],
  gap: ["rebound", "film"],
  map: ["map"],
};
const onCradle: Partial<Record<Step, PanelName[]>> = { predict: ["film"], drop: ["film"] };

// Data of the page that the story needs.
export interface Stagehand {
  told(): Pick<Told, "gaps" | "trusted">;
  entered(step: Step): void;
  left(): void;
  load(example: string): void;
}

export class Story {
  dirty = true;
  private layout: TaleLayout | null = null;
  private revealed = false;
  private said = "";

  constructor(
    private readonly state: State,
    private readonly view: LectureView,
    private readonly film: Film,
    private readonly sheet: Sheet,
    private readonly frames: Frames,
    private readonly hand: Stagehand,
  ) {
    this.listen();
  }

  // ---- steps ------------------------------------------------------------------------------------------

  go(step: Step | null): void {
    const { state, view } = this;
    state.enterHistory();
    view.step = step;
    if (step) view.panel = null;
    else state.view.slow = true;
    if (step) this.show();
    else this.hand.left();
    if (step) this.hand.entered(step);
    history.replaceState(null, "", state.link());
    find(step ? "story-title" : "tell").focus({ preventScroll: true });
  }

  // Sets the page to the step in the link.
  show(): void {
    const { step } = this.view;
    find("story").hidden = find("story-nav").hidden = step === null;
    if (step === null) return;
    this.frames.show("story", this.panels(step));
    this.revealed = false;
    this.said = "";
    const place = steps.indexOf(step);
    find("story-title").textContent = titleOf(step, this.state.scenario.cradle);
    find("story-place").textContent = `Step ${place + 1} of ${steps.length}`;
    find("story-steps").querySelectorAll("button").forEach((b, i) => {
      if (i === place) b.setAttribute("aria-current", "step");
      else b.removeAttribute("aria-current");
    });
    find<HTMLButtonElement>("story-back").disabled = place === 0;
    find("story-next").textContent = step === "predict" ? "Let them drop" : place === steps.length - 1 ? "To the whole page" : "Next";
    find("story-again").hidden = step !== "drop";
    this.refreshOther();
    scrollTo(0, 0);
    this.dirty = true;
  }

  private panels(step: Step): (PanelName | "tale")[] {
    return (this.state.scenario.cradle && onCradle[step]) || shows[step];
  }

  private move(by: number): void {
    const { step } = this.view;
    if (!step) return;
    const place = steps.indexOf(step) + by;
    if (place >= steps.length) this.go(null);
    else if (place >= 0) this.go(steps[place]);
  }

  // ---- what is shown ----------------------------------------------------------------------------------

  // Draws and updates the text if necessary.
  frame(): void {
    const { state, view } = this;
    if (!view.step || !state.drop) return;
    if (view.step === "drop" && !this.revealed && this.overall() > 0.97) {
      this.revealed = true;
      this.dirty = true;
    }
    if (!this.dirty && !(state.playing && view.step === "drop")) return;
    this.dirty = false;
    if (view.step === "predict" || view.step === "drop") this.draw();
    this.tell();
  }

  private overall(): number {
    return this.state.screen / Math.max(this.state.clock().length, 1e-9);
  }

  private told(): Told {
    const { state, view } = this;
    const drop = state.drop!;
    const top = drop.scenario.balls.length - 1;
    const rises: [number, number] = drop.scenario.cradle
      ? [drop.newton.final.velocity[top], drop.icm.final.velocity[top]]
      : [drop.newton.peaks[top], drop.icm.peaks[top]];
    return { drop, guess: view.guess, revealed: this.revealed, rises, ...this.hand.told() };
  }

  private tell(): void {
    const text = storyText(this.view.step!, this.told());
    if (text === this.said) return;
    this.said = text;
    this.refreshOther();
    tell(find("story-text"), text);
  }

  private draw(): void {
    const { state, sheet, view } = this;
    const drop = state.drop!;
    if (drop.scenario.cradle || sheet.width < 40) return;
    const falling = view.step === "drop";
    const time = falling ? state.time() : drop.start;
    const told = this.told();
    const size = Math.min(Math.max(this.frames.textSize(), 14), sheet.width / 22);
    this.layout = drawTale(
      sheet.g, sheet.width, sheet.height,
      {
        drop, falling, guess: view.guess,
        newton: drop.motion.newton.at(time), icm: drop.motion.icm.at(time),
        reached: this.revealed ? told.rises : [NaN, NaN],
      },
      size, state.theme,
    );
    const { canvas } = sheet;
    canvas.setAttribute("aria-disabled", String(falling));
    canvas.setAttribute("aria-valuemax", String(Number(rulerTop(drop, view.guess, falling).toFixed(2))));
    canvas.setAttribute("aria-valuenow", String(view.guess ?? 0));
    canvas.setAttribute("aria-valuetext", view.guess === null ? "no guess yet" : `${view.guess} m`);
  }

  // ---- changes ----------------------------------------------------------------------------------------

  private guess(height: number): void {
    if (this.view.step !== "predict") return;
    this.view.guess = Number(Math.max(height, 0).toPrecision(2));
    this.dirty = true;
    this.state.writeLink();
  }

  private listen(): void {
    find("tell").addEventListener("click", () => this.go("predict"));
    find("story-next").addEventListener("click", () => this.move(1));
    find("story-back").addEventListener("click", () => this.move(-1));
    find("story-leave").addEventListener("click", () => this.go(null));
    find("story-other").addEventListener("click", () => this.hand.load(find("story-other").dataset.example!));
    find("story-again").addEventListener("click", () => this.replay());
    find("story-full").addEventListener("click", () => this.frames.fullScreen());
    find("story-steps").querySelectorAll("button").forEach((b, i) => b.addEventListener("click", () => this.go(steps[i])));
    addEventListener("keydown", (e) => this.key(e), { capture: true });
    this.listenGuess();
    this.listenSwipe();
  }

  // Hard balls touch more often than soft ones; the paper's balls are offered for counting too.
  private refreshOther(): void {
    const other = find("story-other");
    other.hidden = this.view.step !== "count";
    const opening = sameScenario(this.state.scenario, presets[0].scenario);
    other.textContent = opening ? "Count on the paper’s hard balls" : "Count on the basketball";
    other.dataset.example = opening ? "fig2" : presets[0].id;
  }

  replay(): void {
    this.state.screen = 0;
    this.film.play(true);
  }

  // Arrows, space and Esc change the step, up and down move the guess; a focused control keeps the keys it uses.
  private key(e: KeyboardEvent): void {
    if (!this.view.step || e.ctrlKey || e.metaKey || e.altKey) return;
    const target = e.target as HTMLElement;
    const worked = target.closest("input, select, textarea, canvas[tabindex]") !== null;
    const pressed = target.closest("button, a, summary") !== null;
    const actions: Record<string, () => void> = { PageDown: () => this.move(1), PageUp: () => this.move(-1), Escape: () => this.go(null), f: () => this.frames.fullScreen() };
    const sideways = worked && target.id !== "tale";
    if (!sideways) Object.assign(actions, { ArrowRight: () => this.move(1), ArrowLeft: () => this.move(-1) });
    if (!worked && !pressed) actions[" "] = () => this.move(1);
    if (!sideways && this.view.step === "predict" && this.layout) Object.assign(actions, { ArrowUp: () => this.nudge(1), ArrowDown: () => this.nudge(-1) });
    if (worked && (e.key === "PageDown" || e.key === "PageUp") && sideways) return;
    const action = actions[e.key.length === 1 ? e.key.toLowerCase() : e.key];
    if (!action) return;
    e.preventDefault();
    e.stopPropagation();
    action();
  }

  private listenGuess(): void {
    const { canvas } = this.sheet;
    const at = (e: PointerEvent): void => {
      if (this.layout) this.guess(Math.min((this.layout.floor - e.offsetY) / this.layout.scale, this.layout.top));
    };
    canvas.addEventListener("pointerdown", (e) => {
      if (e.button !== 0 || this.view.step !== "predict") return;
      canvas.setPointerCapture(e.pointerId);
      at(e);
    });
    canvas.addEventListener("pointermove", (e) => canvas.hasPointerCapture(e.pointerId) && at(e));
  }

  // Moves the guess by a hundredth of the ruler, a tenth of a metre at least.
  private nudge(way: 1 | -1): void {
    if (!this.layout) return;
    const { top } = this.layout;
    const wanted = (this.view.guess ?? 0) + 0.1 * way * Math.max(1, top / 10);
    this.view.guess = Number(Math.min(Math.max(wanted, 0), top).toFixed(2));
    this.dirty = true;
    this.state.writeLink();
  }

  // A horizontal swipe that does not begin on a draggable element.
  private listenSwipe(): void {
    let from: { x: number; y: number; at: number } | null = null;
    document.addEventListener("touchstart", (e) => {
      const draggable = (e.target as HTMLElement).closest("input, select, canvas[tabindex]");
      from = this.view.step && e.touches.length === 1 && !draggable ? { x: e.touches[0].clientX, y: e.touches[0].clientY, at: e.timeStamp } : null;
    }, { passive: true });
    document.addEventListener("touchend", (e) => {
      if (!from) return;
      const { clientX, clientY } = e.changedTouches[0];
      const [dx, dy] = [clientX - from.x, clientY - from.y];
      if (Math.abs(dx) > 50 && Math.abs(dx) > 2 * Math.abs(dy) && e.timeStamp - from.at < 800) this.move(dx < 0 ? 1 : -1);
      from = null;
    }, { passive: true });
  }
}
