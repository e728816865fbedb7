// The story as an article: its chapters, which of them is read, and what each says.
import { find, setText, Sheet, tell } from "../support/dom";
import { later } from "../support/later";
import type { Film } from "../views/film";
import type { Frames } from "../state/frames";
import type { Guess } from "./guess";
import { sameScenario, steps, type LectureView, type Step } from "../scenario/lecture_view";
import { presets } from "../scenario/presets";
import type { Scenario } from "../scenario/scenario";
import type { State } from "../state/state";
import type { View } from "../scenario/view";
import { joined, type Sentence } from "../report/sentence";
import { story, titleOf, type Told } from "./story_text";
import type { Watch } from "./watch";

// What the story needs of the page.
export interface Stagehand {
  told(): Pick<Told, "gaps" | "trusted">;
  arrived(step: Step): void; // a chapter comes into view
  showMap(view: View["map"] | null): void; // null: that of the last chapter
  left(): void;
  load(example: string): void;
}

export class Story {
  dirty = true; // what is said and drawn
  private untold = true; // the texts are older than the setting
  private toldAt = -Infinity;
  moved = true; // the film only
  private readonly chapters = steps.map((step) => {
    const section = document.querySelector<HTMLElement>(`.chapter[data-step="${step}"]`)!;
    return {
      step,
      section,
      title: section.querySelector("h2")!,
      text: section.querySelector<HTMLElement>(".say")!,
      beside: section.querySelector<HTMLElement>(".beside"),
      said: "",
      seen: true,
    };
  });
  private readonly order = [...find("story").parentElement!.children]; // of the laboratory
  private readonly arrived = new Set<Step>();
  private kept: View["map"] | null = null; // the laboratory's map, while the last chapter's is prepared
  private column: Scenario | null = null; // that was solved last; a slider changes it in place
  private scrolled = true;
  private aim: Step | null = null; // the chapter to be shown, until the reader scrolls

  constructor(
    private readonly state: State,
    private readonly view: LectureView,
    private readonly film: Film,
    private readonly frames: Frames,
    private readonly hand: Stagehand,
    private readonly watch: Watch,
    private readonly guess: Guess,
  ) {
    history.scrollRestoration = "manual";
    find("tell").addEventListener("click", () => this.go("watch"));
    for (const id of ["leave", "leave-too"])
      find(id).addEventListener("click", (e) => {
        e.preventDefault();
        this.go(null);
      });
    for (const button of find("chapters").querySelectorAll("button"))
      button.addEventListener("click", () => this.go(button.dataset.step as Step));
    find("count-other").addEventListener("click", () => hand.load(find("count-other").dataset.example!));
    addEventListener("scroll", () => (this.scrolled = true), { passive: true });
    addEventListener("resize", () => (this.scrolled = true));
    for (const act of ["wheel", "touchmove", "keydown"])
      addEventListener(act, () => (this.aim = null), { passive: true });
  }

  go(step: Step | null): void {
    const { state, view } = this;
    state.enterHistory();
    if (step) {
      view.step = step;
      view.panel = null;
      this.show();
    } else {
      this.leave();
      this.hand.left();
    }
    history.replaceState(null, "", state.link());
    find(step ? "chapters" : "tell")
      .querySelector<HTMLElement>(`[data-step="${step}"]`)
      ?.focus({ preventScroll: true });
    if (!step) find("tell").focus({ preventScroll: true });
  }

  // The laboratory has its map again.
  leave(): void {
    this.view.step = null;
    if (this.kept) this.hand.showMap(this.kept);
    this.kept = null;
  }

  // Sets the page to the chapter in the link. The panels that the laboratory has too move into their chapters, and back.
  show(): void {
    const { step } = this.view;
    find("story").hidden = step === null;
    this.kept = null;
    if (step === null) {
      if (!find("story").parentElement!.querySelector(":scope > .film"))
        find("story").parentElement!.append(...this.order);
      return;
    }
    if (step === "watch") later(() => this.gather());
    else this.gather();
    this.frames.show("story", []);
    this.arrived.clear();
    this.aim = step;
    this.scrolled = this.dirty = true;
    this.scrollTo(step);
  }

  // The film begins before anything is said.
  open(): void {
    this.arrived.add("watch");
    this.hand.arrived("watch");
    this.watch.open(this.frames.textSize());
  }

  // The last chapter's map is made for the column: it is set up again for one that was loaded, or by Undo.
  solved(): void {
    this.dirty = true;
    if (this.column === this.state.scenario) return;
    this.column = this.state.scenario;
    this.arrived.delete("map");
    this.scrolled = true;
  }

  // Each panel into its chapter.
  private gather(): void {
    if (!this.view.step) return;
    for (const { section, text } of this.chapters)
      text.after(
        ...(section.dataset.panels?.split(" ") ?? []).map((name) => document.querySelector(`.panel.${name}`)!),
        ...section.querySelectorAll(".watch, .tale"),
      );
  }

  prepare(): void {
    if (this.arrived.has("map")) return;
    this.kept ??= { ...this.state.view.map };
    this.hand.showMap(null);
  }

  private scrollTo(step: Step): void {
    if (step === "watch") scrollTo(0, 0);
    else this.chapters.find((c) => c.step === step)!.section.scrollIntoView({ block: "start" });
  }

  // Whether a film is in view, so that it should go on.
  get plays(): boolean {
    return this.view.step === null || this.watch.seen || this.film.seen;
  }

  // Draws and updates the texts if necessary.
  frame(now: number): void {
    const { state, view } = this;
    if (!view.step || !state.drop) return;
    if (this.guess.advance(now)) this.dirty = true;
    const size = this.frames.textSize();
    if (this.dirty) this.draw(size);
    else if (this.moved) this.watch.draw(size);
    this.moved = false;
    if (this.untold && state.report && (!Sheet.moving || now - this.toldAt >= Sheet.often)) this.tell(now);
    if (this.aim && this.aim !== "watch") this.scrollTo(this.aim); // the texts above are there now
    this.aim = null;
    if (this.scrolled) this.look();
  }

  private draw(size: number): void {
    this.dirty = false;
    this.watch.refresh();
    this.watch.draw(size);
    this.guess.draw(size);
    this.untold = true;
  }

  // Which chapter is read: the last one that begins above the middle of the window.
  private look(): void {
    this.scrolled = false;
    const { view, state } = this;
    let read: Step = "watch";
    for (const chapter of this.chapters) {
      const { step, section } = chapter;
      const { top, bottom } = section.getBoundingClientRect();
      chapter.seen = top < innerHeight && bottom > 0;
      if (top < 0.5 * innerHeight) read = step;
      if (top < 0.9 * innerHeight && bottom > 0 && !this.arrived.has(step)) {
        this.arrived.add(step);
        if (step === "map") this.kept = null;
        this.hand.arrived(step);
      }
    }
    const atEnd = scrollY > 0 && scrollY + innerHeight > document.documentElement.scrollHeight - 4;
    if (atEnd) read = steps[steps.length - 1];
    for (const button of find("chapters").querySelectorAll("button")) {
      if (button.dataset.step === read) button.setAttribute("aria-current", "step");
      else button.removeAttribute("aria-current");
    }
    if (view.step === read) return;
    view.step = read;
    state.writeLink();
  }

  // What the chapters say; nothing outside the story.
  sentences(): Record<Step, Sentence[]> | null {
    const told = this.told();
    return told && (Object.fromEntries(steps.map((step) => [step, story(step, told)])) as Record<Step, Sentence[]>);
  }

  private told(): Told | null {
    const { state, view } = this;
    if (!view.step || !state.drop || !state.report) return null;
    return { drop: state.drop, report: state.report, guess: view.guess, fall: this.guess.fall, ...this.hand.told() };
  }

  // While a slider moves, what is scrolled out of the window waits.
  private tell(now: number): void {
    this.untold = Sheet.moving;
    this.toldAt = now;
    const told = this.told()!;
    const { scenario } = this.state;
    for (const chapter of this.chapters) {
      if (Sheet.moving && !chapter.seen) continue;
      const said = story(chapter.step, told);
      const text = joined(said);
      const title = titleOf(chapter.step, scenario.cradle);
      setText(chapter.title, title);
      if (text === chapter.said) continue;
      chapter.said = text;
      const aside = chapter.beside ? said.slice(1) : [];
      tell(chapter.text, joined(said.slice(0, said.length - aside.length)));
      if (chapter.beside) tell(chapter.beside, joined(aside));
    }
    // Hard balls touch more often than soft ones; the paper's balls are offered for counting too.
    const other = find("count-other");
    const opening = sameScenario(scenario, presets[0].scenario);
    setText(other, opening ? "Count on the paper’s hard balls" : "Count on the basketball");
    other.dataset.example = opening ? "fig2" : presets[0].id;
  }
}
