// The page: puts its parts together, and says what follows from a change of the scenario.
import { Core } from "./core";
import { Controls } from "./controls";
import { Sheet, find } from "./dom";
import { solve } from "./drop";
import { csv, save } from "./exporting";
import { Film } from "./film";
import { forcesSummary } from "./forces";
import { digits } from "./format";
import { MapPanel } from "./map_panel";
import { exactNumbers, fillEnergy, fillTable, verdict } from "./numbers";
import { ForcesPanel, TimelinePanel } from "./panels";
import { picture } from "./picture";
import { presets, type Preset } from "./presets";
import { copyOf, fromQuery, toQuery, toToml, type Scenario } from "./scenario";
import { State } from "./state";
import { themeOf } from "./theme";
import { viewFromQuery } from "./view";

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
  private readonly forcesSheet: Sheet;
  private preset = "";
  private about = "";
  private lastFrame = 0;

  constructor(
    private readonly core: Core,
    module: WebAssembly.Module,
  ) {
    const base = this.readLink();
    this.state = base.state;
    const { state } = this;
    this.controls = new Controls(find("controls"), state.scenario, () => this.edited());
    const resized = (): void => state.redraw();
    this.film = new Film(state, core, new Sheet("stage", resized));
    this.forcesSheet = new Sheet("forces", resized);
    this.forces = new ForcesPanel(state, this.forcesSheet, this.film);
    this.timeline = new TimelinePanel(state, new Sheet("timeline", resized));
    this.map = new MapPanel(state, new Sheet("map", resized), module);
    this.fillPresets([base.preset, ...presets].find((p) => queryOf(p.scenario) === queryOf(state.scenario))?.id ?? "");
    find("notes").querySelector("button")!.addEventListener("click", () => this.note([]));
    this.listenTheme();
    this.listenFiles();
    this.setTheme(null);
    this.frame(performance.now());
    document.documentElement.dataset.ready = String(Math.round(performance.now()));
  }

  // The preset named in the link, or the first, with what the link changes.
  private readLink(): { state: State; preset: Preset } {
    const notes: string[] = [];
    const query = new URLSearchParams(location.search);
    const named = presets.find((p) => p.id === query.get("example"));
    if (query.get("example") !== null && !named) notes.push(`example = “${query.get("example")?.slice(0, 20)}” is unknown: the paper’s is shown`);
    const preset = named ?? presets[0];
    const state = new State(copyOf(preset.scenario), () => this.edited());
    Object.assign(state.view.map, preset.map);
    fromQuery(state.scenario, query, notes);
    viewFromQuery(state.view, query, notes);
    this.note(notes);
    state.playing = state.view.time === null && moves();
    return { state, preset };
  }

  // ---- scenario ---------------------------------------------------------------------------------------

  private fillPresets(chosen: string): void {
    const select = find<HTMLSelectElement>("preset");
    const own = new Option("Your own", "");
    own.hidden = true;
    select.append(own, ...presets.map((p) => new Option(p.name, p.id)));
    select.addEventListener("change", () => {
      const preset = presets.find((p) => p.id === select.value);
      if (preset) this.load(preset);
    });
    this.choosePreset(chosen);
  }

  private choosePreset(id: string): void {
    this.preset = id;
    find<HTMLSelectElement>("preset").value = id;
    this.about = presets.find((p) => p.id === id)?.about ?? "";
  }

  private load(preset: Preset): void {
    const { state } = this;
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

  // ---- what follows from it ---------------------------------------------------------------------------

  private resolve(): void {
    const { state } = this;
    const share = state.drop ? state.screen / state.clock().length : 0;
    const result = solve(this.core, state.scenario);
    if ("reason" in result) {
      state.drop = null;
      find("verdict").textContent = result.reason;
      return;
    }
    state.drop = result;
    if (state.view.time !== null) {
      const kept = Math.min(Math.max(state.view.time, result.start), result.stop);
      if (Math.abs(kept - state.view.time) > 1e-6) this.note([`t = ${state.view.time} s is outside the film: ${digits(kept)} s used`]);
      this.film.seek(kept);
      state.view.time = null;
    } else state.screen = Math.min(share, 1) * state.clock().length;
    this.controls.set(state.scenario, this.about);
    this.tellNumbers();
    this.forcesSheet.canvas.setAttribute("aria-description", forcesSummary(result));
    this.map.refreshChoices();
    this.timeline.refresh();
    this.map.refresh();
    state.redraw();
    state.writeLink();
  }

  private tellNumbers(): void {
    const d = this.state.drop!;
    fillTable(find("numbers").querySelector("tbody")!, d);
    fillEnergy(find("energy"), d);
    const [newton, icm] = verdict(d, this.core);
    const [a, b] = [document.createElement("span"), document.createElement("span")];
    a.className = "newton";
    b.className = "icm";
    a.textContent = newton + " ";
    b.textContent = icm;
    find("verdict").replaceChildren(a, b);
    document.documentElement.dataset.numbers = JSON.stringify(exactNumbers(d));
  }

  // ---- drawing ----------------------------------------------------------------------------------------

  private readonly frame = (now: number): void => {
    requestAnimationFrame(this.frame);
    const { state } = this;
    const passed = Math.min((now - this.lastFrame) / 1000, 0.1);
    this.lastFrame = now;
    if (state.dirty.solve) {
      state.dirty.solve = false;
      const begin = performance.now();
      this.resolve();
      this.drawPlots();
      performance.measure("solve", { start: begin });
    }
    if (state.drop && state.playing) this.film.advance(passed);
    if (this.timeline.work(this.core, 9)) state.dirty.plots = true;
    this.drawPlots();
    if (state.dirty.stage && state.drop) {
      state.dirty.stage = false;
      this.film.draw();
      this.markTime();
    }
    this.map.drawIfDue(now);
  };

  private drawPlots(): void {
    const { dirty, drop } = this.state;
    if (!dirty.plots || !drop) return;
    dirty.plots = false;
    this.forces.draw();
    this.timeline.draw();
    this.markTime();
  }

  private markTime(): void {
    this.forces.mark();
    this.timeline.mark();
  }

  // ---- theme and files --------------------------------------------------------------------------------

  private listenTheme(): void {
    find("theme").addEventListener("click", () => this.setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.setTheme(null));
  }

  private setTheme(choice: "light" | "dark" | null): void {
    const dark = choice ? choice === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    find("theme").setAttribute("aria-pressed", String(dark));
    this.state.theme = themeOf(document.documentElement);
    this.state.redraw();
  }

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
    find("csv").addEventListener("click", () => {
      if (state.drop) save("drop.csv", new Blob([csv(this.core, state.drop)], { type: "text/csv" }));
    });
    find("png").addEventListener("click", () => this.savePicture(performance.now()));
  }

  // The map is worth a short wait.
  private savePicture(asked: number): void {
    const { map } = this.map;
    if (map.elapsed === null && performance.now() - asked < 3000) setTimeout(() => this.savePicture(asked), 50);
    else if (this.state.drop) picture(this.state, this.core, this.timeline.timeline, map, this.map.marked()).toBlob((blob) => blob && save("drop.png", blob), "image/png");
  }
}

async function begin(): Promise<void> {
  const response = fetch(new URL("core.wasm", import.meta.url));
  const module = await WebAssembly.compileStreaming(response).catch(async () => WebAssembly.compile(await (await fetch(new URL("core.wasm", import.meta.url))).arrayBuffer()));
  new Page(new Core(module), module);
}

begin().catch((error: unknown) => {
  find("verdict").textContent = `The page could not start: ${String(error)}`;
  throw error;
});
