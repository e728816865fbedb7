// The menu: link, picture, table, TOML files, undo.
import type { Pool } from "../core/pool";
import type { MapPanel } from "../map/map_panel";
import { toToml, type Scenario } from "../scenario/scenario";
import { fromToml } from "../scenario/toml";
import { find, refocus } from "../support/dom";
import { picture } from "./picture";
import type { Timeline } from "../views/timeline";
import type { State } from "../state/state";

export interface MenuActions {
  undo(): void;
  put(scenario: Scenario): void; // a setting from a file
  note(notes: string[]): void;
}

export function listenMenu(state: State, pool: Pool, map: MapPanel, timeline: Timeline, act: MenuActions): void {
  const copy = find("copy");
  const label = copy.textContent;
  // The button shows for a moment what was done.
  const show = (text: string): void => {
    copy.textContent = text;
    setTimeout(() => (copy.textContent = label), 1500);
  };
  copy.addEventListener("click", () => {
    history.replaceState(null, "", state.link());
    const done = navigator.clipboard?.writeText(state.link()) ?? Promise.reject(new Error("no clipboard"));
    done.then(
      () => show("Copied"),
      () => show("In address bar"),
    );
  });
  const menu = find<HTMLDetailsElement>("menu");
  addEventListener("pointerdown", (e) => {
    if (!menu.contains(e.target as Node)) menu.open = false;
  });
  addEventListener("keydown", (e) => {
    if (e.key !== "Escape" || !menu.open) return;
    menu.open = false;
    refocus();
  });
  find("undo").addEventListener("click", () => act.undo());
  addEventListener("keydown", (e) => {
    if (
      e.key !== "z" ||
      !(e.ctrlKey || e.metaKey) ||
      e.shiftKey ||
      (e.target as HTMLElement).closest("input[type=text]")
    )
      return;
    e.preventDefault();
    act.undo();
  });
  find("toml").addEventListener("click", () =>
    save("drop.toml", new Blob([toToml(state.scenario)], { type: "application/toml" })),
  );
  const file = find<HTMLInputElement>("open-file");
  find("open").addEventListener("click", () => file.click());
  file.addEventListener("change", () => {
    if (file.files?.[0]) void open(file.files[0], act);
    file.value = "";
  });
  find("csv").addEventListener("click", () => void saveTrajectories(state, pool));
  find("png").addEventListener("click", () => savePicture(state, map, timeline, performance.now()));
}

// A column in a TOML file, as `hardlimit drop` reads it.
async function open(file: File, act: MenuActions): Promise<void> {
  const notes: string[] = [];
  try {
    act.put(fromToml(await file.text(), notes));
  } catch (error) {
    notes.push((error as Error).message);
  }
  act.note(notes.map((text) => `${file.name}: ${text}`));
}

async function saveTrajectories({ drop }: State, pool: Pool): Promise<void> {
  const text = drop && (await pool.ask("csv", { scenario: drop.scenario }));
  if (text) save("drop.csv", new Blob([text], { type: "text/csv" }));
}

// Waits up to three seconds for the map.
function savePicture(state: State, panel: MapPanel, timeline: Timeline, since: number): void {
  const { map } = panel;
  if (map.elapsed === null && performance.now() - since < 3000)
    setTimeout(() => savePicture(state, panel, timeline, since), 50);
  else if (state.drop)
    picture(state, timeline, map, panel.marked()).toBlob((blob) => blob && save("drop.png", blob), "image/png");
}

function save(name: string, content: Blob): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
