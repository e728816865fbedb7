// What the map says below it: the value under the pointer, or that of the present setting.
import type { Pool } from "../core/pool";
import { axisValue, placed } from "../scenario/axes";
import { answers, type Comparison } from "../core/core";
import { copyOf } from "../scenario/scenario";
import { inPercent } from "../scenario/tolerance";
import { changes, find } from "../support/dom";
import { digits } from "../support/format";
import type { State } from "../state/state";
import { subscripted } from "../views/numbers";
import type { ContactMap } from "./map";
import { verdictNames } from "./map_drawing";
import type { Point } from "./map_input";
import type { MapTask } from "../core/map_points";

export class MapReading {
  private at: Point | null = null; // parameters that a click would choose
  private read = { place: "", text: "" }; // the answer there
  private asking = false;

  constructor(
    private readonly state: State,
    private readonly pool: Pool,
    private readonly map: ContactMap,
    private readonly marked: () => Point,
  ) {}

  // The value that was read is not valid for another map.
  forget(): void {
    this.read.place = "";
  }

  hover(point: Point | null): void {
    this.at = point;
    this.write();
  }

  write(): void {
    const { view, drop, scenario } = this.state;
    const { axis, across, show } = view.map;
    const [x, y] = this.at ?? this.marked();
    const where = `${axisValue(scenario, across, x)}, ${axisValue(scenario, axis, y)}`;
    let what = "…";
    if (this.at) {
      this.ask(this.at);
      if (this.read.place === `${x} ${y}`) what = this.read.text;
    } else if (drop) {
      const { nContacts, effective, effectiveSeparation } = drop.newton.run;
      const ratio = (show === "separation" ? effectiveSeparation : effective) / drop.scenario.restitution;
      what = show === "verdict" ? judged(drop.comparison) : counted(nContacts, ratio);
      const touching = (axis === "gap" && y === 0) || (across === "gap" && x === 0);
      if (!this.map.shows(x, y)) what += touching ? " (touching: not on the map)" : " (outside the map)";
    }
    const text = `${where}: ${what}`;
    const out = find("map-reading");
    if (changes(out, text)) out.replaceChildren(...subscripted(text));
  }

  // The result at a point, computed with the parameters that a click would set.
  private ask([x, y]: Point): void {
    const { scenario, view } = this.state;
    const place = `${x} ${y}`;
    if (this.asking || place === this.read.place) return;
    this.asking = true;
    const { show, axis, across } = view.map;
    const tolerance = show === "verdict" ? view.tolerance : null;
    const ask: MapTask = { scenario: copyOf(scenario), axes: [across, axis], tolerance, points: Float64Array.of(x, y) };
    const falls = placed(scenario, [
      [across, x],
      [axis, y],
    ]);
    this.pool.ask("points", ask).then(
      ([count, effective, separation, answer, error]) => {
        this.asking = false;
        const result =
          show === "verdict"
            ? judged({ answer: answers[answer], error, tolerance: view.tolerance })
            : counted(count, show === "separation" ? separation : effective);
        this.read = { place, text: !falls ? "cannot fall" : Number.isNaN(count) ? "no answer" : result };
        this.write();
      },
      () => (this.asking = false),
    );
  }
}

function judged({ answer, error, tolerance }: Pick<Comparison, "answer" | "error" | "tolerance">): string {
  const by = Number.isNaN(error) ? "" : `, error ${digits(100 * error, 2)} %`;
  return `${verdictNames[answers.indexOf(answer)]}${answer === "undecided" ? "" : ` to ${inPercent(tolerance)}${by}`}`;
}

const counted = (contacts: number, ratio: number): string =>
  `${contacts === 1 ? "1 contact" : `${contacts} contacts`}${Number.isNaN(ratio) ? "" : `, ε_eff/ε = ${digits(ratio)}`}`;
