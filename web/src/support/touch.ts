// Touch input: a swipe scrolls the page. A tap selects a point of a plot and activates the plot: fingers then drag in
// it until something else is touched.
type Place = (x: number, y: number) => void;

const still = 8; // tolerance for a finger at rest [pixels]

// Activates a plot on a tap; mouse and pen need no tap.
function livens(canvas: HTMLElement, tap: Place): void {
  let from: PointerEvent | null = null;
  canvas.addEventListener(
    "pointerdown",
    (e) => (from = e.pointerType === "touch" && !isLive(canvas) && e.isPrimary ? e : null),
  );
  canvas.addEventListener("pointercancel", () => (from = null));
  canvas.addEventListener("pointerup", (e) => {
    if (!from || Math.hypot(e.clientX - from.clientX, e.clientY - from.clientY) > still) return;
    from = null;
    canvas.dataset.live = "";
    tap(e.offsetX, e.offsetY);
  });
  document.addEventListener("pointerdown", (e) => {
    if (e.target !== canvas) delete canvas.dataset.live;
  });
}

export const isLive = (canvas: HTMLElement): boolean => canvas.dataset.live !== undefined;

// Whether a pointer may drag in a plot.
const works = (canvas: HTMLElement, e: PointerEvent): boolean =>
  e.button === 0 && (e.pointerType !== "touch" || isLive(canvas));

// Calls `move` with the position of a pressed pointer.
export function dragged(canvas: HTMLCanvasElement, move: Place): void {
  let dragging = false;
  canvas.addEventListener("pointerdown", (e) => {
    if (!works(canvas, e)) return;
    canvas.setPointerCapture(e.pointerId);
    dragging = true;
    move(e.offsetX, e.offsetY);
  });
  canvas.addEventListener("pointermove", (e) => {
    if (dragging && canvas.hasPointerCapture(e.pointerId)) move(e.offsetX, e.offsetY);
  });
  for (const type of ["pointerup", "pointercancel"] as const) canvas.addEventListener(type, () => (dragging = false));
  livens(canvas, move);
}

export interface Gestures {
  choose: Place;
  pan: Place; // by a distance in pixels
  zoom: (factor: number, x: number, y: number) => void; // about a point
  frame: (from: [number, number], to: [number, number], done: boolean) => void; // a rectangle drawn with Shift
  hover: (at: [number, number] | null) => void;
}

// Gestures of a map: a click or a tap chooses a point, a drag moves the map, Shift and a drag draw a rectangle, two
// fingers or Ctrl and the wheel zoom.
export function moved(canvas: HTMLCanvasElement, to: Gestures): void {
  const pressed = new Map<number, [number, number]>();
  let begin: [number, number] | null = null; // of a press that is not yet a drag
  let framing = false;
  const at = (e: MouseEvent): [number, number] => [e.offsetX, e.offsetY];
  canvas.addEventListener("pointerdown", (e) => {
    if (!works(canvas, e)) return;
    canvas.setPointerCapture(e.pointerId);
    begin = pressed.size === 0 ? at(e) : null;
    framing = e.shiftKey && pressed.size === 0;
    pressed.set(e.pointerId, at(e));
  });
  canvas.addEventListener("pointermove", (e) => {
    const before = pressed.get(e.pointerId);
    if (!before) return e.pointerType === "touch" ? undefined : to.hover(at(e));
    const [x, y] = at(e);
    if (begin && !framing && Math.hypot(x - begin[0], y - begin[1]) <= still / 2) return;
    if (framing) return begin ? to.frame(begin, [x, y], false) : undefined;
    begin = null;
    const others = [...pressed].filter(([id]) => id !== e.pointerId).map(([, place]) => place);
    pressed.set(e.pointerId, [x, y]);
    if (others.length === 0) return to.pan(x - before[0], y - before[1]);
    const [a, b] = others[0];
    const apart = (p: [number, number]): number => Math.max(Math.hypot(p[0] - a, p[1] - b), 1);
    to.zoom(apart([x, y]) / apart(before), (x + a) / 2, (y + b) / 2);
    to.pan((x - before[0]) / 2, (y - before[1]) / 2);
  });
  canvas.addEventListener("pointerup", (e) => {
    if (!pressed.delete(e.pointerId) || !begin) return;
    if (framing) to.frame(begin, at(e), true);
    else to.choose(...begin);
    begin = null;
  });
  canvas.addEventListener("pointercancel", (e) => {
    pressed.delete(e.pointerId);
    begin = null;
  });
  canvas.addEventListener("pointerleave", () => to.hover(null));
  canvas.addEventListener(
    "wheel",
    (e) => {
      if (!e.ctrlKey && !e.metaKey && document.activeElement !== canvas) return;
      e.preventDefault();
      to.zoom(Math.exp(Math.min(Math.max(-e.deltaY, -100), 100) / 400), e.offsetX, e.offsetY);
    },
    { passive: false },
  );
  livens(canvas, to.choose);
}

// Wraps a slider in a frame that handles touch (style.css): the thumb follows a finger that moves along
// the slider, a tap sets it, and a swipe across it scrolls.
export function touchable(slider: HTMLInputElement): HTMLElement {
  const track = document.createElement("span");
  track.className = "track";
  slider.replaceWith(track);
  track.append(slider);
  const [low, high] = [Number(slider.min), Number(slider.max)];
  let from: { x: number; y: number; value: number; slides: boolean } | null = null;
  const set = (value: number): void => {
    const before = slider.value;
    slider.value = String(Math.min(Math.max(value, low), high));
    if (slider.value !== before) slider.dispatchEvent(new Event("input", { bubbles: true }));
  };
  const jump = (e: PointerEvent): void => set(low + ((high - low) * (e.offsetX - 8)) / (track.clientWidth - 16));
  track.addEventListener("pointerdown", (e) => {
    if (e.target !== track || e.button !== 0 || !e.isPrimary) return;
    const slides = e.pointerType !== "touch";
    track.setPointerCapture(e.pointerId);
    if (slides) slider.focus();
    if (slides) jump(e);
    from = { x: e.clientX, y: e.clientY, value: Number(slider.value), slides };
  });
  track.addEventListener("pointermove", (e) => {
    if (!from) return;
    const [dx, dy] = [e.clientX - from.x, e.clientY - from.y];
    from.slides ||= Math.abs(dx) > still && Math.abs(dx) > Math.abs(dy);
    if (from.slides) set(from.value + ((high - low) * dx) / (track.clientWidth - 16));
  });
  track.addEventListener("pointerup", (e) => {
    if (from && !from.slides && Math.hypot(e.clientX - from.x, e.clientY - from.y) <= still) jump(e);
    from = null;
  });
  track.addEventListener("pointercancel", () => (from = null));
  return track;
}
