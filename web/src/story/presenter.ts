// Shows the page as a whole, as the story or as a single panel, with setting A and the curves.
import { Compare } from "../views/compare";
import { find, setSentence, Sheet } from "../support/dom";
import { later } from "../support/later";
import type { Film } from "../views/film";
import { Frames, SinglePanel } from "../state/frames";
import { firstStep, type Step } from "../scenario/story_view";
import type { MapPanel } from "../map/map_panel";
import { fillMeasured } from "../views/measured_table";
import { Mini } from "../views/mini";
import type { Pool } from "../core/pool";
import { ReboundPanel } from "../views/rebound_panel";
import type { State } from "../state/state";
import type { Scenario } from "../scenario/scenario";
import type { View } from "../scenario/view";
import { ContactSteps } from "./contact_steps";
import { Paper } from "./paper";
import { Prediction } from "./prediction";
import { Story } from "./story";
import { Observation } from "./observation";
import type { Report } from "../report/report";
import { joined, type Sentence } from "../support/sentence";

export class Presenter {
  private readonly frames = new Frames();
  private readonly single: SinglePanel;
  private readonly story: Story;
  readonly rebound: ReboundPanel;
  private readonly compare: Compare;
  private readonly mini: Mini;
  private placed: boolean; // the link gives the time of the film

  constructor(
    private readonly state: State,
    private readonly film: Film,
    private readonly map: MapPanel,
    pool: Pool,
    private readonly moves: () => boolean,
    put: (scenario: Scenario) => void,
    resized: () => void,
  ) {
    const view = state.story;
    this.rebound = new ReboundPanel(state, view, new Sheet("rebound", resized), pool);
    this.compare = new Compare(state, view, new Sheet("compare-stage", resized), pool, () => this.settingsChanged());
    this.mini = new Mini(state);
    this.single = new SinglePanel(this.frames, state, () => {
      this.story.leave();
      this.show();
    });
    const textSize = (): number => this.frames.textSize();
    const host = {
      fromPlots: () => ({ gaps: this.rebound.extremes(), trusted: this.map.trusted() }),
      arrived: (step: Step) => this.arrive(step),
      showMap: (view: View["map"] | null) => (view ? this.map.showAs(view) : this.map.showTrusted()),
      left: () => this.show(),
      paintCurve: (...paper: Parameters<ReboundPanel["paint"]>) => this.rebound.paint(...paper),
      put,
    };
    this.story = new Story(
      state,
      view,
      film,
      new Paper(pool),
      this.frames,
      host,
      new Observation(state, film, new Sheet("duel", resized), moves, textSize),
      new Prediction(state, view, new Sheet("prediction", resized), moves, textSize),
      new ContactSteps(state, new Sheet("lone", resized), new Sheet("overlap", resized), textSize),
    );
    later(fillMeasured);
    this.placed = state.view.time !== null;
    this.show();
  }

  // Shows what the link or the user selects: the whole page, the story or one panel.
  show(): void {
    const { step, panel } = this.state.story;
    this.story.show();
    if (!step && !panel) this.frames.show(null, []);
    this.single.show();
    this.compare.refresh();
    this.state.redraw();
  }

  private settingsChanged(): void {
    this.compare.refresh();
    this.rebound.refresh();
  }

  // The sentences of the chapter that is read, and of all chapters.
  sentences(): { read: Sentence[]; all: Sentence[] } {
    const chapters = this.story.sentences();
    return chapters
      ? { read: chapters[this.state.story.step!], all: Object.values(chapters).flat() }
      : { read: [], all: [] };
  }

  // The first picture of the story, if the first chapter is read.
  open(): void {
    if (this.state.story.step === firstStep) this.story.open();
  }

  get plays(): boolean {
    return this.story.plays;
  }

  // Writes a report, perhaps before the film is computed.
  write(report: Report): void {
    const text = joined(report.why);
    if (find("why").textContent !== text) setSentence(find("why"), text);
    setSentence(find("mini-verdict"), joined([...report.newton, ...report.icm]));
  }

  // ---- what follows from a change -----------------------------------------------------------------------

  solved(): void {
    this.story.solved();
  }

  refreshPlots(): void {
    this.settingsChanged();
    this.single.refreshLink();
  }

  // Called once per frame.
  frame(now: number): void {
    this.compare.picture.refresh();
    this.mini.picture.refresh();
    this.rebound.drawIfDue(now);
    this.story.frame(now);
  }

  // Before the pictures for paper are drawn: whether those of other balls are drawn then.
  print(): boolean {
    return this.story.print();
  }

  // ---- the story ----------------------------------------------------------------------------------------

  // Computes the plots of later chapters, so that the story can be printed.
  prepare(): void {
    if (this.state.story.step && this.state.drop) this.story.prepare();
  }

  // Prepares a chapter when it comes into view.
  private arrive(step: Step): void {
    const { drop } = this.state;
    if (!drop) return;
    const film = !this.placed;
    if (step === "watch" && film) this.start(this.moves() ? Math.max(drop.start, drop.from - 0.35) : Infinity);
    if (step === "slow" && film) this.start(this.moves() ? drop.from - 0.02 : 0.5 * (drop.from + drop.to));
    if (step === "watch" || step === "slow") this.placed = false;
    if (step === "gap") this.rebound.setAxis("gap");
    if (step === "map") this.map.showTrusted();
  }

  // Plays the film from a time.
  private start(time: number): void {
    const { state, film } = this;
    state.view.slow = true;
    film.seek(Math.min(time, state.clock().stop));
    film.play(this.moves());
  }
}
