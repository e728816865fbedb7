// On paper each chapter has its own balls: the drop, the pictures and the facts of those that the screen does not show.
import { dropOf, type Drop } from "../core/drop";
import type { Pool } from "../core/pool";
import { ContactMap } from "../map/map";
import { Agreement } from "../map/trust";
import type { StoryFacts } from "../report/facts";
import { reportOf } from "../report/report";
import { copyOf, type Scenario } from "../scenario/scenario";
import { widened, type Box, type MapView } from "../scenario/view";
import { Sheet } from "../support/dom";
import type { Theme } from "../style/theme";
import { Curve, scaleOf, spanOf } from "../views/rebound";
import { extremesOf } from "../views/rebound_panel";
import { Timeline } from "../views/timeline";

type Draw = (g: CanvasRenderingContext2D, width: number, height: number) => void;
type Facts = Pick<StoryFacts, "drop" | "report" | "gaps" | "trusted">;

const map: MapView = { axis: "gap", across: "e", show: "effective", zoom: null };

export class Paper {
  drop: Drop | null = null;
  lent = false; // the balls are those of chapters that have their own
  private key = "";
  private tolerance = NaN;
  private readonly timeline: Timeline;
  private readonly map: ContactMap;
  private readonly agreement: Agreement;
  readonly curve: Curve;
  private box: Box | null = null; // of the map
  private readonly sheets: HTMLCanvasElement[] = [];

  constructor(private readonly pool: Pool) {
    const wanted = (): boolean => Sheet.idle && this.drop !== null;
    this.timeline = new Timeline(pool, wanted);
    this.map = new ContactMap(pool, wanted);
    this.map.setShow(map.show);
    this.agreement = new Agreement(pool);
    this.curve = new Curve(pool, wanted);
  }

  // Solves the balls that the screen does not show.
  prepare(balls: Scenario, lent: boolean, tolerance: number): void {
    const key = JSON.stringify([balls, tolerance]);
    if (key === this.key) return;
    Object.assign(this, { key, lent, tolerance, drop: null, box: null });
    void this.pool.ask("solve", { scenario: copyOf(balls), tolerance }).then((solved) => {
      if (key !== this.key || "reason" in solved) return;
      this.drop = dropOf(solved);
      if (lent) this.startLent(this.drop);
      else this.curve.start(balls, "gap", spanOf(balls, "gap", ...scaleOf(this.drop)));
      this.pool.wake();
    });
  }

  private startLent(drop: Drop): void {
    this.timeline.start(drop.scenario);
    this.box = widened(drop.scenario, ...scaleOf(drop));
    this.map.start(drop.scenario, [map.across, map.axis], null, this.box, false);
  }

  // The line of the map after its points.
  frame(): void {
    if (this.box && this.map.elapsed !== null) this.agreement.refresh(this.drop!.scenario, this.box, this.tolerance);
  }

  facts(): Facts | null {
    const { drop, tolerance } = this;
    if (!drop) return null;
    const line = this.box && this.agreement.present;
    return {
      drop,
      report: reportOf(drop, tolerance),
      gaps: this.lent ? null : extremesOf(this.curve),
      trusted: line ? { gap: line.gap, widest: this.box!.y[1] } : null,
    };
  }

  // Pictures of the lent balls, in place of those of the screen.
  drawLent(theme: Theme): void {
    const { drop, box } = this;
    if (!drop || !box) return;
    const { restitution, gaps } = drop.scenario;
    this.lay("timeline", (g, w, h) => this.timeline.draw(g, w, h, drop, theme));
    this.lay("map", (g, w, h) =>
      this.map.draw(g, w, h, drop.scenario, map, [restitution, gaps[0]], theme, this.agreement, box),
    );
  }

  // A picture for paper over that of the screen.
  lay(id: string, draw: Draw): void {
    const { parentElement, width, height } = document.getElementById(id) as HTMLCanvasElement;
    const box = parentElement!;
    const sheet = Object.assign(document.createElement("canvas"), { className: "paper", width, height });
    const scale = width / Math.max(box.clientWidth, 1);
    const g = sheet.getContext("2d")!;
    g.scale(scale, scale);
    draw(g, width / scale, height / scale);
    box.append(sheet);
    this.sheets.push(sheet);
  }

  // The picture of the screen, for paper.
  keep(id: string): void {
    const canvas = document.getElementById(id) as HTMLCanvasElement;
    this.lay(id, (g, w, h) => g.drawImage(canvas, 0, 0, w, h));
  }

  clear(): void {
    for (const sheet of this.sheets.splice(0)) sheet.remove();
  }
}
