// Shared state of the page: the scenario, its solution, the time of the film, and
// what must be drawn again.
import type { Clock } from "../core/clock";
import type { Answered, Drop } from "../core/drop";
import { reportOf, type Report } from "../report/report";
import { firstLectureView, lectureToQuery, scenarioToQuery, type LectureView } from "../scenario/lecture_view";
import type { Scenario } from "../scenario/scenario";
import type { Theme } from "../style/theme";
import { firstView, viewToQuery, type View } from "../scenario/view";

export const moves = (): boolean => !matchMedia("(prefers-reduced-motion: reduce)").matches;

export class State {
  readonly view: View = firstView();
  readonly lecture: LectureView = firstLectureView();
  drop: Drop | null = null;
  private known: { answer: Answered; tolerance: number } | null = null; // Newton's answer may be there before the drop is
  private made: Report | null = null;
  theme!: Theme; // given by the ThemeSwitch
  screen = 0; // time in the film [s on the screen]
  playing = false;
  readonly dirty = {
    solve: true,
    plots: true,
    timeline: true,
    mapPicture: true,
    stage: true,
    said: true,
    laboratory: true,
    computed: false,
  };
  private linkTimer = 0;

  // `edited` is called when a part of the page has changed the scenario.
  constructor(
    public scenario: Scenario,
    readonly edited: () => void,
  ) {}

  answered(answer: Answered | null): void {
    this.known = answer && { answer, tolerance: this.view.tolerance };
    this.made = null;
  }
  // What the page says; made when it is read, which is less often than a moving slider is answered.
  get report(): Report | null {
    return this.known && (this.made ??= reportOf(this.known.answer, this.known.tolerance));
  }

  clock(): Clock {
    return this.view.slow ? this.drop!.clock : this.drop!.realTime;
  }
  time(): number {
    return this.drop ? this.clock().toPhysical(this.screen) : 0;
  }
  redraw(): void {
    Object.assign(this.dirty, { plots: true, timeline: true, mapPicture: true, stage: true });
  }

  link(): string {
    const q = new URLSearchParams();
    scenarioToQuery(this.scenario, q);
    const map = this.lecture.step ? firstView().map : this.view.map; // the story has its own
    const stands = !this.playing && (this.screen > 0 || moves()); // without motion a film stands at its start anyway
    const time = this.drop ? (stands ? this.time() : null) : this.view.time;
    viewToQuery({ ...this.view, map, time }, q);
    lectureToQuery(this.lecture, q);
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
