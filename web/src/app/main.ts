// The page: creates its parts and updates them after a change of the scenario.
import { Controls } from "./controls";
import { find, refocus, Sheet } from "../support/dom";
import { dropOf, type Answered, type Drop, type Solved, type Unsolved } from "../core/drop";
import { newton } from "../scenario/tables";
import { signal, untracked } from "@preact/signals-core";
import { catchUp, hold, later } from "../support/later";
import { joined, type Sentence } from "../support/sentence";
import { fillTolerances } from "./tolerances";
import { Film } from "../views/film";
import { forcesSummary } from "../views/forces";
import { digits } from "../support/format";
import { Presenter } from "../story/presenter";
import { firstStoryView, storyFromQuery, sameScenario } from "../scenario/story_view";
import { MapPanel } from "../map/map_panel";
import { fillDefinitions, fillEnergy, fillTable } from "../views/numbers";
import { ForcesPanel, TimelinePanel } from "../views/panels";
import { Desk, piece, Pool } from "../core/pool";
import { presets, type Preset } from "../scenario/presets";
import { copyOf, type Scenario } from "../scenario/scenario";
import { settingOf } from "../scenario/link";
import { listenMenu } from "./menu";
import { Past } from "../state/past";
import { Headline } from "./headline";
import { SoundSwitch } from "./share";
import { Progress } from "./progress";
import { compiled } from "../support/script";
import { Drawing } from "../state/signals";
import { moves, State } from "../state/state";
import { ThemeSwitch } from "../support/theme_switch";
import { firstView, viewFromQuery } from "../scenario/view";

const shortly = 100; // ms until a part of a result is shown; `patience` before the first picture
const stillness = 250; // ms after the last change until a slider counts as stopped
const patience = 500; // longest wait for the first picture [ms]
const leisure = 1500; // ms after the start or a change until plots out of the window are computed

const root = document.documentElement;

class Page {
  private readonly state: State;
  private readonly controls: Controls;
  private readonly film: Film;
  private readonly forces: ForcesPanel;
  private readonly timeline: TimelinePanel;
  private readonly map: MapPanel;
  private readonly presenter: Presenter;
  private readonly forcesSheet: Sheet;
  private readonly desk: Desk;
  private readonly pool: Pool;
  private readonly progress = new Progress(() => this.giveUp());
  private readonly headline = new Headline();
  private preset = "";
  private about = "";
  private lastFrame = 0;
  private written = -Infinity; // when texts and tables were written [ms]
  private requested = 0; // revision of the state that was sent to the core
  private opened = false; // the first picture is drawn
  private readonly shown = signal<{ drop: Drop } | null>(null);
  private readonly headlineText = new Drawing(() => this.writeHeadline());
  private readonly laboratory = new Drawing(() => this.fillLaboratory());
  private readonly plots = new Drawing(() => {
    const { value } = this.shown;
    if (value) untracked(() => this.startPlots(value.drop));
  });
  private frames = 0; // since the first picture
  private early = 0; // timer for showing a part of a result
  private maps: Promise<WebAssembly.Module> | null = null; // the core with the functions for plots and maps
  private readonly past: Past;
  private readonly sound: SoundSwitch;

  constructor() {
    hold();
    this.desk = new Desk(this.module, window.first);
    this.pool = new Pool();
    const state = (this.state = new State(copyOf(presets[0].scenario), () => this.edited()));
    new ThemeSwitch(state, () => this.drawAll());
    const resized = (): void => this.resized();
    this.fillPresets();
    this.readLink();
    this.fillTolerances();
    this.past = new Past(state.scenario);
    this.controls = new Controls(find("controls"), state.scenario, () => this.edited());
    this.film = new Film(state, new Sheet("stage", resized));
    this.forcesSheet = new Sheet("forces", resized);
    this.forces = new ForcesPanel(state, this.forcesSheet, this.film);
    this.timeline = new TimelinePanel(state, new Sheet("timeline", resized), this.pool);
    this.map = new MapPanel(state, new Sheet("map", resized), this.pool);
    this.presenter = new Presenter(
      state,
      this.film,
      this.map,
      this.pool,
      moves,
      (scenario) => this.put(scenario),
      resized,
    );
    find("notes")
      .querySelector("button")!
      .addEventListener("click", () => {
        this.note([]);
        refocus();
      });
    addEventListener("popstate", () => this.goBack());
    addEventListener("resize", () => this.headline.keepHeights(false));
    const plots = { map: this.map, timeline: this.timeline.timeline, rebound: this.presenter.rebound };
    listenMenu(state, this.pool, plots, {
      undo: () => this.undo(),
      put: (scenario) => {
        state.scenario = scenario;
        this.edited();
      },
      note: (notes) => this.note(notes),
    });
    this.sound = new SoundSwitch(state);
    this.frame(performance.now());
  }

  // Applies the link to its example, or to the first one.
  private readLink(): void {
    const { state } = this;
    const notes: string[] = [];
    const query = new URLSearchParams(location.search);
    const { preset, scenario } = settingOf(query, notes);
    state.scenario = scenario;
    const { map, ...view } = firstView();
    Object.assign(state.view, view);
    Object.assign(state.view.map, map, preset.map);
    Object.assign(state.story, firstStoryView());
    viewFromQuery(state.view, query, notes, scenario);
    storyFromQuery(state.story, query, notes);
    this.note(notes);
    state.playing = state.view.time === null && moves();
    this.findPreset();
  }

  // The browser has gone to another entry of its history.
  private goBack(): void {
    this.readLink();
    this.past.settle(this.state.scenario);
    this.map.map.setShow(this.state.view.map.show);
    this.fillTolerances();
    this.state.screen = 0;
    this.state.revision++;
    this.film.refresh();
    this.presenter.show();
  }

  // ---- scenario ---------------------------------------------------------------------------------------

  private fillPresets(): void {
    const select = find<HTMLSelectElement>("preset");
    const own = new Option("Your own", "");
    own.hidden = true;
    select.append(own, ...presets.map((p) => new Option(p.name, p.id)));
    select.addEventListener("change", () => {
      const preset = presets.find((p) => p.id === select.value);
      if (preset) this.load(preset);
    });
  }

  // Two figures of the paper have the same column and differ in their map.
  private findPreset(): void {
    const { scenario, view } = this.state;
    const same = presets.filter((p) => sameScenario(p.scenario, scenario));
    this.choosePreset((same.find((p) => p.map?.axis === view.map.axis) ?? same[0])?.id ?? "");
  }

  private choosePreset(id: string): void {
    this.preset = id;
    find<HTMLSelectElement>("preset").value = id;
    this.about = presets.find((p) => p.id === id)?.about ?? "";
  }

  private load(preset: Preset): void {
    const { state } = this;
    this.headline.keepHeights(false);
    state.enterHistory();
    state.scenario = copyOf(preset.scenario);
    Object.assign(state.view.map, { across: "e", zoom: null }, preset.map);
    this.map.map.setShow(state.view.map.show);
    state.view.time = null;
    state.screen = 0;
    this.note([]);
    this.past.remember(this.state.scenario);
    this.choosePreset(preset.id);
    state.revision++;
    this.film.play(moves());
  }

  // A chapter of the story changes the balls.
  private put(scenario: Scenario): void {
    this.state.scenario = scenario;
    this.past.settle(scenario);
    this.findPreset();
    this.state.revision++;
  }

  private undo(): void {
    const before = this.past.undo();
    if (!before) return;
    this.state.scenario = before;
    this.findPreset();
    this.state.revision++;
  }

  private edited(): void {
    this.past.remember(this.state.scenario);
    if (this.preset) this.choosePreset("");
    this.state.revision++;
  }

  private note(notes: string[]): void {
    const box = find("notes");
    box.hidden = notes.length === 0;
    box.querySelector("ul")!.replaceChildren(
      ...notes.slice(0, 15).map((text) => {
        const li = document.createElement("li");
        li.textContent = text;
        return li;
      }),
    );
  }

  // Loaded after the first result.
  private readonly module = (): Promise<WebAssembly.Module> =>
    (this.maps ??= compiled("maps.wasm").then((module) => {
      this.pool.open(module);
      return module;
    }));

  // ---- updates ----------------------------------------------------------------------------------------

  // Returns whether other controls are shown, which takes a whole frame.
  private solve(): boolean {
    const { state } = this;
    this.requested = state.revision;
    this.progress.begin(newton.label);
    root.dataset.busy = "";
    root.toggleAttribute("data-cradle", state.scenario.cradle);
    clearTimeout(this.early);
    const ask = { scenario: copyOf(state.scenario), tolerance: state.view.tolerance };
    this.desk.put(
      piece<"solve">({
        kind: "solve",
        ask,
        begun: (what, share, known) => {
          this.progress.update(what, share);
          if (!known) return;
          clearTimeout(this.early);
          this.early = window.setTimeout(() => this.answered(known), state.drop ? shortly : patience);
        },
        done: (result) => this.solved(result),
        failed: (error) =>
          this.solved({ scenario: ask.scenario, reason: `This setting could not be computed: ${error}` }),
      }),
    );
    return state.story.step === null && this.controls.set(state.scenario, this.about, !Sheet.moving);
  }

  private solved(result: Solved | Unsolved): void {
    clearTimeout(this.early);
    const { state } = this;
    const share = state.drop ? state.screen / state.clock().length : 0;
    if (!this.desk.waits) this.progress.end();
    later(() => void this.module());
    if ("reason" in result) {
      state.drop = null;
      state.answer = null;
      this.headline.write(result.reason, "", "");
      if (state.story.step === null) this.controls.set(state.scenario, this.about, true);
      this.rested();
      return;
    }
    state.drop = dropOf(result);
    if (state.view.time !== null) {
      const kept = Math.min(Math.max(state.view.time, result.start), result.stop);
      if (Math.abs(kept - state.view.time) > 1e-6)
        this.note([`t = ${state.view.time} s is outside the film: ${digits(kept)} s used`]);
      this.film.seek(kept);
      state.view.time = null;
    } else state.screen = Math.min(share, 1) * state.clock().length;
    if (this.frames > 1) return this.show(state.drop);
    // The first picture is drawn at once.
    if (state.story.step) this.presenter.open();
    else this.film.open();
    this.opened = true;
    root.dataset.ready = String(Math.round(performance.now()));
  }

  // Shows a drop: texts, tables and plots.
  private show(drop: Drop): void {
    const { state } = this;
    this.shown.value = { drop };
    this.answered(drop);
    this.presenter.solved();
    state.redraw();
    state.writeLink();
  }

  // Returns to the last setting that was solved.
  private giveUp(): void {
    clearTimeout(this.early);
    const { state } = this;
    this.desk.giveUp();
    this.progress.end();
    delete root.dataset.busy;
    if (!state.drop) return this.headline.write("Given up. Change a parameter to compute again.", "", "");
    state.scenario = copyOf(state.drop.scenario);
    state.view.tolerance = state.drop.comparison.tolerance;
    this.fillTolerances();
    this.requested = state.revision;
    this.past.settle(state.scenario);
    root.toggleAttribute("data-cradle", state.scenario.cradle);
    this.findPreset();
    this.controls.set(state.scenario, this.about, true);
    this.show(state.drop);
  }

  // Shows a result, perhaps of one model only. While a slider moves, texts and tables are written less often.
  private answered(d: Answered): void {
    this.state.answer = { of: d, tolerance: this.state.view.tolerance };
    if (!Sheet.moving || performance.now() - this.written >= Sheet.often) this.write();
  }

  // Writes the texts and tables of a report that has changed.
  private write(): void {
    const began = performance.now();
    const changed = this.headlineText.refresh();
    const { report, story } = this.state;
    const filled = story.step === null && this.laboratory.refresh();
    if (!report || !(changed || filled)) return;
    if (report.icm.length > 0) root.dataset.numbers = JSON.stringify(report.numbers);
    this.plots.refresh();
    this.rested();
    this.written = performance.now();
    Sheet.wrote(this.written - began);
  }

  private writeHeadline(): void {
    const { report } = this.state;
    if (!report) return;
    this.headline.write(
      joined(report.newton),
      report.icm.length > 0 ? joined(report.icm) : "Independent collisions are still being computed.",
      report.verdict?.text ?? "",
    );
    this.presenter.write(report);
  }

  // Starts the computation of plots over many settings, unless they are those of this drop.
  private startPlots(drop: Drop): void {
    this.forcesSheet.canvas.setAttribute("aria-description", forcesSummary(drop));
    this.map.refreshChoices();
    this.timeline.refresh();
    this.map.refresh();
    this.presenter.refreshPlots();
  }

  // Called when a result is shown: the page is busy until it is that of the last setting.
  private rested(): void {
    if (!this.desk.waits && this.requested === this.state.revision) delete root.dataset.busy;
  }

  // The story does not show these; they are written when the laboratory is open.
  private fillLaboratory(): void {
    const { report } = this.state;
    if (!report) return;
    this.controls.set(this.state.scenario, this.about, true);
    fillTable(find("numbers"), report);
    fillDefinitions(find("definitions").querySelector("dl")!, report);
    fillEnergy(find("energy"), report);
  }

  // The present contents of the page as data, for tests.
  readonly report = (): object | null => {
    const { report, scenario, view, story } = this.state;
    if (!report) return null;
    const { read, all } = this.presenter.sentences();
    const sentences: Sentence[] = [
      ...report.newton,
      ...report.icm,
      ...report.why,
      ...(report.verdict ? [report.verdict] : []),
      ...all,
    ];
    return {
      ...report,
      current: JSON.stringify(report.setting) === JSON.stringify(scenario),
      step: story.step,
      story: read,
      sentences,
      time: this.state.time(),
      tolerance: view.tolerance,
      link: this.state.link(),
    };
  };

  private fillTolerances(): void {
    fillTolerances(this.state.view, () => this.state.revision++);
  }

  // A plot that comes into view may have to be computed.
  private resized(): void {
    this.state.redraw();
    this.pool.wake();
  }

  // ---- drawing ----------------------------------------------------------------------------------------

  private readonly frame = (now: number): void => {
    requestAnimationFrame(this.frame);
    const { state } = this;
    if (this.opened) this.frames++;
    if (this.frames === 1) return; // the first picture is painted
    if (this.frames === 2 && state.drop) this.show(state.drop);
    else if ((this.frames > 2 || now > patience) && catchUp(8)) root.toggleAttribute("data-complete", true);
    this.rest(now);
    const passed = Math.min((now - this.lastFrame) / 1000, 0.1);
    this.lastFrame = now;
    if (this.requested !== state.revision && this.solve()) return;
    if (now - this.written >= Sheet.often) this.write();
    if (state.drop && state.playing && this.presenter.plays) this.film.advance(passed);
    this.sound.follow();
    if (state.drop) this.draw(now);
    this.presenter.frame(now);
  };

  // Plots out of the window are computed and drawn after the last change.
  private rest(now: number): void {
    const moving = now - this.past.changedAt < stillness;
    const idle = this.state.drop !== null && now - Math.max(this.past.changedAt, 0) > leisure;
    const rests = idle && !Sheet.idle;
    const wake = rests || (Sheet.moving && !moving);
    const { step, panel } = this.state.story;
    if (moving && !Sheet.moving && !step && !panel) this.headline.keepHeights(true);
    if (moving !== Sheet.moving) root.toggleAttribute("data-moving", moving);
    Sheet.moving = this.state.moving = moving;
    Sheet.idle = idle;
    if (rests) this.presenter.prepare();
    if (wake) this.pool.wake();
  }

  // Draws one of the large plots per frame, and the film.
  private draw(now: number): void {
    const forces = (this.forcesSheet.shown() || !Sheet.moving) && this.forces.picture.refresh();
    if (!forces && !(this.timeline.due(now) && this.timeline.picture.refresh())) this.map.drawIfDue(now);
    this.film.picture.refresh();
    this.forces.cursor.refresh();
    this.timeline.cursor.refresh();
  }

  private drawAll(): void {
    if (!this.state.drop) return;
    this.state.redraw();
    const pictures = (): void => {
      for (const { picture } of [this.film, this.forces, this.timeline]) picture.refresh();
      this.map.drawIfDue(Infinity);
    };
    pictures();
    if (Sheet.printing && this.presenter.print()) pictures();
    this.presenter.frame(performance.now());
  }
}

try {
  const page = new Page();
  Object.assign(window, { hardlimit: { report: page.report } });
} catch (error) {
  find("verdict").textContent = `The page could not start: ${String(error)}`;
  throw error;
}
