// Pointer and keys of the map.
import type { Box } from "../scenario/view";
import type { Scale } from "../support/plot";
import { moved } from "../support/touch";
import type { MapLayout } from "./map_drawing";

export type Point = [x: number, y: number]; // on the axes of the map

export interface MapActions {
  layout(): MapLayout | null;
  marked(): Point;
  choose(point: Point): void;
  pan(right: number, up: number): void; // by fractions of the frame
  zoom(factor: number, at?: Point): void;
  frame(box: Box | null): void; // null: the whole map
  hover(point: Point | null): void;
}

// `rubber`: the rectangle that is being drawn.
export function listen(canvas: HTMLCanvasElement, rubber: HTMLElement, map: MapActions): void {
  listenPointer(canvas, rubber, map);
  listenKeys(canvas, map);
}

function listenPointer(canvas: HTMLCanvasElement, rubber: HTMLElement, map: MapActions): void {
  // Pixels within the frame, and the parameters there.
  const inside = ({ frame }: MapLayout, [x, y]: [number, number]): [number, number] => {
    const clip = (v: number, low: number, size: number): number => Math.min(Math.max(v, low), low + size);
    return [clip(x, frame.left, frame.width), clip(y, frame.top, frame.height)];
  };
  const value = (layout: MapLayout, at: [number, number]): Point => {
    const [x, y] = inside(layout, at);
    return [layout.x.value(x), layout.y.value(y)];
  };
  const drawn = (act: (layout: MapLayout) => void): void => {
    const layout = map.layout();
    if (layout) act(layout);
  };
  moved(canvas, {
    choose: (x, y) => drawn((layout) => map.choose(value(layout, [x, y]))),
    pan: (dx, dy) => drawn(({ frame }) => map.pan(dx / frame.width, -dy / frame.height)),
    zoom: (factor, x, y) => drawn((layout) => map.zoom(factor, value(layout, [x, y]))),
    hover: (at) => {
      const layout = map.layout();
      map.hover(at && layout ? value(layout, at) : null);
    },
    frame: (from, to, done) =>
      drawn((layout) => {
        const [[x0, y0], [x1, y1]] = [inside(layout, from), inside(layout, to)];
        const wide = Math.abs(x1 - x0) > 6 && Math.abs(y1 - y0) > 6;
        rubber.hidden = done || !wide;
        rubber.style.transform = `translate(${Math.min(x0, x1)}px, ${Math.min(y0, y1)}px)`;
        rubber.style.width = `${Math.abs(x1 - x0)}px`;
        rubber.style.height = `${Math.abs(y1 - y0)}px`;
        if (!done || !wide) return;
        const [a, b] = [value(layout, from), value(layout, to)];
        map.frame({ x: [Math.min(a[0], b[0]), Math.max(a[0], b[0])], y: [Math.min(a[1], b[1]), Math.max(a[1], b[1])] });
      }),
  });
}

function listenKeys(canvas: HTMLCanvasElement, map: MapActions): void {
  canvas.addEventListener("keydown", (event) => {
    const layout = map.layout();
    if (!layout) return;
    const [x, y] = map.marked();
    // From a value to the next one on its axis. On a logarithmic axis gap 0 is at its low end.
    const step = ({ low, high, log }: Scale, at: number, by: number): number =>
      log ? Math.max(at, low) * (high / low) ** (0.01 * by) : at + 0.01 * by * (high - low);
    const go = (right: number, up: number): void => map.choose([step(layout.x, x, right), step(layout.y, y, up)]);
    const actions: Record<string, () => void> = {
      ArrowLeft: () => go(-1, 0),
      ArrowRight: () => go(1, 0),
      ArrowUp: () => go(0, 1),
      ArrowDown: () => go(0, -1),
      "+": () => map.zoom(1.6),
      "=": () => map.zoom(1.6),
      "-": () => map.zoom(1 / 1.6),
      "0": () => map.frame(null),
    };
    if (!actions[event.key]) return;
    event.preventDefault();
    actions[event.key]();
  });
}
