// The story as an article: its chapters, their texts, and which one is read.
import { find, setSentence, setText, Sheet } from "../support/dom";
import { later } from "../support/later";
import type { Film } from "../views/film";
import type { Frames } from "../state/frames";
import type { Prediction } from "./prediction";
import { ballsOfChapter, firstStep, sameScenario, steps, type StoryView, type Step } from "../scenario/story_view";
import { presets } from "../scenario/presets";
import { copyOf, type Scenario } from "../scenario/scenario";
import { Drawing, observed } from "../state/signals";
import type { State } from "../state/state";
import type { View } from "../scenario/view";
import { joined, type Sentence } from "../support/sentence";
import type { StoryFacts } from "../report/facts";
import { paragraphs, titleOf } from "../report/sentences";
import type { ReboundPanel } from "../views/rebound_panel";
import type { ContactSteps } from "./contact_steps";
import type { Observation } from "./observation";
import type { Paper } from "./paper";

// Functions of the page that the story uses.
export interface StoryHost {
  fromPlots(): Pick<StoryFacts, "gaps" | "trusted">;
  arrived(step: Step): void; // a chapter comes into view
  showMap(view: View["map"] | null): void; // null: the map of the last chapter
  left(): void;
  paintCurve: ReboundPanel["paint"];
  put(scenario: Scenario): void; // other balls, which cannot be undone
}

// The balls of the screen, and those of the story while a chapter has its own.
interface Screen {
  state: Pick<State, "scenario" | "drop" | "answer" | "screen" | "playing">;
  home: Scenario | null;
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
      texts: [...section.querySelectorAll<HTMLElement>(".text, .beside")], // a paragraph each
      written: "",
      seen: true,
    };
  });
  private readonly order = [...find("story").parentElement!.children]; // panels in the order of the laboratory
  private readonly arrived = new Set<Step>();
  private kept: View["map"] | null = null; // the laboratory's map while that of the last chapter is prepared
  private column: Scenario | null = null; // the last one that was solved; sliders change it in place
  private scrolled = true;
  private home: Scenario | null = null; // balls of the story while a chapter has its own
  private aim: Step | null = null; // chapter to scroll to, until the reader scrolls
  private printing = false;
  private screen: Screen | null = null; // what the screen shows, while other balls are printed

  constructor(
    private readonly state: State,
    private readonly view: StoryView,
    private readonly film: Film,
    private readonly paper: Paper,
    private readonly frames: Frames,
    private readonly host: StoryHost,
    private readonly observation: Observation,
    private readonly prediction: Prediction,
    private readonly contact: ContactSteps,
  ) {
    history.scrollRestoration = "manual";
    observed(this, ["printing"]);
    find("open-story").addEventListener("click", () => this.enter());
    for (const id of ["leave", "leave-too"])
      find(id).addEventListener("click", (e) => {
        e.preventDefault();
        this.go(null);
      });
    for (const button of find("chapters").querySelectorAll("button"))
      button.addEventListener("click", () => this.go(button.dataset.step as Step));
    this.listenPager();
    addEventListener("scroll", () => (this.scrolled = true), { passive: true });
    addEventListener("resize", () => (this.scrolled = true));
    for (const act of ["wheel", "touchmove", "keydown"])
      addEventListener(act, () => (this.aim = null), { passive: true });
  }

  // On a narrow screen: the chapters by name, and the next one.
  private listenPager(): void {
    const choice = find<HTMLSelectElement>("pager-choice");
    choice.append(...steps.map((step, i) => new Option(`${i + 1} ${titleOf(step, false)}`, step)));
    choice.addEventListener("change", () => this.go(choice.value as Step));
    find("pager-next").addEventListener("click", () => {
      const next = steps[steps.indexOf(choice.value as Step) + 1];
      this.go(next ?? null);
    });
  }

  // The laboratory's balls stay in all chapters, unless they are those that the story opens with.
  private enter(): void {
    this.view.own = !sameScenario(this.state.scenario, presets[0].scenario);
    this.go(firstStep);
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
    this.home = null; // the laboratory has the balls of the last chapter
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
    this.lend();
    if (step === firstStep) later(() => this.gather());
    else this.gather();
    this.frames.show("story", []);
    this.arrived.clear();
    this.aim = step;
    this.scrolled = true;
    this.scrollTo(step);
  }

  // The first picture is drawn before the texts are written.
  open(): void {
    this.prediction.open();
  }

  // Gives a chapter its own balls, and takes them back after it.
  private lend(): void {
    const { state, view, host } = this;
    const balls = ballsOfChapter(view);
    if (balls && !this.home) {
      const known = sameScenario(state.scenario, balls); // from a link to this chapter
      this.home = copyOf(known ? presets[0].scenario : state.scenario);
      if (!known) host.put(copyOf(balls));
    } else if (!balls && this.home) {
      if (!sameScenario(state.scenario, this.home)) host.put(this.home);
      this.home = null;
    }
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
    for (const { section } of this.chapters)
      section
        .querySelector(".panels")
        ?.before(...section.dataset.panels!.split(" ").map((name) => document.querySelector(`.panel.${name}`)!));
  }

  prepare(): void {
    const { state, view, home } = this;
    const lent = ballsOfChapter({ step: "map", own: view.own });
    if (home ?? lent) this.paper.prepare((home ?? lent)!, !home, state.view.tolerance);
    if (this.arrived.has("map")) return;
    this.kept ??= { ...this.state.view.map };
    this.host.showMap(null);
  }

  private scrollTo(step: Step): void {
    if (step === firstStep) scrollTo(0, 0);
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
    if (this.printing && !Sheet.printing) this.afterPrint();
    this.paper.frame();
    this.prediction.advance(now);
    const { observation, prediction, contact } = this;
    for (const drawing of [observation.controls, observation.picture, prediction.picture, ...contact.drawings])
      drawing.refresh();
    if ((!Sheet.moving || now - this.written >= Sheet.often) && this.texts.refresh()) this.written = now;
    if (this.aim && this.aim !== firstStep) this.scrollTo(this.aim);
    if (this.chapters.every(({ written }) => written)) this.aim = null; // the texts above it may move it
    if (this.scrolled && !this.printing) this.look();
  }

  // Before printing: each chapter gets its own balls. Returns whether the pictures have to be drawn again.
  print(): boolean {
    const { state, paper, view, film } = this;
    if (!view.step || !state.drop) return false;
    if (this.printing) return this.screen !== null;
    this.printing = true;
    const { scenario, drop, answer, screen, playing } = state;
    if (!paper.drop || paper.lent !== (this.home === null)) return false;
    if (!this.home) {
      paper.drawLent(state.theme);
      if (this.arrived.has("slow")) return false;
    } else {
      for (const id of ["timeline", "map"]) paper.keep(id);
      Object.assign(state, { scenario: paper.drop.scenario, drop: paper.drop });
      state.answer = { of: paper.drop, tolerance: state.view.tolerance };
      paper.lay("rebound", (g, w, h) => this.host.paintCurve(g, w, h, state.theme, paper.curve));
    }
    this.screen = { state: { scenario, drop, answer, screen, playing }, home: this.home };
    this.home = null;
    film.seek(0.5 * (state.drop.from + state.drop.to));
    return true;
  }

  private afterPrint(): void {
    this.printing = false;
    this.paper.clear();
    if (!this.screen) return;
    Object.assign(this.state, this.screen.state);
    this.home = this.screen.home;
    this.screen = null;
  }

  // The chapter that is read is the last one that begins above the middle of the window.
  private look(): void {
    this.scrolled = false;
    const { view, state } = this;
    let read: Step = firstStep;
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
    find<HTMLSelectElement>("pager-choice").value = read;
    setText(find("pager-next"), read === steps[steps.length - 1] ? "Laboratory" : "Next");
    if (view.step === read) return;
    view.step = read;
    this.lend();
    state.writeLink();
  }

  // The sentences of all chapters; null outside the story.
  sentences(): Record<Step, Sentence[]> | null {
    if (!this.facts("predict")) return null;
    const all = steps.map((step) => [step, paragraphs(step, this.facts(step)!).flat()]);
    return Object.fromEntries(all) as Record<Step, Sentence[]>;
  }

  private facts(step: Step): StoryFacts | null {
    const { state, view } = this;
    if (!view.step || !state.drop || !state.report) return null;
    const own = ballsOfChapter({ step, own: view.own }) !== null;
    const printed = this.printing && own === this.paper.lent ? this.paper.facts() : null;
    return {
      drop: state.drop,
      report: state.report,
      guess: view.guess,
      fall: this.prediction.fall,
      ...this.host.fromPlots(),
      ...printed,
      lent: own && (this.home !== null || printed !== null),
      back: step === "gap" && this.home === null && !view.own,
    };
  }

  // While a slider moves, only chapters in the window are written. While a chapter has its own balls, the others keep
  // what they say of those of the story.
  private write(): void {
    const { scenario, moving } = this.state;
    for (const chapter of this.chapters) {
      const facts = this.facts(chapter.step);
      if (!facts) return;
      const kept = this.screen?.home && ballsOfChapter({ step: chapter.step, own: this.view.own });
      const other = (this.home !== null && !facts.lent) || kept;
      if (chapter.written && ((moving && !chapter.seen) || other)) continue;
      const texts = paragraphs(chapter.step, facts).map(joined);
      setText(chapter.title, titleOf(chapter.step, scenario.cradle));
      if (texts.join("\n") === chapter.written) continue;
      chapter.written = texts.join("\n");
      chapter.texts.forEach((element, i) => setSentence(element, texts[i]));
    }
  }
}
