// The first chapter: the drop by both models. The balls can be dragged; a slider also changes the gap.
import { find, setAttribute, setText, Sheet } from "../support/dom";
import { withUnit } from "../support/format";
import { Handle, type Pull } from "../support/handle";
import { fromSlider, toSlider } from "../scenario/slider";
import { touchable } from "../support/touch";
import { clampTo, firstGap, lowestHeight, ranges } from "../scenario/scenario";
import type { Drawing } from "../state/signals";
import type { State } from "../state/state";
import { drawCloseUp } from "../views/close_up";
import { drawDuel, type DuelLayout } from "../views/duel";
import type { Film } from "../views/film";

const nearly = 50; // time between updates of the handles while the film runs [ms]
const slowTo = 0.02; // after a change of the gap the film starts this time before the first contact [s]

type Dragged = "gap" | "height";

export class Observation {
  private layout: DuelLayout | null = null;
  private dragged: Dragged | null = null;
  readonly picture: Drawing;
  readonly controls: Drawing;
  private placed = -Infinity; // when the handles were moved to the balls [ms]
  private readonly slider = find<HTMLInputElement>("watch-gap");
  private readonly handles: { what: Dragged; world: number; handle: Handle }[];

  constructor(
    private readonly state: State,
    private readonly film: Film,
    private readonly sheet: Sheet,
    private readonly moves: () => boolean,
    private readonly textSize: () => number,
  ) {
    this.picture = state.drawing(() => this.draw());
    this.controls = state.drawing(() => this.refresh());
    this.slider.max = "1000";
    touchable(this.slider);
    this.slider.addEventListener("input", () => this.set("gap", fromSlider(ranges.gap, Number(this.slider.value))));
    find("watch-play").addEventListener("click", () => film.play(!state.playing));
    const pulls: Record<Dragged, Pull> = {
      gap: this.pull("gap", "Gap below the top ball"),
      height: this.pull("height", "Height of the lowest ball"),
    };
    this.handles = [0, 1].flatMap((world) =>
      (["height", "gap"] as const).map((what) => ({
        what,
        world,
        handle: new Handle(find("duel-box"), pulls[what], world === 1),
      })),
    );
  }

  get seen(): boolean {
    return this.sheet.seen;
  }

  private draw(): void {
    const { state, sheet, dragged } = this;
    const d = state.drop!;
    if (sheet.width < 40 || !sheet.seen) return;
    const clock = state.clock();
    const before = d.from - 1e-3 * (d.to - d.from);
    // Where the balls are as they are let go.
    const time = dragged === "gap" ? before : dragged === "height" ? d.start : Sheet.printing ? d.stop : state.time();
    const rate = dragged === "gap" ? clock.rate(0.5 * (d.from + d.to)) : state.view.slow ? clock.rate(time) : 1;
    const moment = {
      time,
      screen: clock.toScreen(time),
      rate,
      newton: d.motion.newton.at(time),
      icm: d.motion.icm.at(time),
    };
    const label = dragged && {
      ball: dragged === "gap" ? d.scenario.balls.length - 1 : 0,
      text: this.describe(dragged),
    };
    const letters = Math.min(this.textSize(), sheet.width / 24, sheet.height / 16);
    this.layout = null;
    if (d.scenario.cradle) drawCloseUp(sheet.g, sheet.width, sheet.height, d, moment, state.theme, letters);
    else
      this.layout = drawDuel(
        sheet.g,
        sheet.width,
        sheet.height,
        d,
        { ...moment, dragged: label },
        (t) => clock.toScreen(t),
        state.theme,
        letters,
      );
    const now = performance.now();
    const runs = state.playing && !dragged && state.screen < clock.length;
    if (!runs || now - this.placed > nearly) this.placeHandles(now);
    const slower = 1 / rate;
    setText(
      find("watch-speed"),
      dragged
        ? ""
        : slower < 1.05
          ? "real time"
          : `${slower < 10 ? slower.toFixed(1) : Math.round(Number(slower.toPrecision(2)))} × slower`,
    );
    setText(find("watch-play"), state.playing ? "Pause" : "Play");
  }

  private placeHandles(now: number): void {
    this.placed = now;
    for (const { what, world, handle } of this.handles)
      handle.place(this.layout && (what === "gap" ? this.layout.worlds[world].top : this.layout.worlds[world].lowest));
  }

  // The controls follow the setting.
  private refresh(): void {
    void this.state.drop;
    const gap = this.value("gap");
    const text = this.describe("gap");
    this.slider.value = String(toSlider(ranges.gap, gap));
    setAttribute(this.slider, "aria-valuetext", text);
    setText(find("watch-gap-value"), text);
    for (const { world, handle } of this.handles) if (world === 0) handle.refresh();
  }

  // ---- changes ----------------------------------------------------------------------------------------

  private value(what: Dragged): number {
    const { scenario } = this.state;
    return what === "gap" ? scenario.gaps[firstGap(scenario)] : scenario.height;
  }

  private describe(what: Dragged): string {
    return what === "gap" && this.value("gap") === 0 ? "touching" : withUnit(this.value(what), "m");
  }

  private set(what: Dragged, value: number): void {
    const { scenario } = this.state;
    const tidy = Number(value.toPrecision(3));
    if (what === "height")
      scenario.height = clampTo(ranges.height, Math.max(tidy, Number((lowestHeight(scenario) + 1e-3).toPrecision(4))));
    else
      scenario.gaps = scenario.gaps.map((old, i) =>
        i < firstGap(scenario) ? old : tidy < ranges.gap.low ? 0 : clampTo(ranges.gap, tidy),
      );
    this.refresh();
    this.state.edited();
    if (!this.dragged) this.playFrom(what);
  }

  private playFrom(what: Dragged): void {
    const { drop } = this.state;
    if (drop) this.film.seek(what === "gap" ? Math.max(drop.start, drop.from - slowTo) : drop.start);
    this.film.play(this.moves());
  }

  private pull(what: Dragged, label: string): Pull {
    return {
      label,
      range: what === "gap" ? { low: 0, high: ranges.gap.high } : ranges.height,
      value: () => this.value(what),
      text: () => this.describe(what),
      set: (value) => this.set(what, value),
      perPixel: () => 1 / (this.layout?.scale ?? Infinity),
      size: () =>
        what === "gap" ? this.state.scenario.balls[this.state.scenario.balls.length - 1].radius : this.value("height"),
      dragged: (on) => {
        this.dragged = on ? what : null;
        if (!on) this.playFrom(what);
        this.state.redraw();
      },
    };
  }
}
