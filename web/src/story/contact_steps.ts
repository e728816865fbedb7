// The third chapter: one ball and its contact, then the contacts of all balls; sliders for ε and the gap.
import { find, setAttribute, setHidden, setText, type Sheet } from "../support/dom";
import { digits, withUnit } from "../support/format";
import { touchable } from "../support/touch";
import { clampTo, firstGap, ranges, type Range, type Scenario } from "../scenario/scenario";
import { fromSlider, steps, toSlider } from "../scenario/slider";
import type { Drawing } from "../state/signals";
import type { State } from "../state/state";
import { drawLone, drawOverlap } from "./contact_drawing";

interface Slider {
  id: string;
  range: Range;
  value(s: Scenario): number;
  set(s: Scenario, x: number): void;
  text(x: number): string;
}

const sliders: Slider[] = [
  {
    id: "lone-e",
    range: ranges.restitution,
    value: (s) => s.restitution,
    set: (s, x) => (s.restitution = x),
    text: (x) => digits(x),
  },
  {
    id: "overlap-gap",
    range: ranges.gap,
    value: (s) => s.gaps[firstGap(s)],
    set: (s, x) => (s.gaps = s.gaps.map((gap, i) => (i < firstGap(s) ? gap : clampTo(ranges.gap, x)))),
    text: (x) => (x === 0 ? "touching" : withUnit(x, "m")),
  },
];

export class ContactSteps {
  readonly drawings: Drawing[];

  constructor(
    private readonly state: State,
    lone: Sheet,
    overlap: Sheet,
    textSize: () => number,
  ) {
    const size = (sheet: Sheet): number => Math.min(textSize(), sheet.width / 24);
    const shown = (sheet: Sheet): boolean => sheet.width >= 40 && sheet.shown();
    for (const slider of sliders) this.listen(slider);
    this.drawings = [
      state.drawing(() => {
        const drop = state.drop!;
        setHidden(find("lone-box"), drop.lone === null);
        if (shown(lone)) drawLone(lone.g, lone.width, lone.height, drop.lone, state.theme, size(lone));
      }),
      state.drawing(() => {
        if (shown(overlap))
          drawOverlap(overlap.g, overlap.width, overlap.height, state.drop!, state.theme, size(overlap));
      }),
      state.drawing(() => {
        void state.drop;
        for (const slider of sliders) this.refresh(slider);
      }),
    ];
  }

  private listen({ id, range, set }: Slider): void {
    const input = find<HTMLInputElement>(id);
    input.max = String(steps(range));
    touchable(input);
    input.addEventListener("input", () => {
      set(this.state.scenario, fromSlider(range, Number(input.value)));
      this.state.edited();
    });
  }

  private refresh({ id, range, value, text }: Slider): void {
    const input = find<HTMLInputElement>(id);
    const x = value(this.state.scenario);
    input.value = String(toSlider(range, x));
    setAttribute(input, "aria-valuetext", text(x));
    setText(find(`${id}-value`), text(x));
  }
}
