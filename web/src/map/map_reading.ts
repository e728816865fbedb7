// What the map says below it: the value under the pointer, or that of the present setting.
import type { Pool } from "../core/pool";
import { columnOf } from "../scenario/scenario";
import { changes, find } from "../support/dom";
import { digits, withUnit } from "../support/format";
import type { State } from "../state/state";
import { subscripted } from "../views/numbers";
import type { ContactMap } from "./map";
import type { Point } from "./map_input";

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
    const { view, drop } = this.state;
    const [e, y] = this.at ?? this.marked();
    const where =
      `ε = ${digits(e)}, ` +
      `${view.map.axis === "gap" ? `Δh = ${y > 0 ? withUnit(y, "m") : "0"}` : `R₁/R₂ = ${digits(y)}`}`;
    let what = "…";
    if (this.at) {
      this.ask(this.at);
      if (this.read.place === `${e} ${y}`) what = this.read.text;
    } else if (drop) {
      const { nContacts, effective, effectiveSeparation } = drop.newton.run;
      what = counted(
        nContacts,
        (view.map.show === "separation" ? effectiveSeparation : effective) / drop.scenario.restitution,
      );
      if (!this.map.shows(e, y)) what += y > 0 ? " (outside the map)" : " (touching: below the map)";
    }
    const text = `${where}: ${what}`;
    const out = find("map-reading");
    if (changes(out, text)) out.replaceChildren(...subscripted(text));
  }

  // The result at a point, computed with the parameters that a click would set.
  private ask([e, y]: Point): void {
    const { scenario, view } = this.state;
    const place = `${e} ${y}`;
    if (this.asking || place === this.read.place) return;
    this.asking = true;
    const { show, axis } = view.map;
    const ask = { column: columnOf(scenario), axis: axis === "gap" ? 0 : 1, points: Float64Array.of(e, y) };
    this.pool.ask("points", ask).then(
      ([count, effective, separation]) => {
        this.asking = false;
        this.read = {
          place,
          text: Number.isNaN(count) ? "cannot fall" : counted(count, show === "separation" ? separation : effective),
        };
        this.write();
      },
      () => (this.asking = false),
    );
  }
}

const counted = (contacts: number, ratio: number): string =>
  `${contacts === 1 ? "1 contact" : `${contacts} contacts`}${Number.isNaN(ratio) ? "" : `, ε_eff/ε = ${digits(ratio)}`}`;
