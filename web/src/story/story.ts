// The story as an article: its chapters, their texts, and which one is read.
import { find, setSentence, setText, Sheet } from "../support/dom";
import { later } from "../support/later";
import type { Film } from "../views/film";
import type { Frames } from "../state/frames";
import type { Prediction } from "./prediction";
import { sameScenario, steps, type StoryView, type Step } from "../scenario/story_view";
import { presets } from "../scenario/presets";
import type { Scenario } from "../scenario/scenario";
import { Drawing } from "../state/signals";
import type { State } from "../state/state";
import type { View } from "../scenario/view";
import { joined, type Sentence } from "../support/sentence";
import type { StoryFacts } from "../report/facts";
import { story, titleOf } from "../report/sentences";
import type { Observation } from "./observation";

// Functions of the page that the story uses.
export interface StoryHost {
  fromPlots(): Pick<StoryFacts, "gaps" | "trusted">;
  arrived(step: Step): void; // a chapter comes into view
  showMap(view: View["map"] | null): void; // null: the map of the last chapter
  left(): void;
  load(example: string): void;
}

export class Story {
  private readonly texts = new Drawing(() => this.write());
  private written = -Infinity; // when the texts were written [ms]
  private readonly chapters = steps.map((step) => {
    const section = document.querySelector<HTMLElement>(`.chapter[data-step="${step}"]`)!;
    return {
      step,
      section,
      title: section.querySelector("h2")!,
      text: section.querySelector<HTMLElement>(".text")!,
      beside: section.querySelector<HTMLElement>(".beside"),
      written: "",
      seen: true,
    };
  });
  private readonly order = [...find("story").parentElement!.children]; // panels in the order of the laboratory
  private readonly arrived = new Set<Step>();
  private kept: View["map"] | null = null; // the laboratory's map while that of the last chapter is prepared
  private column: Scenario | null = null; // the last one that was solved; sliders change it in place
  private scrolled = true;
  private otherExample = ""; // that the button of the chapter on counting loads
  private aim: Step | null = null; // chapter to scroll to, until the reader scrolls

  constructor(
    private readonly state: State,
    private readonly view: StoryView,
    private readonly film: Film,
    private readonly frames: Frames,
    private readonly host: StoryHost,
    private readonly observation: Observation,
    private readonly prediction: Prediction,
  ) {
    history.scrollRestoration = "manual";
    find("open-story").addEventListener("click", () => this.go("watch"));
    for (const id of ["leave", "leave-too"])
      find(id).addEventListener("click", (e) => {
        e.preventDefault();
        this.go(null);
      });
    for (const button of find("chapters").querySelectorAll("button"))
      button.addEventListener("click", () => this.go(button.dataset.step as Step));
    find("count-other").addEventListener("click", () => host.load(this.otherExample));
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
      this.host.left();
    }
    history.replaceState(null, "", state.link());
    find(step ? "chapters" : "open-story")
      .querySelector<HTMLElement>(`[data-step="${step}"]`)
      ?.focus({ preventScroll: true });
    if (!step) find("open-story").focus({ preventScroll: true });
  }

  // Restores the laboratory's map.
  leave(): void {
    this.view.step = null;
    if (this.kept) this.host.showMap(this.kept);
    this.kept = null;
  }

  // Shows the chapter of the link. Panels of the laboratory are moved into their chapters, and back.
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
    this.scrolled = true;
    this.scrollTo(step);
  }

  // The film begins before the texts are written.
  open(): void {
    this.arrived.add("watch");
    this.host.arrived("watch");
    this.observation.open();
  }

  // The map of the last chapter belongs to a column. It is prepared again for a column that was loaded or restored.
  solved(): void {
    if (this.column === this.state.scenario) return;
    this.column = this.state.scenario;
    this.arrived.delete("map");
    this.scrolled = true;
  }

  // Moves each panel into its chapter.
  private gather(): void {
    if (!this.view.step) return;
    for (const { section, text } of this.chapters)
      text.after(
        ...(section.dataset.panels?.split(" ") ?? []).map((name) => document.querySelector(`.panel.${name}`)!),
        ...section.querySelectorAll(".watch, .prediction"),
      );
  }

  prepare(): void {
    if (this.arrived.has("map")) return;
    this.kept ??= { ...this.state.view.map };
    this.host.showMap(null);
  }

  private scrollTo(step: Step): void {
    if (step === "watch") scrollTo(0, 0);
    else this.chapters.find((c) => c.step === step)!.section.scrollIntoView({ block: "start" });
  }

  // The film runs only if one is in view.
  get plays(): boolean {
    return this.view.step === null || this.observation.seen || this.film.seen;
  }

  // Draws and updates the texts if necessary.
  frame(now: number): void {
    const { state, view } = this;
    if (!view.step || !state.drop) return;
    this.prediction.advance(now);
    for (const drawing of [this.observation.controls, this.observation.picture, this.prediction.picture])
      drawing.refresh();
    if ((!Sheet.moving || now - this.written >= Sheet.often) && this.texts.refresh()) this.written = now;
    if (this.aim && this.aim !== "watch") this.scrollTo(this.aim); // after the texts above it are written
    this.aim = null;
    if (this.scrolled) this.look();
  }

  // The chapter that is read is the last one that begins above the middle of the window.
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
        this.host.arrived(step);
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

  // The sentences of all chapters; null outside the story.
  sentences(): Record<Step, Sentence[]> | null {
    const facts = this.facts();
    return facts && (Object.fromEntries(steps.map((step) => [step, story(step, facts)])) as Record<Step, Sentence[]>);
  }

  private facts(): StoryFacts | null {
    const { state, view } = this;
    if (!view.step || !state.drop || !state.report) return null;
    return {
      drop: state.drop,
      report: state.report,
      guess: view.guess,
      fall: this.prediction.fall,
      ...this.host.fromPlots(),
    };
  }

  // While a slider moves, only chapters in the window are written.
  private write(): void {
    const facts = this.facts();
    if (!facts) return;
    const { scenario, moving } = this.state;
    for (const chapter of this.chapters) {
      if (moving && !chapter.seen) continue;
      const sentences = story(chapter.step, facts);
      const text = joined(sentences);
      const title = titleOf(chapter.step, scenario.cradle);
      setText(chapter.title, title);
      if (text === chapter.written) continue;
      chapter.written = text;
      const aside = chapter.beside ? sentences.slice(1) : [];
      setSentence(chapter.text, joined(sentences.slice(0, sentences.length - aside.length)));
      if (chapter.beside) setSentence(chapter.beside, joined(aside));
    }
    // Hard balls touch more often than soft ones: a button loads the paper's balls.
    const other = find("count-other");
    const opening = sameScenario(scenario, presets[0].scenario);
    setText(other, opening ? "Count on the paper’s hard balls" : "Count on the basketball");
    this.otherExample = opening ? "fig2" : presets[0].id;
  }
}
