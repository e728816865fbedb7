// State as signals: a drawing is drawn again after something that it has read has changed.
import { computed, signal } from "@preact/signals-core";

// Turns fields of an object into signals, all of them unless some are named.
export function observed<T extends object>(object: T, names: string[] = Object.keys(object)): T {
  for (const name of names) {
    const field = signal((object as Record<string, unknown>)[name]);
    const set = (x: unknown): void => void (field.value = x);
    Object.defineProperty(object, name, { enumerable: true, get: () => field.value, set });
  }
  return object;
}

// A drawing does not follow a change at once: the page asks for it in a frame, when it is in view and has time.
export class Drawing {
  private count = 0;
  private readonly drawn = computed(() => {
    this.draw();
    return ++this.count;
  });

  constructor(private readonly draw: () => void) {}

  // Draws if something has changed; returns whether it has.
  refresh(): boolean {
    const before = this.count;
    return this.drawn.value !== before;
  }
}
