// The first step of the story: the drop plays, and one slider changes the gap. The balls can be dragged as well.
import { find, type Sheet } from "../support/dom";
import { withUnit } from "../support/format";
import { fromSlider, toSlider } from "../support/slider";
import { clampTo, firstGap, lowestHeight, ranges } from "../scenario/scenario";
import type { State } from "../app/state";
import { drawDuel, type DuelLayout } from "../views/duel";
import type { Film } from "../views/film";

const slowTo = 0.02; // s before the first contact from which the film starts after a change

export class Watch {
  private layout: DuelLayout | null = null;
  private readonly slider = find<HTMLInputElement>("watch-gap");

  constructor(
    private readonly state: State,
    private readonly film: Film,
    private readonly sheet: Sheet,
    private readonly moves: () => boolean,
  ) {
    this.slider.max = "1000";
    this.slider.addEventListener("input", () => this.setGap(fromSlider(ranges.gap, Number(this.slider.value))));
    find("watch-play").addEventListener("click", () => film.play(!state.playing));
    this.listenDrag();
  }

  draw(size: number): void {
    const { state, sheet } = this;
    const d = state.drop!;
    if (sheet.width < 40 || d.scenario.cradle) return;
    const time = state.time();
    const clock = state.clock();
    const moment = { time, screen: state.screen, rate: state.view.slow ? clock.rate(time) : 1, newton: d.motion.newton.at(time), icm: d.motion.icm.at(time) };
    this.layout = drawDuel(sheet.g, sheet.width, sheet.height, d, moment, (t) => clock.toScreen(t), state.theme, Math.min(size, sheet.width / 24, sheet.height / 18));
    const slower = 1 / moment.rate;
    find("watch-speed").textContent = slower < 1.05 ? "real time" : `${slower < 10 ? slower.toFixed(1) : Math.round(Number(slower.toPrecision(2)))} × slower`;
    find("watch-play").textContent = state.playing ? "Pause" : "Play";
  }

  // The slider follows the setting.
  refresh(): void {
    const { scenario } = this.state;
    const gap = scenario.gaps[firstGap(scenario)];
    const said = gap === 0 ? "touching" : withUnit(gap, "m");
    this.slider.value = String(toSlider(ranges.gap, gap));
    this.slider.setAttribute("aria-valuetext", said);
    find("watch-gap-said").textContent = said;
  }

  private setGap(gap: number): void {
    const { scenario } = this.state;
    scenario.gaps = scenario.gaps.map((old, i) => (i < firstGap(scenario) ? old : gap));
    this.changed();
  }

  private changed(): void {
    this.refresh();
    this.state.edited();
    const { drop } = this.state;
    if (drop) this.film.seek(Math.max(drop.start, drop.from - slowTo));
    this.film.play(this.moves());
  }

  // The top ball changes the gap, the lowest one the height.
  private listenDrag(): void {
    const { canvas } = this.sheet;
    let held: { top: boolean; from: number; scale: number; value: number } | null = null;
    canvas.addEventListener("pointerdown", (e) => {
      const { drop, scenario } = this.state;
      if (e.button !== 0 || !this.layout || !drop) return;
      const balls = drop.motion.newton.at(this.state.time());
      const n = scenario.balls.length;
      const at = (i: number): number => Math.abs(this.layout!.floor - balls.position[i] * this.layout!.scale - e.offsetY);
      const top = at(n - 1) <= at(0);
      held = { top, from: e.offsetY, scale: this.layout.scale, value: top ? scenario.gaps[firstGap(scenario)] : scenario.height };
      canvas.setPointerCapture(e.pointerId);
    });
    canvas.addEventListener("pointermove", (e) => {
      if (!held || !canvas.hasPointerCapture(e.pointerId)) return;
      const { scenario } = this.state;
      const moved = held.value + (held.from - e.offsetY) / held.scale;
      if (held.top) this.setGap(clampTo(ranges.gap, Number(Math.max(moved, 0).toFixed(4))));
      else {
        scenario.height = clampTo(ranges.height, Number(Math.max(moved, lowestHeight(scenario)).toFixed(3)));
        this.changed();
      }
    });
    for (const type of ["pointerup", "pointercancel"]) canvas.addEventListener(type, () => (held = null));
  }
}
