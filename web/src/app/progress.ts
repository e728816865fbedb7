// Progress of long computations.
import { find, setHidden } from "../support/dom";

// A progress bar with a cancel button, shown after a short delay.
export class Progress {
  private timer = 0;
  private began = 0;
  private what = "";
  private share = 0;

  constructor(giveUp: () => void) {
    find("give-up").addEventListener("click", giveUp);
  }

  begin(what: string): void {
    this.update(what, 0);
    this.began = performance.now();
    if (this.timer === 0) this.timer = window.setInterval(() => this.show(), 200);
  }
  update(what: string, share: number): void {
    this.what = what;
    this.share = share;
  }
  end(): void {
    clearInterval(this.timer);
    this.timer = 0;
    setHidden(find("busy"), true);
  }

  private show(): void {
    setHidden(find("busy"), false);
    find<HTMLProgressElement>("progress").value = this.share;
    find("busy-what").textContent = `Computing ${this.what}: ${((performance.now() - this.began) / 1000).toFixed(1)} s`;
  }
}
