// The headline of the laboratory: what both models give, and the verdict.
import { find, setSentence, Sheet } from "../support/dom";

export class Headline {
  private written = "";
  private readonly newton = find("verdict").querySelector<HTMLElement>(".newton")!;
  private readonly icm = find("verdict").querySelector<HTMLElement>(".icm")!;
  private readonly announcer = new Announcer();
  private readonly changing = [...document.querySelectorAll<HTMLElement>(".answers, .numbers")];
  private readonly heights = new ResizeObserver((entries) => {
    if (Sheet.moving)
      for (const {
        target,
        borderBoxSize: [{ blockSize }],
      } of entries)
        (target as HTMLElement).style.minHeight = `${blockSize}px`;
  });

  write(newton: string, icm: string, verdict: string): void {
    const all = [newton, icm, verdict].join("\n");
    if (all === this.written) return;
    this.written = all;
    setSentence(this.newton, newton + " ");
    setSentence(this.icm, icm);
    setSentence(find("answer"), verdict);
    this.announcer.announce(`${newton} ${icm} ${verdict}`);
  }

  // While a slider moves, texts keep their greatest height, so that the page below them does not move.
  keepHeights(on: boolean): void {
    if (!on) this.heights.disconnect();
    for (const part of this.changing) {
      if (on)
        this.heights.observe(part); // also reports the present height
      else part.style.minHeight = "";
    }
  }
}

// Announces the result to screen readers when a slider has stopped.
class Announcer {
  private timer = 0;

  announce(text: string): void {
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => (find("announcer").textContent = text), 600);
  }
}
