// Layout: the whole page, the story, or a single panel for a talk or an embedding page.
import { find, refocus, Sheet } from "../support/dom";
import type { PanelName } from "../scenario/story_view";
import { lettering } from "../support/plot";
import type { State } from "./state";

export type Mode = "story" | "panel";

export class Frames {
  mode: Mode | null = null;
  private text = 16;

  constructor() {
    addEventListener("resize", () => this.sizeText());
  }

  // `names`: panels shown alone; mode null: the whole page.
  show(mode: Mode | null, names: PanelName[]): void {
    if (mode !== this.mode && mode !== "story") scrollTo(0, 0); // they open at their top
    this.mode = mode;
    Sheet.inStory = mode === "story";
    const root = document.documentElement;
    if (mode) root.dataset.mode = mode;
    else delete root.dataset.mode;
    this.sizeText();
    document.querySelectorAll("main > .panel").forEach((panel) => panel.removeAttribute("data-shown"));
    names.forEach((name, i) => document.querySelector(`main > .${name}`)?.setAttribute("data-shown", String(i + 1)));
  }

  private sizeText(): void {
    this.text = parseFloat(getComputedStyle(document.documentElement).fontSize);
    lettering.story = this.mode !== null;
    lettering.least = this.mode ? 0.88 * this.textSize() : 13;
  }

  // Size of text on the page [px]; in the story and in single panels it grows with the window.
  textSize(): number {
    return this.text;
  }

  fullScreen(): void {
    const change = document.fullscreenElement
      ? document.exitFullscreen()
      : document.documentElement.requestFullscreen?.();
    change?.catch(() => undefined); // the browser may refuse; the page still fills its window
  }
}

// The page inside another page.
export const embedded = (): boolean => window.self !== window.top;

// A single panel: with a bar to choose another one, or embedded with a link to the whole page.
export class SinglePanel {
  constructor(
    private readonly frames: Frames,
    private readonly state: State,
    private readonly changed: () => void,
  ) {
    find<HTMLSelectElement>("panel-choice").addEventListener("change", (e) =>
      this.go((e.target as HTMLSelectElement).value as PanelName),
    );
    find("panel-full").addEventListener("click", () => frames.fullScreen());
    find("panel-leave").addEventListener("click", () => this.go(null));
    find("enlarge").addEventListener("click", () => this.go("film"));
    addEventListener("keydown", (e) => {
      if (e.key === "Escape" && state.story.panel && !embedded()) this.go(null);
    });
  }

  go(panel: PanelName | null): void {
    const { state } = this;
    state.enterHistory();
    state.story.panel = panel;
    this.changed();
    history.replaceState(null, "", state.link());
    refocus();
  }

  show(): void {
    const { panel, pin } = this.state.story;
    find("panel-bar").hidden = panel === null;
    find("panel-tools").hidden = embedded();
    find("panel-whole").hidden = !embedded();
    if (panel === null) return;
    this.frames.show("panel", [panel]);
    const choice = find<HTMLSelectElement>("panel-choice");
    choice.value = panel;
    for (const option of choice.options) if (option.value === "compare") option.disabled = pin === null;
    this.refreshLink();
  }

  // Keeps the link to the whole page in step with the setting.
  refreshLink(): void {
    if (!this.state.story.panel || !embedded()) return;
    const url = new URL(this.state.link());
    url.searchParams.delete("panel");
    find<HTMLAnchorElement>("panel-whole").href = url.href;
  }
}
