// The menus: this link, exports, TOML files, undo.
import type { Pool } from "../core/pool";
import type { Scenario } from "../scenario/scenario";
import { fromToml } from "../scenario/toml";
import { find } from "../support/dom";
import { listenExports, type Plots } from "./exports";
import { listenShare } from "./share";
import type { State } from "../state/state";

export interface MenuActions {
  undo(): void;
  put(scenario: Scenario): void; // a setting from a file
  note(notes: string[]): void;
}

export function listenMenu(state: State, pool: Pool, plots: Plots, act: MenuActions): void {
  listenExports(state, pool, plots);
  listenShare(state);
  const menus = [...document.querySelectorAll<HTMLDetailsElement>("details.menu")];
  for (const menu of menus)
    menu.addEventListener("toggle", () => {
      if (menu.open) for (const other of menus) if (other !== menu) other.open = false;
    });
  addEventListener("pointerdown", (e) => {
    for (const menu of menus) if (!menu.contains(e.target as Node)) menu.open = false;
  });
  addEventListener("keydown", (e) => {
    const open = menus.find((menu) => menu.open);
    if (e.key !== "Escape" || !open) return;
    open.open = false;
    open.querySelector("summary")!.focus();
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
  const file = find<HTMLInputElement>("open-file");
  find("open").addEventListener("click", () => file.click());
  file.addEventListener("change", () => {
    if (file.files?.[0]) void open(file.files[0], act);
    file.value = "";
  });
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
