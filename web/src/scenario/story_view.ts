// State of the story and of single panels in the link: chapter, guess, panel, axis of the curves, setting A.
import { presets } from "./presets";
import { copyOf, fromQuery, toQuery, type Scenario } from "./scenario";

export const steps = ["predict", "watch", "slow", "count", "gap", "map"] as const; // chapters of the story
export type Step = (typeof steps)[number];
export const firstStep = steps[0];

// Examples that show the point of a chapter better than the balls that the story opens with.
const ballsOf: Partial<Record<Step, string>> = { count: "fig2", map: "fig2" };

export const panels = ["film", "numbers", "energy", "forces", "timeline", "rebound", "map", "compare"] as const;
export type PanelName = (typeof panels)[number];

export const curveAxes = ["gap", "e", "ratio"] as const; // axis of the rebound heights
export type CurveAxis = (typeof curveAxes)[number];

export interface StoryView {
  step: Step | null; // chapter that is read; null: the laboratory or a single panel
  guess: number | null; // height the viewer expects [m]
  panel: PanelName | null; // shown alone
  curve: CurveAxis;
  pin: Scenario | null; // setting A
  own: boolean; // the reader has chosen the balls: no chapter changes them
}

export const firstStoryView = (): StoryView => ({
  step: firstStep,
  guess: null,
  panel: null,
  curve: "gap",
  pin: null,
  own: false,
});

export const highestPrediction = 1000; // m

const queryOf = (s: Scenario): URLSearchParams => {
  const q = new URLSearchParams();
  toQuery(s, q);
  return q;
};
const opening = presets[0].scenario;
export const sameScenario = (a: Scenario, b: Scenario): boolean => queryOf(a).toString() === queryOf(b).toString();

// The balls of the present chapter; null: those that the story has.
export const ballsOfChapter = ({ step, own }: Pick<StoryView, "step" | "own">): Scenario | null =>
  (step && !own && presets.find((p) => p.id === ballsOf[step])?.scenario) || null;

// The page opens with the first example; the link stores differences from the paper's Fig. 2.
export function scenarioToQuery(s: Scenario, q: URLSearchParams): void {
  if (sameScenario(s, opening)) return;
  const own = queryOf(s);
  if (own.size === 0) q.set("example", "fig2");
  for (const [key, value] of own) q.set(key, value);
}

const scenarioKeys = (): Set<string> =>
  new Set(presets.flatMap((p) => [...queryOf(p.scenario).keys()]).concat("u", "setup", "law"));
const describes = (q: URLSearchParams): boolean => [...q.keys()].some((key) => scenarioKeys().has(key));

// Whether a link has balls other than those that the story opens with.
export const bringsBalls = (q: URLSearchParams): boolean =>
  (q.has("example") && q.get("example") !== presets[0].id) || describes(q);

// The example that a link without a name starts from.
export const baseOf = (q: URLSearchParams): string => (describes(q) ? "fig2" : presets[0].id);

const prefix = "a."; // of the parameters of setting A

export function storyToQuery(v: StoryView, q: URLSearchParams): void {
  if (v.step && v.step !== firstStep) q.set("story", v.step);
  if (!v.step && !v.panel && !v.pin) q.set("page", "lab");
  if (v.step === firstStep && v.pin) q.set("page", "story"); // a link with a setting A opens the laboratory
  if (v.guess !== null) q.set("guess", String(v.guess));
  if (v.panel) q.set("panel", v.panel);
  if (v.curve !== "gap") q.set("curve", v.curve);
  if (!v.pin) return;
  const own = new URLSearchParams();
  scenarioToQuery(v.pin, own);
  if (own.size === 0) own.set("example", presets[0].id);
  for (const [key, value] of own) q.set(prefix + key, value);
}

// The chapter that a link names.
export function stepOf(q: URLSearchParams): Step | null {
  const step = q.get("story");
  if (step === "drop") return "predict"; // in older links
  return steps.find((name) => name === step) ?? null;
}

export function storyFromQuery(v: StoryView, q: URLSearchParams, notes: string[]): void {
  const choice = <T extends string>(key: string, options: readonly T[]): T | null => {
    const text = q.get(key);
    if (text === null || (options as readonly string[]).includes(text)) return text as T | null;
    notes.push(`${key} = “${text.slice(0, 20)}” is none of ${options.join(", ")}: left out`);
    return null;
  };
  const step = stepOf(q) ?? choice("story", steps);
  v.panel = step ? null : choice("panel", panels);
  const pinned = [...q.keys()].some((key) => key.startsWith(prefix));
  const laboratory = choice("page", ["lab", "story"]) === "lab" || (pinned && !q.has("page"));
  v.step = step ?? (v.panel || laboratory ? null : firstStep);
  v.own = bringsBalls(q);
  v.curve = choice("curve", curveAxes) ?? "gap";
  const guess = q.get("guess");
  if (guess !== null) {
    const x = guess.trim() === "" ? NaN : Number(guess);
    if (x >= 0 && x <= highestPrediction) v.guess = x;
    else notes.push(`guess = “${guess.slice(0, 20)}” is not a height from 0 to ${highestPrediction} m: left out`);
  }
  const own = new URLSearchParams(
    [...q].filter(([key]) => key.startsWith(prefix)).map(([key, value]) => [key.slice(prefix.length), value]),
  );
  if (own.size === 0) return;
  const named = presets.find((p) => p.id === own.get("example")) ?? presets.find((p) => p.id === baseOf(own))!;
  v.pin = copyOf(named.scenario);
  const pinNotes: string[] = [];
  fromQuery(v.pin, own, pinNotes);
  notes.push(...pinNotes.map((text) => `A: ${text}`));
}
