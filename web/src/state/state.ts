// Shared state of the page: the scenario, its solution, the time of the film. Its fields are signals.
import { computed } from "@preact/signals-core";
import type { Clock } from "../core/clock";
import type { Answered, Drop } from "../core/drop";
import { reportOf, type Report } from "../report/report";
import {
  ballsOfChapter,
  firstStoryView,
  sameScenario,
  scenarioToQuery,
  storyToQuery,
  type StoryView,
} from "../scenario/story_view";
import type { Scenario } from "../scenario/scenario";
import type { Theme } from "../style/theme";
import { firstView, viewToQuery, type View } from "../scenario/view";
import { Drawing, observed } from "./signals";

export const moves = (): boolean => !matchMedia("(prefers-reduced-motion: reduce)").matches;

export class State {
  readonly view: View = observed({ ...firstView(), map: observed(firstView().map) });
  readonly story: StoryView = observed(firstStoryView());
  drop: Drop | null = null;
  answer: { of: Answered; tolerance: number } | null = null; // Newton's results may arrive before the drop
  theme!: Theme; // set by the ThemeSwitch
  screen = 0; // time in the film [s on the screen]
  playing = false;
  moving = false; // a slider moves
  revision = 1; // counts changes of the scenario and of the tolerance: each is solved
  private layout = 0; // counts changes of the size and visibility of pictures, after which all are drawn again
  private linkTimer = 0;

  // `edited` is called when a part of the page has changed the scenario.
  constructor(
    public scenario: Scenario,
    readonly edited: () => void,
  ) {
    observed(this, ["drop", "answer", "theme", "screen", "playing", "moving", "revision", "layout"]);
  }

  // The report is computed when it is read, which is less often than a moving slider is answered.
  private readonly reported = computed(() => this.answer && reportOf(this.answer.of, this.answer.tolerance));
  get report(): Report | null {
    return this.reported.value;
  }

  clock(): Clock {
    return this.view.slow ? this.drop!.clock : this.drop!.realTime;
  }
  time(): number {
    return this.drop ? this.clock().toPhysical(this.screen) : 0;
  }
  redraw(): void {
    this.layout++;
  }
  // A picture: drawn again after a change of the layout, of the theme, or of what `draw` reads.
  drawing(draw: () => void): Drawing {
    return new Drawing(() => {
      void [this.layout, this.theme];
      draw();
    });
  }

  link(): string {
    const q = new URLSearchParams();
    const balls = ballsOfChapter(this.story);
    if (!balls || !sameScenario(balls, this.scenario)) scenarioToQuery(this.scenario, q);
    const map = this.story.step ? firstView().map : this.view.map; // the story has its own
    // With reduced motion the film stands at its start by default.
    const stands = !this.playing && (this.screen > 0 || moves());
    const time = this.drop ? (stands ? this.time() : null) : this.view.time;
    viewToQuery({ ...this.view, map, time }, q);
    storyToQuery(this.story, q);
    const text = q.toString().replaceAll("%2C", ",");
    return `${location.origin}${location.pathname}${text ? `?${text}` : ""}`;
  }
  writeLink(): void {
    clearTimeout(this.linkTimer);
    this.linkTimer = window.setTimeout(() => history.replaceState(null, "", this.link()), 250);
  }
  // Adds a history entry; later links belong to it.
  enterHistory(): void {
    clearTimeout(this.linkTimer);
    history.replaceState(null, "", this.link());
    history.pushState(null, "", this.link());
  }
}
