// The page: creates its parts and updates them after a change of the scenario.
import { Controls } from "./controls";
import { find, Sheet, tell } from "../support/dom";
import { dropOf, type Solved, type Unsolved } from "../core/drop";
import { save } from "./exporting";
import { Film } from "../views/film";
import { forcesSummary } from "../views/forces";
import { digits } from "../support/format";
import { Lecture } from "../story/lecture";
import { baseOf, firstLectureView, lectureFromQuery } from "../story/lecture_view";
import { MapPanel } from "../map/map_panel";
import { exactNumbers, fillDefinitions, fillEnergy, fillTable, verdict } from "../views/numbers";
import { ForcesPanel, TimelinePanel } from "../views/panels";
import { picture } from "../views/picture";
import { Desk, piece, Pool } from "../core/pool";
import { presets, type Preset } from "../scenario/presets";
import { copyOf, fromQuery, toQuery, toToml, type Scenario } from "../scenario/scenario";
import { Announcer, Progress } from "./progress";
import { State } from "./state";
import { ThemeSwitch } from "../style/theme_switch";
import { firstView, viewFromQuery } from "./view";

const queryOf = (s: Scenario): string => {
  const q = new URLSearchParams();
  toQuery(s, q);
  return q.toString();
};

const moves = (): boolean => !matchMedia("(prefers-reduced-motion: reduce)").matches;

class Page {
  private readonly state: State;
  private readonly controls: Controls;
  private readonly film: Film;
  private readonly forces: ForcesPanel;
  private readonly timeline: TimelinePanel;
  private readonly map: MapPanel;
  private readonly lecture: Lecture;
  private readonly forcesSheet: Sheet;
  private readonly desk: Desk;
  private readonly pool: Pool;
  private readonly progress = new Progress(() => this.giveUp());
  private readonly announcer = new Announcer();
  private preset = "";
  private about = "";
  private lastFrame = 0;

  constructor(module: WebAssembly.Module) {
    this.desk = new Desk(module);
    this.pool = new Pool(module);
    const state = (this.state = new State(copyOf(presets[0].scenario), () => this.edited()));
    const resized = (): void => this.resized();
    this.fillPresets();
    this.readLink();
    this.controls = new Controls(find("controls"), state.scenario, () => this.edited());
    this.film = new Film(state, new Sheet("stage", resized));
    this.forcesSheet = new Sheet("forces", resized);
    this.forces = new ForcesPanel(state, this.forcesSheet, this.film);
    this.timeline = new TimelinePanel(state, new Sheet("timeline", resized), this.pool);
    this.map = new MapPanel(state, new Sheet("map", resized), this.pool);
    this.lecture = new Lecture(state, this.film, this.map, this.pool, moves, (id) => this.load(presets.find((p) => p.id === id)!), resized);
    find("notes").querySelector("button")!.addEventListener("click", () => this.note([]));
    addEventListener("popstate", () => this.goBack());
    new ThemeSwitch(state);
    this.listenFiles();
    this.frame(performance.now());
  }

  // The preset named in the link, or the first, with what the link changes.
  private readLink(): void {
    const { state } = this;
    const notes: string[] = [];
    const query = new URLSearchParams(location.search);
    const named = presets.find((p) => p.id === query.get("example"));
    if (query.get("example") !== null && !named) notes.push(`example = “${query.get("example")?.slice(0, 20)}” is unknown: ${presets.find((p) => p.id === baseOf(query))!.name} is shown`);
    const preset = named ?? presets.find((p) => p.id === baseOf(query))!;
    state.scenario = copyOf(preset.scenario);
    Object.assign(state.view, firstView());
    Object.assign(state.lecture, firstLectureView());
    Object.assign(state.view.map, preset.map);
    fromQuery(state.scenario, query, notes);
    viewFromQuery(state.view, query, notes);
    lectureFromQuery(state.lecture, query, notes);
    this.note(notes);
    state.playing = state.view.time === null && moves();
    this.choosePreset([preset, ...presets].find((p) => queryOf(p.scenario) === queryOf(state.scenario))?.id ?? "");
  }

  // Back to the setting before the last choice of an example.
  private goBack(): void {
    this.readLink();
    this.map.map.setShow(this.state.view.map.show);
    this.state.screen = 0;
    this.state.dirty.solve = true;
    this.film.refresh();
    this.lecture.show();
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

  private choosePreset(id: string): void {
    this.preset = id;
    find<HTMLSelectElement>("preset").value = id;
    this.about = presets.find((p) => p.id === id)?.about ?? "";
  }

  private load(preset: Preset): void {
    const { state } = this;
    state.enterHistory();
    state.scenario = copyOf(preset.scenario);
    state.view.map.zoom = null;
    Object.assign(state.view.map, preset.map);
    this.map.map.setShow(state.view.map.show);
    state.view.time = null;
    state.screen = 0;
    this.note([]);
    this.choosePreset(preset.id);
    state.dirty.solve = true;
    this.film.play(moves());
  }

  private edited(): void {
    if (this.preset) this.choosePreset("");
    this.state.dirty.solve = true;
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

  // ---- updates ----------------------------------------------------------------------------------------

  // Returns whether the controls have changed, which takes a whole frame.
  private solve(): boolean {
    const { state } = this;
    const built = this.controls.set(state.scenario, this.about);
    this.progress.begin();
    const ask = { scenario: copyOf(state.scenario) };
    this.desk.put(
      piece<"solve">({
        kind: "solve",
        ask,
        begun: (what, share) => this.progress.tell(what, share),
        done: (result) => this.solved(result),
        failed: (error) => this.solved({ scenario: ask.scenario, reason: `This setting could not be computed: ${error}` }),
      }),
    );
    return built;
  }

  private solved(result: Solved | Unsolved): void {
    const { state } = this;
    const share = state.drop ? state.screen / state.clock().length : 0;
    if (!this.desk.waits) this.progress.end();
    if ("reason" in result) {
      state.drop = null;
      this.say([result.reason, ""]);
      return;
    }
    state.drop = dropOf(result);
    if (state.view.time !== null) {
      const kept = Math.min(Math.max(state.view.time, result.start), result.stop);
      if (Math.abs(kept - state.view.time) > 1e-6) this.note([`t = ${state.view.time} s is outside the film: ${digits(kept)} s used`]);
      this.film.seek(kept);
      state.view.time = null;
    } else state.screen = Math.min(share, 1) * state.clock().length;
    this.tellNumbers();
    this.forcesSheet.canvas.setAttribute("aria-description", forcesSummary(state.drop));
    this.map.refreshChoices();
    this.timeline.refresh();
    this.map.refresh();
    this.lecture.solved();
    state.redraw();
    state.writeLink();
    document.documentElement.dataset.ready ??= String(Math.round(performance.now()));
  }

  // Back to the setting that was solved last.
  private giveUp(): void {
    const { state } = this;
    this.desk.giveUp();
    this.progress.end();
    if (!state.drop) return this.say(["Given up. Change a parameter to compute again.", ""]);
    state.scenario = copyOf(state.drop.scenario);
    state.dirty.solve = false;
    this.choosePreset(presets.find((p) => queryOf(p.scenario) === queryOf(state.scenario))?.id ?? "");
    this.controls.set(state.scenario, this.about);
  }

  private tellNumbers(): void {
    const d = this.state.drop!;
    fillTable(find("numbers"), d);
    find("rebound-said").hidden = d.scenario.cradle;
    fillDefinitions(find("definitions").querySelector("dl")!, d);
    fillEnergy(find("energy"), d);
    this.say(verdict(d));
    document.documentElement.dataset.numbers = JSON.stringify(exactNumbers(d));
  }

  private say([newton, icm]: [string, string]): void {
    const [a, b] = [document.createElement("span"), document.createElement("span")];
    a.className = "newton";
    b.className = "icm";
    tell(a, newton + " ");
    tell(b, icm);
    find("verdict").replaceChildren(a, b);
    this.announcer.say(`${newton} ${icm}`);
  }

  // A newly shown plot may not be computed yet.
  private resized(): void {
    this.state.redraw();
    this.pool.wake();
  }

  // ---- drawing ----------------------------------------------------------------------------------------

  private readonly frame = (now: number): void => {
    requestAnimationFrame(this.frame);
    const { state } = this;
    const passed = Math.min((now - this.lastFrame) / 1000, 0.1);
    this.lastFrame = now;
    if (state.dirty.solve) {
      state.dirty.solve = false;
      if (this.solve()) return;
    }
    if (state.drop && state.playing) this.film.advance(passed);
    const plots = this.drawPlots(now);
    const film = state.dirty.stage && state.drop !== null;
    if (film) {
      state.dirty.stage = false;
      this.film.draw();
      this.markTime();
    }
    this.lecture.frame(plots, film);
  };

  // Draws one of the large plots per frame; returns whether the drop was redrawn.
  private drawPlots(now: number): boolean {
    const { dirty, drop } = this.state;
    const forces = dirty.plots && drop !== null;
    if (forces) {
      dirty.plots = false;
      this.forces.draw();
      this.forces.mark();
    } else if (this.timeline.due(now)) {
      this.timeline.draw();
      this.timeline.mark();
    } else this.map.drawIfDue(now);
    return forces;
  }

  private markTime(): void {
    this.forces.mark();
    this.timeline.mark();
  }

  // ---- files ------------------------------------------------------------------------------------------

  private listenFiles(): void {
    const { state } = this;
    const say = (id: string, text: string): void => {
      const button = find(id);
      const before = button.dataset.name ?? button.textContent ?? "";
      button.dataset.name = before;
      button.textContent = text;
      setTimeout(() => (button.textContent = before), 1500);
    };
    find("copy").addEventListener("click", () => {
      history.replaceState(null, "", state.link());
      const done = navigator.clipboard?.writeText(state.link()) ?? Promise.reject(new Error("no clipboard"));
      done.then(() => say("copy", "Copied"), () => say("copy", "In address bar"));
    });
    find("toml").addEventListener("click", () => save("drop.toml", new Blob([toToml(state.scenario)], { type: "application/toml" })));
    find("csv").addEventListener("click", async () => {
      const text = state.drop && (await this.pool.ask("csv", { scenario: state.drop.scenario }));
      if (text) save("drop.csv", new Blob([text], { type: "text/csv" }));
    });
    find("png").addEventListener("click", () => this.savePicture(performance.now()));
  }

  // Waits briefly for the map.
  private savePicture(asked: number): void {
    const { map } = this.map;
    if (map.elapsed === null && performance.now() - asked < 3000) setTimeout(() => this.savePicture(asked), 50);
    else if (this.state.drop) picture(this.state, this.timeline.timeline, map, this.map.marked()).toBlob((blob) => blob && save("drop.png", blob), "image/png");
  }
}

async function begin(): Promise<void> {
  const response = fetch(new URL("core.wasm", import.meta.url));
  const module = await WebAssembly.compileStreaming(response).catch(async () => WebAssembly.compile(await (await fetch(new URL("core.wasm", import.meta.url))).arrayBuffer()));
  new Page(module);
}

begin().catch((error: unknown) => {
  find("verdict").textContent = `The page could not start: ${String(error)}`;
  throw error;
});
