// Light or dark theme: the system's until the user chooses one, which is kept after a reload.
import { find } from "../support/dom";
import type { State } from "../app/state";
import { themeOf } from "./theme";

const key = "hardlimit-theme";

export class ThemeSwitch {
  private readonly system = matchMedia("(prefers-color-scheme: dark)");
  private chosen: string | null = null;

  constructor(private readonly state: State) {
    // Storage may be unavailable.
    try {
      this.chosen = localStorage.getItem(key);
    } catch {}
    find("theme").addEventListener("click", () => this.choose(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
    this.system.addEventListener("change", () => this.apply());
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
    const dark = (this.chosen ?? (this.system.matches ? "dark" : "light")) === "dark";
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    find("theme").setAttribute("aria-pressed", String(dark));
    this.state.theme = themeOf(document.documentElement);
    this.state.redraw();
  }
}
