// The choice of the theme, which is stored. Print is light.
import { find, Sheet } from "./dom";
import { chosenTheme, systemTheme, themeKey, themeNow } from "../style/chosen_theme";
import { themeOf, type Theme } from "../style/theme";

export class ThemeSwitch {
  private chosen = chosenTheme();

  // `draw` draws everything at once, because no frame follows before printing.
  constructor(
    private readonly state: { theme: Theme; redraw(): void },
    draw: () => void,
  ) {
    find("theme").addEventListener("click", () => this.choose(state.theme.dark ? "light" : "dark"));
    systemTheme.addEventListener("change", () => this.apply());
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
      localStorage.setItem(themeKey, theme);
    } catch {}
    this.apply();
  }

  private apply(): void {
    const dark = !Sheet.printing && themeNow(this.chosen) === "dark";
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    find("theme").setAttribute("aria-pressed", String(dark));
    this.state.theme = themeOf(document.documentElement);
    this.state.redraw();
  }
}
