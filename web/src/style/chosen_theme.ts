// Light or dark: the system's until the user chooses one, and with forced colours always.
export const themeKey = "hardlimit-theme";
export const systemTheme = matchMedia("(prefers-color-scheme: dark)");

// null: none is chosen, or storage is unavailable.
export function chosenTheme(): string | null {
  try {
    return localStorage.getItem(themeKey);
  } catch {
    return null;
  }
}

export const themeNow = (chosen: string | null): string => {
  const system = systemTheme.matches ? "dark" : "light";
  return matchMedia("(forced-colors: active)").matches ? system : (chosen ?? system);
};
