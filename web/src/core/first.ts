// Runs before the page is laid out: sets the theme and starts the worker that opens the page. The worker computes the
// setting of the link; its answers are kept until the page has started.
import { chosenTheme, themeNow } from "../style/chosen_theme";
import type { Reply } from "./worker";

export type Heard = MessageEvent<Reply> | ErrorEvent;

export interface First {
  worker: Worker;
  early: Heard[];
  hear(event: Heard): void;
}

declare global {
  interface Window {
    first?: First;
  }
}

const worker = new Worker("worker.js", { type: "module", name: location.href });
const first: First = (window.first = { worker, early: [], hear: (event) => void first.early.push(event) });
worker.onmessage = (event) => first.hear(event);
worker.onerror = (event) => first.hear(event);
document.documentElement.dataset.theme = themeNow(chosenTheme());
