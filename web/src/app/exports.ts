// The menu of exports: pictures, tables, this setting as a program.
import type { Pool } from "../core/pool";
import type { MapPanel } from "../map/map_panel";
import { toToml } from "../scenario/scenario";
import type { State } from "../state/state";
import { find } from "../support/dom";
import { copyText, save, saveText, tell } from "../support/output";
import { themeOf } from "../style/theme";
import type { ReboundPanel } from "../views/rebound_panel";
import type { Timeline } from "../views/timeline";
import { parameters, picture } from "./picture";
import { tools } from "./load_tools";

export interface Plots {
  map: MapPanel;
  timeline: Timeline;
  rebound: ReboundPanel;
}

type Draw = (g: CanvasRenderingContext2D, width: number, height: number) => void;

const patience = 20_000; // longest wait for a plot that is still being computed [ms]

export function listenExports(state: State, pool: Pool, plots: Plots): void {
  const { map, rebound } = plots;
  const { curve } = rebound;
  const on = (id: string, act: (button: HTMLElement) => unknown): void => {
    const button = find(id);
    button.addEventListener("click", () => void act(button));
  };
  const copied = (button: HTMLElement, text: Promise<string>): Promise<void> =>
    text.then(copyText).then((done) => tell(button, done ? "Copied" : "The browser refuses"));
  const curveDone = (): Promise<void> => until(() => curve.done);
  const mapDone = (): Promise<void> => until(() => map.map.elapsed !== null);

  on("toml", () => saveText("drop.toml", toToml(state.scenario)));
  on("csv", () => saveTrajectories(state, pool));
  on("png", async () => {
    await until(() => map.map.elapsed !== null, 3000);
    if (state.drop) picture(state, plots.timeline, map).toBlob((blob) => blob && save("drop.png", blob), "image/png");
  });
  on("copy-python", (button) =>
    copied(
      button,
      tools().then(({ toPython }) => toPython(state.scenario, state.view.tolerance)),
    ),
  );
  on("copy-command", (button) =>
    copied(
      button,
      tools().then(({ toCommand }) => toCommand(state.scenario)),
    ),
  );
  on("curve-csv", async () => {
    const { curveCsv } = await tools();
    await curveDone();
    saveText("curve.csv", curveCsv(state.scenario, curve.axis, curve.points, curve.touching));
  });
  on("curve-svg", async () => {
    await curveDone();
    await saveSvg("curve.svg", find("rebound-title").textContent, state, (g, w, h) =>
      rebound.paint(g, w, h, printed()),
    );
  });
  on("map-csv", async () => {
    const { mapCsv } = await tools();
    await mapDone();
    saveText("map.csv", mapCsv(...map.table()));
  });
  on("map-svg", async () => {
    await mapDone();
    await saveSvg("map.svg", find("map-title").textContent, state, (g, w, h) => map.paint(g, w, h, printed()));
  });
}

// Colours for paper.
const printed = (): ReturnType<typeof themeOf> => themeOf(document.documentElement, false);

async function until(done: () => boolean, most = patience): Promise<void> {
  const end = performance.now() + most;
  while (!done() && performance.now() < end) await new Promise((next) => setTimeout(next, 50));
}

async function saveTrajectories({ drop }: State, pool: Pool): Promise<void> {
  const text = drop && (await pool.ask("csv", { scenario: drop.scenario }));
  if (text) saveText("drop.csv", text);
}

async function saveSvg(name: string, title: string, { scenario }: State, draw: Draw): Promise<void> {
  const { SvgPen } = await tools();
  const [width, height] = [960, 680];
  const measured = document.createElement("canvas").getContext("2d")!;
  const pen = new SvgPen(width, height, (text, font) => {
    measured.font = font;
    return measured.measureText(text).width;
  });
  draw(pen as unknown as CanvasRenderingContext2D, width, height);
  saveText(name, pen.toString(title, parameters(scenario), printed().ground));
}
