// Light or dark theme: the system's until the user chooses one, which is kept after a reload. Print is light.
import { find, Sheet } from "../support/dom";
import type { State } from "../app/state";
import { themeOf } from "./theme";

const key = "hardlimit-theme";

export class ThemeSwitch {
  private readonly system = matchMedia("(prefers-color-scheme: dark)");
  private chosen: string | null = null;

  // `draw` draws everything at once: no frame follows before the page is printed.
  constructor(
    private readonly state: Pick<State, "theme" | "redraw">,
    draw: () => void,
  ) {
    // Storage may be unavailable.
    try {
      this.chosen = localStorage.getItem(key);
    } catch {}
    find("theme").addEventListener("click", () => this.choose(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
    this.system.addEventListener("change", () => this.apply());
    const printed = (on: boolean): void => {
      Sheet.printing = on;
      this.apply();
      if (on) draw();
    };
    const print = matchMedia("print");
    print.addEventListener("change", () => printed(print.matches));
    addEventListener("beforeprint", () => printed(true));
    addEventListener("afterprint", () => printed(false));
    this.apply();
  }

  private choose(theme: string): void {
    this.chosen = theme;
    try {
      localStorage.setItem(key, theme);
    } catch {}
    this.apply();
  }

  private apply(): void {
    const dark = !Sheet.printing && (this.chosen ?? (this.system.matches ? "dark" : "light")) === "dark";
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    find("theme").setAttribute("aria-pressed", String(dark));
    this.state.theme = themeOf(document.documentElement);
    this.state.redraw();
  }
}
