// The panel of rebound heights: drawing, reading values, pointer, measured heights.
import { find, setText, type Sheet } from "../support/dom";
import { digits, metres, withUnit } from "../support/format";
import type { CurveAxis, StoryView } from "../scenario/story_view";
import { readMeasurements, type Measurements } from "./measurements";
import type { Pool } from "../core/pool";
import type { StoryFacts } from "../report/facts";
import { aloneRise } from "../scenario/measured";
import { Curve, scaleOf, spanOf, valueOn, type CurvePoint } from "./rebound";
import { nameOf, nearest, valueAt, type CurveLayout, type CurvePicture } from "./rebound_layout";
import { drawCurves } from "./rebound_plot";
import { clampTo, firstGap, lowestHeight, ranges, releaseHeight, type Scenario } from "../scenario/scenario";
import type { Theme } from "../style/theme";
import { observed, type Drawing } from "../state/signals";
import type { State } from "../state/state";
import { independent, newton } from "../scenario/tables";
import { dragged } from "../support/touch";

const largestFile = 1e6; // bytes

export class ReboundPanel {
  readonly curve: Curve;
  private readonly pinned: Curve;
  private layout: CurveLayout | null = null;
  private key = "";
  private pinnedKey = "";
  private hovered: number | null = null;
  private measured: Measurements | null = null;
  private drawn = 0;
  private readonly picture: Drawing;

  constructor(
    private readonly state: State,
    private readonly view: StoryView,
    private readonly sheet: Sheet,
    pool: Pool,
  ) {
    observed(this, ["hovered", "measured", "pinnedKey"]);
    this.picture = state.drawing(() => this.draw());
    this.curve = new Curve(pool, sheet.wanted);
    this.pinned = new Curve(pool, sheet.wanted);
    this.listen();
  }

  // Restarts if the curves belong to another scenario.
  refresh(): void {
    const { state, view } = this;
    if (!state.drop) return;
    this.refreshChoices();
    const { scenario } = state;
    const span = spanOf(scenario, view.curve, ...scaleOf(state.drop));
    if (this.key !== keyOf(scenario, view.curve, span)) {
      this.key = keyOf(scenario, view.curve, span);
      this.curve.start(scenario, view.curve, span);
      this.sheet.canvas.dataset.done = "false";
    }
    const same = view.pin !== null && view.pin.cradle === scenario.cradle;
    const pinnedKey = same ? keyOf(view.pin!, view.curve, span) : "";
    if (this.pinnedKey !== pinnedKey) {
      this.pinnedKey = pinnedKey;
      if (same) this.pinned.start(view.pin!, view.curve, span);
      else this.pinned.stop();
    }
  }

  private refreshChoices(): void {
    const { scenario } = this.state;
    const select = find<HTMLSelectElement>("rebound-axis");
    select.options[2].disabled = scenario.cradle;
    if (scenario.cradle && this.view.curve === "ratio") this.view.curve = "gap";
    if (select.value !== this.view.curve) select.value = this.view.curve;
    const what = scenario.cradle ? "Speed of the last ball" : "Rebound height";
    setText(find("rebound-title"), `${what} over ${{ gap: "the gap", e: "ε", ratio: "R₁/R₂" }[this.view.curve]}`);
  }

  // Draws if necessary; less often while the curves are computed.
  drawIfDue(now: number): void {
    if (!this.state.drop || this.sheet.width < 40 || !this.sheet.shown()) return;
    if (!this.curve.done && (!this.sheet.seen || now - this.drawn < 80)) return;
    if (this.picture.refresh()) this.drawn = now;
  }

  private draw(): void {
    const { sheet, state } = this;
    this.layout = this.paint(sheet.g, sheet.width, sheet.height, state.theme);
    this.write();
    sheet.canvas.dataset.points = String(this.curve.points.length);
    sheet.canvas.dataset.done = String(this.curve.done && (this.pinnedKey === "" || this.pinned.done));
  }

  // The picture in any size and theme.
  paint(g: CanvasRenderingContext2D, width: number, height: number, theme: Theme, curve = this.curve): CurveLayout {
    return drawCurves(g, width, height, this.contents(curve), theme);
  }

  private contents(curve = this.curve): CurvePicture {
    const { state, view } = this;
    const { scenario } = state;
    const pinned = this.pinnedKey !== "";
    const released = scenario.cradle || view.curve === "ratio" ? NaN : releaseHeight(scenario);
    return {
      axis: view.curve,
      span: curve.span,
      points: curve.points,
      touching: curve.touching,
      pinned: pinned ? this.pinned.points : [],
      pinnedTouching: pinned ? this.pinned.touching : null,
      pinnedAt: pinned ? valueOn(view.pin!, view.curve) : null,
      released,
      alone: Number.isFinite(released) ? aloneRise(scenario.balls[scenario.balls.length - 1], released) : null,
      measured: scenario.cradle ? null : this.measured,
      marked: this.marked(),
      hovered: this.hovered,
      cradle: scenario.cradle,
    };
  }

  // The value under the pointer, or that of the present setting.
  private write(): void {
    const picture = this.contents();
    const point = this.hovered === null ? picture.marked : nearest(picture, this.hovered);
    const text = point ? `${nameOf(picture.axis, point.x)}: ${this.describe(point)}` : "computing …";
    setText(find("rebound-reading"), text);
    const { canvas } = this.sheet;
    canvas.setAttribute("aria-valuenow", String(Number(picture.marked.x.toPrecision(4))));
    canvas.setAttribute(
      "aria-valuetext",
      `${nameOf(picture.axis, picture.marked.x)}: ${this.describe(picture.marked)}`,
    );
  }

  // The values of the present setting, which are more accurate than those of the nearest computed point.
  private marked(): CurvePoint {
    const { newton, icm, scenario } = this.state.drop!;
    const top = scenario.balls.length - 1;
    const value = (t: typeof newton): number => (scenario.cradle ? t.leaves[top] : t.peaks[top]);
    return { x: valueOn(this.state.scenario, this.view.curve), newton: value(newton), icm: value(icm) };
  }

  private describe(p: CurvePoint): string {
    const text = (x: number): string =>
      !Number.isFinite(x) ? "none" : this.state.scenario.cradle ? withUnit(x, "m/s") : metres(x);
    return `${newton.short} ${text(p.newton)}, ${independent.short} ${text(p.icm)}`;
  }

  // Newton's height at gap 0 and the greatest one over all gaps; null until the curve is complete.
  extremes(): StoryFacts["gaps"] {
    return extremesOf(this.curve);
  }

  private choose(x: number): void {
    const { scenario: s } = this.state;
    if (this.view.curve === "e") s.restitution = clampTo(ranges.restitution, Number(x.toFixed(3)));
    else if (this.view.curve === "gap")
      s.gaps = s.gaps.map((gap, i) => (i < firstGap(s) ? gap : clampTo(ranges.gap, Number(x.toPrecision(3)))));
    else {
      const before = s.balls[0].radius;
      s.balls[0].radius = clampTo(ranges.radius, Number((x * s.balls[1].radius).toPrecision(4)));
      if (s.height < lowestHeight(s)) s.balls[0].radius = before;
    }
    this.state.edited();
  }

  // ---- changes ----------------------------------------------------------------------------------------

  private listen(): void {
    const { canvas } = this.sheet;
    dragged(canvas, (x) => this.layout && this.choose(valueAt(this.layout, x)));
    canvas.addEventListener("pointermove", (e) => {
      if (e.pointerType === "touch" || !this.layout) return;
      this.hovered = valueAt(this.layout, e.offsetX);
    });
    canvas.addEventListener("pointerleave", () => (this.hovered = null));
    canvas.addEventListener("keydown", (e) => this.press(e));
    find<HTMLSelectElement>("rebound-axis").addEventListener("change", (e) =>
      this.setAxis((e.target as HTMLSelectElement).value as CurveAxis),
    );
    const file = find<HTMLInputElement>("measured-file");
    find("measured").addEventListener("click", () => (this.measured ? this.setMeasured(null, "") : file.click()));
    file.addEventListener("change", () => {
      if (file.files?.[0]) void this.load(file.files[0]);
      file.value = "";
    });
  }

  setAxis(axis: CurveAxis): void {
    this.view.curve = axis;
    this.refresh();
    this.state.writeLink();
  }

  private press(e: KeyboardEvent): void {
    if (!this.layout) return;
    const { low, high, log } = this.curve.span;
    const now = valueOn(this.state.scenario, this.view.curve);
    const by = (share: number): number => {
      if (!log) return now + share * (high - low);
      if (now === 0) return share > 0 ? low : 0;
      const next = now * (high / low) ** share;
      return this.view.curve === "gap" && next < 0.999 * low && share < 0 ? 0 : next;
    };
    const to: Record<string, number> = {
      ArrowRight: by(0.01),
      ArrowUp: by(0.01),
      ArrowLeft: by(-0.01),
      ArrowDown: by(-0.01),
      PageUp: by(0.1),
      PageDown: by(-0.1),
      Home: this.view.curve === "gap" ? 0 : low,
      End: high,
    };
    if (!(e.key in to)) return;
    e.preventDefault();
    e.stopPropagation();
    this.choose(Math.min(to[e.key], high));
  }

  // ---- measured heights -------------------------------------------------------------------------------

  async load(file: File): Promise<void> {
    if (file.size > largestFile)
      return this.setMeasured(null, `${file.name}: got ${file.size} bytes, must be at most ${largestFile}`);
    try {
      const measurements = readMeasurements(await file.text());
      this.setMeasured(measurements, "");
      if (measurements.axis !== this.view.curve) this.setAxis(measurements.axis);
      const [low, high] = [
        Math.min(...measurements.list.map((m) => m.height)),
        Math.max(...measurements.list.map((m) => m.height)),
      ];
      this.note(
        `${file.name}: ${measurements.list.length} measured height${measurements.list.length === 1 ? "" : "s"}, ` +
          `${digits(low)} to ${digits(high)} m.`,
        false,
      );
    } catch (error) {
      this.setMeasured(null, `${file.name}: ${(error as Error).message}`);
    }
  }

  private setMeasured(measured: Measurements | null, fault: string): void {
    this.measured = measured;
    find("measured").textContent = measured ? "Remove measured heights" : "Load measured heights (CSV)";
    this.note(fault, true);
  }

  private note(text: string, fault: boolean): void {
    const box = find("measured-note");
    box.textContent = text;
    box.hidden = text === "";
    box.classList.toggle("fault", fault);
  }
}

// Identifies the parameters of a curve, except the one along its axis.
function keyOf(scenario: Scenario, axis: CurveAxis, span: object): string {
  const s = { ...scenario, gaps: [...scenario.gaps], balls: scenario.balls.map((b) => ({ ...b })) };
  if (axis === "e") s.restitution = 0;
  else if (axis === "gap") s.gaps = s.gaps.map((gap, i) => (i < firstGap(s) ? gap : 0));
  else s.balls[0].radius = 0;
  return JSON.stringify([s, axis, span]);
}

export function extremesOf({ points, touching, axis, done }: Curve): StoryFacts["gaps"] {
  if (!done || axis !== "gap" || !touching) return null;
  const best = [touching, ...points].reduce((a, b) => (b.newton > a.newton ? b : a));
  return { touching: touching.newton, best: best.newton, at: best.x };
}
