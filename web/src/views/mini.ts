// A strip with the result and a small film, visible on a phone while the film is scrolled away.
import { find, Sheet } from "../support/dom";
import { drawTrueScale } from "./true_scale";
import { observed, type Drawing } from "../state/signals";
import type { State } from "../state/state";

export class Mini {
  private readonly sheet: Sheet;
  private away = false; // the film is scrolled out of view
  readonly picture: Drawing;

  constructor(private readonly state: State) {
    this.sheet = new Sheet("mini-stage", () => state.redraw());
    observed(this, ["away"]);
    this.picture = state.drawing(() => this.draw());
    new IntersectionObserver(([entry]) => {
      this.away = !entry.isIntersecting && entry.boundingClientRect.top < 0;
      find("mini").classList.toggle("away", this.away);
    }).observe(find("film"));
    find("mini").addEventListener("click", () => find("film").scrollIntoView({ block: "start" }));
  }

  private draw(): void {
    const { state, sheet } = this;
    if (!this.away || !state.drop || sheet.width < 20) return;
    sheet.g.clearRect(0, 0, sheet.width, sheet.height);
    const time = state.time();
    const { motion } = state.drop;
    const moment = { time, rate: 1, newton: motion.newton.at(time), icm: motion.icm.at(time) };
    drawTrueScale(sheet.g, { x: 0, y: 0, w: sheet.width, h: sheet.height }, state.drop, moment, state.theme, "");
  }
}
