// The settings for undo.
import { copyOf, type Scenario } from "../scenario/scenario";
import { find, refocus } from "../support/dom";

const pause = 700; // changes within this time are undone together [ms]

export class Past {
  private readonly list: Scenario[] = [];
  private before: Scenario;
  private last = -Infinity;

  constructor(scenario: Scenario) {
    this.before = copyOf(scenario);
  }

  // When the setting was changed last [ms]; −∞ after undo and settle().
  get changedAt(): number {
    return this.last;
  }

  remember(scenario: Scenario): void {
    if (performance.now() - this.last > pause) this.list.push(this.before);
    this.last = performance.now();
    this.before = copyOf(scenario);
    find<HTMLButtonElement>("undo").disabled = false;
  }

  // The setting was changed by the browser's history or by Cancel, which cannot be undone. If the list contains the
  // same setting, later entries are removed.
  settle(scenario: Scenario): void {
    const same = this.list.map((past) => JSON.stringify(past)).lastIndexOf(JSON.stringify(scenario));
    if (same >= 0) this.list.length = same;
    this.set(scenario);
  }

  undo(): Scenario | null {
    const before = this.list.pop();
    if (!before) return null;
    this.set(before);
    return copyOf(before);
  }

  private set(scenario: Scenario): void {
    this.before = copyOf(scenario);
    this.last = -Infinity;
    const undo = find<HTMLButtonElement>("undo");
    const focused = document.activeElement === undo;
    undo.disabled = this.list.length === 0;
    if (focused && undo.disabled) refocus();
  }
}
