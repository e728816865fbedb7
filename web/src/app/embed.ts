// The code that puts a panel of this setting into another page.
import type { PanelName } from "../scenario/story_view";
import { escaped } from "../support/svg_pen";

// Names of the panels, as in the list above a single panel.
export const titles: Record<PanelName, string> = {
  film: "Animation of the bounce",
  numbers: "Results of both models",
  energy: "Where the energy went",
  forces: "Forces during the bounce",
  timeline: "Contacts over the coefficient of restitution",
  rebound: "Rebound height",
  map: "Map of contacts",
  compare: "Two settings side by side",
};

export function embedCode(link: string, panel: PanelName): string {
  const url = new URL(link);
  for (const key of ["page", "story", "guess"]) url.searchParams.delete(key);
  url.searchParams.set("panel", panel);
  const address = escaped(url.href.replaceAll("%2C", ","));
  return `<iframe src="${address}" title="${escaped(titles[panel])}" width="100%" height="520" loading="lazy"></iframe>`;
}
