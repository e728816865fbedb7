// A part of a drawing that is dragged vertically by mouse, finger or arrow keys. For screen readers it is a slider.
import { setAttribute } from "./dom";
import { niceBelow } from "./format";

export interface Pull {
  label: string;
  range: { low: number; high: number };
  value(): number;
  text(): string;
  set(value: number): void;
  perPixel(): number; // change of the value for a pixel upwards
  size(): number; // an arrow key changes the value by about a fiftieth of this, Page Up and Page Down by a fifth
  dragged?(on: boolean): void; // as the drag begins and ends
}

export class Handle {
  readonly element = document.createElement("div");
  private wanted = 0; // the value before it is rounded
  private last = 0; // pixel

  // `twin`: a second area for the same value, for the pointer only.
  constructor(
    box: HTMLElement,
    private readonly pull: Pull,
    twin = false,
  ) {
    const { element } = this;
    element.className = "handle";
    if (twin) element.setAttribute("aria-hidden", "true");
    else {
      element.tabIndex = 0;
      element.setAttribute("role", "slider");
      element.setAttribute("aria-orientation", "vertical");
      element.setAttribute("aria-label", pull.label);
      element.setAttribute("aria-valuemin", String(pull.range.low));
      element.setAttribute("aria-valuemax", String(pull.range.high));
      element.addEventListener("keydown", (e) => this.key(e));
      this.refresh();
    }
    element.title = pull.label;
    element.addEventListener("pointerdown", (e) => {
      if (e.button !== 0) return;
      e.preventDefault();
      if (!twin) element.focus({ preventScroll: true });
      element.setPointerCapture(e.pointerId);
      this.wanted = pull.value();
      this.last = e.clientY;
      pull.dragged?.(true);
    });
    element.addEventListener("pointermove", (e) => {
      if (!element.hasPointerCapture(e.pointerId)) return;
      const { low, high } = pull.range;
      this.wanted = Math.min(Math.max(this.wanted + (this.last - e.clientY) * pull.perPixel(), low), high);
      this.last = e.clientY;
      pull.set(this.wanted);
    });
    element.addEventListener("lostpointercapture", () => pull.dragged?.(false));
    box.append(element);
  }

  // Position in the drawing by its centre [px]; null: hidden.
  place(at: { x: number; y: number; width: number; height: number } | null): void {
    const { style } = this.element;
    if (style.display !== (at ? "" : "none")) style.display = at ? "" : "none";
    if (!at) return;
    const size = `${Math.round(at.width / 4) * 4}px`; // rounded, because a new size costs a layout
    if (style.width !== size) style.width = size;
    const tall = `${Math.round(at.height / 4) * 4}px`;
    if (style.height !== tall) style.height = tall;
    Object.assign(style, { transform: `translate(${at.x - 0.5 * at.width}px, ${at.y - 0.5 * at.height}px)` });
  }

  refresh(): void {
    setAttribute(this.element, "aria-valuenow", String(this.pull.value()));
    setAttribute(this.element, "aria-valuetext", this.pull.text());
  }

  private key(e: KeyboardEvent): void {
    const { pull } = this;
    const step = niceBelow(pull.size() / 50);
    const by: Record<string, number> = {
      ArrowUp: step,
      ArrowRight: step,
      ArrowDown: -step,
      ArrowLeft: -step,
      PageUp: 10 * step,
      PageDown: -10 * step,
      Home: -Infinity,
      End: Infinity,
    };
    if (!(e.key in by)) return;
    e.preventDefault();
    e.stopPropagation();
    const next = pull.value() + by[e.key];
    pull.set(
      Math.min(Math.max(Number.isFinite(next) ? Number(next.toPrecision(9)) : next, pull.range.low), pull.range.high),
    );
  }
}
