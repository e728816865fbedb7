// The two plots over time, forces and timeline: drawing, pointer and keys.
import { find, setText, type Sheet } from "../support/dom";
import { clockText, type Film } from "./film";
import { drawForces, type ForcesLayout } from "./forces";
import type { Frame } from "../support/pen";
import type { Scale } from "../support/plot";
import type { Pool } from "../core/pool";
import { clampTo, copyOf, ranges } from "../scenario/scenario";
import { observed, type Drawing } from "../state/signals";
import type { State } from "../state/state";
import { Timeline } from "./timeline";
import type { TimelineLayout } from "./timeline_drawing";
import { dragged } from "../support/touch";

// Moves the marker lines of the film's time in a plot.
function placeCursors(cursors: HTMLElement[], time: number, x: Scale, frames: Frame[]): void {
  cursors.forEach((cursor, i) => {
    const frame = frames[i];
    const hidden = !frame || time < x.low || time > x.high;
    if (cursor.hidden !== hidden) cursor.hidden = hidden;
    if (hidden) return;
    cursor.style.transform = `translate(${x.at(time)}px, ${frame.top}px)`;
    const height = `${frame.height}px`;
    if (cursor.style.height !== height) cursor.style.height = height;
  });
}

const cursorsIn = (box: string): HTMLElement[] => [...find(box).querySelectorAll<HTMLElement>(".cursor")];

// Contact forces; a press chooses the time of the film.
export class ForcesPanel {
  private layout: ForcesLayout | null = null;
  readonly picture: Drawing;
  readonly cursor: Drawing;
  private readonly cursors = cursorsIn("forces-box");

  constructor(
    private readonly state: State,
    private readonly sheet: Sheet,
    private readonly film: Film,
  ) {
    observed(this, ["layout"]);
    this.picture = state.drawing(() => this.draw());
    this.cursor = state.drawing(() => this.mark());
    dragged(sheet.canvas, (x) => this.layout && this.choose(this.layout.x.value(x)));
    sheet.canvas.addEventListener("keydown", (e) => this.key(e));
  }

  private draw(): void {
    const { state, sheet } = this;
    if (!sheet.shown()) return;
    this.layout = drawForces(sheet.g, sheet.width, sheet.height, state.drop!, state.theme);
  }

  private mark(): void {
    const { layout, state, sheet } = this;
    if (!layout || !sheet.seen) return;
    const time = state.time();
    placeCursors(this.cursors, time, layout.x, layout.frames);
    const share = Math.round((1000 * (time - layout.x.low)) / (layout.x.high - layout.x.low));
    sheet.canvas.setAttribute("aria-valuenow", String(Math.min(Math.max(share, 0), 1000)));
    if (!state.playing) sheet.canvas.setAttribute("aria-valuetext", clockText(time, state.drop!));
  }

  private choose(time: number): void {
    if (this.state.playing) this.film.play(false);
    this.film.seek(time);
    this.state.writeLink();
  }

  private key(e: KeyboardEvent): void {
    if (!this.layout) return;
    const { low, high } = this.layout.x;
    const now = this.state.time();
    const to: Record<string, number> = {
      ArrowLeft: now - (high - low) / 200,
      ArrowRight: now + (high - low) / 200,
      PageDown: now - (high - low) / 20,
      PageUp: now + (high - low) / 20,
      Home: low,
      End: high,
    };
    if (!(e.key in to)) return;
    e.preventDefault();
    this.choose(Math.min(Math.max(to[e.key], low), high));
  }
}

// Contacts over ε; a press chooses ε.
export class TimelinePanel {
  readonly timeline: Timeline;
  private readonly cursors = cursorsIn("timeline-box");
  private drawn = 0;
  private layout: TimelineLayout | null = null;
  readonly picture: Drawing;
  readonly cursor: Drawing;
  private key = "";

  constructor(
    private readonly state: State,
    private readonly sheet: Sheet,
    pool: Pool,
  ) {
    this.timeline = new Timeline(pool, sheet.wanted);
    observed(this, ["layout"]);
    this.picture = state.drawing(() => this.draw());
    this.cursor = state.drawing(() => this.mark());
    dragged(sheet.canvas, (_, y) => this.layout && this.choose(this.layout.y.value(y)));
    sheet.canvas.addEventListener("keydown", (e) => {
      const by: Record<string, number> = {
        ArrowUp: 0.005,
        ArrowRight: 0.005,
        ArrowDown: -0.005,
        ArrowLeft: -0.005,
        PageUp: 0.05,
        PageDown: -0.05,
        Home: -1,
        End: 1,
      };
      if (!(e.key in by)) return;
      e.preventDefault();
      this.choose(this.state.scenario.restitution + by[e.key]);
    });
  }

  // Restarts unless only ε has changed.
  refresh(): void {
    this.sheet.canvas.setAttribute("aria-valuenow", String(this.state.scenario.restitution)); // also out of the window
    const key = JSON.stringify({ ...this.state.scenario, restitution: 0 });
    if (key === this.key) return;
    this.key = key;
    this.timeline.start(copyOf(this.state.scenario));
    this.sheet.canvas.dataset.computed = "false";
  }

  // Whether the plot may be drawn; less often while rows are computed.
  due(now: number): boolean {
    return this.sheet.shown() && (this.timeline.done || (this.sheet.seen && now - this.drawn >= 120));
  }

  private draw(): void {
    const { state, sheet } = this;
    this.drawn = performance.now();
    this.layout = this.timeline.draw(sheet.g, sheet.width, sheet.height, state.drop!, state.theme);
    const s = state.scenario;
    sheet.canvas.dataset.computed = String(this.timeline.done);
    const exact = s.law === "linear" && s.balls.length === 2 && !s.cradle;
    const { done, progress, goesOn } = this.timeline;
    const hint =
      (done ? "" : `${Math.floor(100 * progress)} % computed. `) +
      (exact ? "Dotted edges: the same with the lower ball unaffected by the upper one. " : "") +
      (s.cradle ? "" : "Dashed: the floor contact ends. ") +
      (done && goesOn && !s.cradle ? "Some contacts come later than shown. " : "");
    setText(find("timeline-hint"), hint);
  }

  private mark(): void {
    const { layout, state, sheet } = this;
    if (layout && sheet.seen) placeCursors(this.cursors, state.time(), layout.x, [layout.frame]);
  }

  private choose(restitution: number): void {
    this.state.scenario.restitution = clampTo(ranges.restitution, Number(restitution.toFixed(3)));
    this.state.edited();
  }
}
