// The choices of the tolerance, beside the verdict and beside the map.
import { inPercent, tolerances } from "../scenario/tolerance";
import type { View } from "../scenario/view";

export function fillTolerances(view: View, changed: () => void): void {
  const list = [...new Set([...tolerances, view.tolerance])].sort((a, b) => a - b);
  for (const select of document.querySelectorAll<HTMLSelectElement>(".tolerances")) {
    select.replaceChildren(...list.map((x) => new Option(inPercent(x), String(x), false, x === view.tolerance)));
    select.onchange = () => {
      view.tolerance = Number(select.value);
      fillTolerances(view, changed);
      changed();
    };
  }
}
