// Lecture mode: the explaining sentence, the story, single panels, setting A, the curves.
import { Compare } from "../views/compare";
import { find, Sheet, tell } from "../support/dom";
import type { Film } from "../views/film";
import { Frames, SinglePanel } from "../app/frames";
import type { Step } from "./lecture_view";
import type { MapPanel } from "../map/map_panel";
import { fillMeasured } from "../views/measured_table";
import { Mini } from "../views/mini";
import type { Pool } from "../core/pool";
import { ReboundPanel } from "../views/rebound_panel";
import type { State } from "../app/state";
import { Story } from "./story";
import { factsOf } from "./story_text";
import { why } from "./why";

export class Lecture {
  private readonly frames = new Frames();
  private readonly single: SinglePanel;
  private readonly story: Story;
  private readonly rebound: ReboundPanel;
  private readonly compare: Compare;
  private readonly mini: Mini;
  private mapped: number | null = null; // computing time of the map that the story has reported
  private entered: { step: Step; placed: boolean } | null = null; // a step that waits until the drop is computed

  constructor(
    private readonly state: State,
    private readonly film: Film,
    private readonly map: MapPanel,
    pool: Pool,
    private readonly moves: () => boolean,
    load: (example: string) => void,
    resized: () => void,
  ) {
    const view = state.lecture;
    this.rebound = new ReboundPanel(state, view, new Sheet("rebound", resized), pool);
    this.compare = new Compare(state, view, new Sheet("compare-stage", resized), pool, () => this.settingsChanged());
    this.mini = new Mini(state);
    this.single = new SinglePanel(this.frames, state, () => this.show());
    this.story = new Story(state, view, film, new Sheet("tale", resized), this.frames, {
      told: () => ({ gaps: this.rebound.extremes(), trusted: this.map.trusted() }),
      entered: (step) => this.enter(step),
      left: () => this.show(),
      load,
    });
    fillMeasured();
    this.show();
    if (view.step) this.enter(view.step, state.view.time !== null);
  }

  // Shows what the link or the user selects: the whole page, the story or one panel.
  show(): void {
    const { step, panel } = this.state.lecture;
    if (!step && !panel) this.frames.show(null, []);
    this.single.show();
    this.story.show();
    this.compare.refresh();
    this.state.redraw();
  }

  private settingsChanged(): void {
    this.compare.refresh();
    this.rebound.refresh();
  }

  // ---- what follows from a change -----------------------------------------------------------------------

  solved(): void {
    const drop = this.state.drop!;
    const text = why(factsOf(drop));
    if (find("why").textContent !== text) tell(find("why"), text);
    tell(find("mini-verdict"), find("verdict").textContent);
    this.settingsChanged();
    this.single.refreshLink();
    if (this.entered) this.enter(this.entered.step, this.entered.placed);
    this.story.dirty = true;
  }

  // Called once per frame; says whether the plots of the drop and the film were redrawn.
  frame(plots: boolean, film: boolean): void {
    if (plots) this.rebound.dirty = true;
    if (plots || film) {
      this.story.dirty = true;
      this.compare.draw();
      this.mini.draw();
    }
    const { elapsed } = this.map.map;
    if (this.rebound.dirty || elapsed !== this.mapped) this.story.dirty = true;
    this.mapped = elapsed;
    this.rebound.drawIfDue();
    this.story.frame();
  }

  // ---- the story ----------------------------------------------------------------------------------------

  // Sets film and map for a step; `placed`: the link gives the time of the film.
  private enter(step: Step, placed = false): void {
    const { state, film } = this;
    const { drop } = state;
    this.entered = drop ? null : { step, placed };
    if (!drop) return;
    const contact = this.moves() ? drop.from - 0.02 : 0.5 * (drop.from + drop.to);
    const actions: Partial<Record<Step, () => void>> = {
      predict: () => this.start(false, 0, false),
      drop: () => this.start(false, this.moves() ? 0 : Infinity, this.moves()),
      slow: () => this.start(true, contact, this.moves()),
      gap: () => this.rebound.setAxis("gap"),
      map: () => this.map.showTrusted(),
    };
    if (!placed || step === "gap" || step === "map") actions[step]?.();
    film.refresh();
    state.redraw();
  }

  // Plays the film from a time; 0 and infinity mean its ends.
  private start(slow: boolean, time: number, plays: boolean): void {
    const { state, film } = this;
    state.view.slow = slow;
    const clock = state.clock();
    state.screen = time === 0 ? 0 : clock.toScreen(Math.min(time, clock.stop));
    film.play(plays);
  }
}
