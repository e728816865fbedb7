// Setting of a link: its example, that of its chapter or the default one, with the changes in the link.
import { presets, type Preset } from "./presets";
import { copyOf, fromQuery, type Scenario } from "./scenario";
import { ballsOfChapter, baseOf, bringsBalls, stepOf } from "./story_view";
import { firstView, viewFromQuery } from "./view";

export function settingOf(query: URLSearchParams, notes: string[]): { preset: Preset; scenario: Scenario } {
  const base = presets.find((p) => p.id === baseOf(query))!;
  const example = query.get("example");
  const named = presets.find((p) => p.id === example);
  if (example !== null && !named) notes.push(`example = “${example.slice(0, 20)}” is unknown: ${base.name} is shown`);
  const preset = named ?? base;
  const balls = ballsOfChapter({ step: stepOf(query), own: bringsBalls(query) });
  const scenario = copyOf(balls ?? preset.scenario);
  fromQuery(scenario, query, notes);
  return { preset, scenario };
}

// The first request to the core when the page opens.
export function questionOf(query: URLSearchParams): { scenario: Scenario; tolerance: number } {
  const view = firstView();
  const { scenario } = settingOf(query, []);
  viewFromQuery(view, query, [], scenario);
  return { scenario, tolerance: view.tolerance };
}
