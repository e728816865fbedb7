// The settings that undo returns to.
import { copyOf, type Scenario } from "../scenario/scenario";
import { find } from "../support/dom";

const pause = 700; // ms between changes that are taken back one by one

export class Past {
  private readonly list: Scenario[] = [];
  private before: Scenario;
  private last = -Infinity;

  constructor(scenario: Scenario) {
    this.before = copyOf(scenario);
  }

  // When the setting was changed last [ms]; −∞ after undo.
  get changedAt(): number {
    return this.last;
  }

  remember(scenario: Scenario): void {
    if (performance.now() - this.last > pause) this.list.push(this.before);
    this.last = performance.now();
    this.before = copyOf(scenario);
    find<HTMLButtonElement>("undo").disabled = false;
  }

  undo(): Scenario | null {
    const before = this.list.pop();
    if (!before) return null;
    this.before = copyOf(before);
    this.last = -Infinity;
    find<HTMLButtonElement>("undo").disabled = this.list.length === 0;
    return copyOf(before);
  }
}
