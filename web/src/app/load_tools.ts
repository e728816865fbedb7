// tools.js, loaded at the first use.
type Tools = typeof import("./tools");
let loaded: Promise<Tools> | null = null;

export function tools(): Promise<Tools> {
  loaded ??= import(new URL("tools.js", import.meta.url).href) as Promise<Tools>;
  loaded.catch(() => (loaded = null)); // the next use tries again
  return loaded;
}
