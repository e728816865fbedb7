// Draws the report: the table of results, the energy bars, the definitions.
import { namesOf } from "../core/tables";
import type { Report } from "../report/report";

// "ε_eff" with a real subscript.
export function subscripted(text: string): (string | HTMLElement)[] {
  return text.split(/(_\w+)/).map((part) => {
    if (!part.startsWith("_")) return part;
    const sub = document.createElement("sub");
    sub.textContent = part.slice(1);
    return sub;
  });
}

export function fillTable(table: HTMLElement, { table: list }: Report): void {
  for (const [model, names] of Object.entries(namesOf)) table.querySelector(`th.${model}`)!.textContent = names.short;
  const body = table.querySelector("tbody")!;
  while (body.children.length > list.length) body.lastElementChild!.remove();
  list.forEach((r, i) => {
    let tr = body.children[i] as HTMLTableRowElement | undefined;
    if (!tr) {
      tr = document.createElement("tr");
      const th = document.createElement("th");
      th.scope = "row";
      tr.append(th, document.createElement("td"), document.createElement("td"));
      body.append(tr);
    }
    tr.className = r.lead ? "lead" : "";
    tr.dataset.id = r.id;
    [r.name, ...r.values].forEach((text, k) => {
      const cell = tr!.children[k] as HTMLElement;
      if (cell.dataset.text === text) return;
      cell.dataset.text = text;
      cell.replaceChildren(...subscripted(text));
    });
    tr.children[1].classList.add("newton");
    tr.children[2].classList.add("icm");
  });
}

const element = (tag: string, className: string, text = ""): HTMLElement => Object.assign(document.createElement(tag), { className, textContent: text });

export function fillEnergy(box: HTMLElement, { shares }: Report): void {
  const { rows } = shares;
  const bars = (["newton", "icm"] as const).flatMap((model, k) => {
    const part = shares[model];
    if (!part) return [];
    const { short } = namesOf[model];
    const bar = element("div", "bar");
    bar.setAttribute("role", "img");
    bar.setAttribute("aria-label", `${short}: ${rows.map((r) => `${r.name} ${r.percent[k]}`).join(", ")}`);
    const widths = [...part.balls].reverse();
    if (rows.length > widths.length + 1) widths.push(part.stored);
    [...widths, part.lost].forEach((share, i) => {
      const piece = document.createElement("div");
      piece.style.width = `${100 * share}%`;
      piece.style.background = `var(--${rows[i].color})`;
      bar.append(piece);
    });
    return [element("div", `energy-name ${model}`, short), bar];
  });
  const legend = element("div", "legend");
  for (const r of rows) {
    const swatch = document.createElement("i");
    swatch.style.background = `var(--${r.color})`;
    legend.append(swatch, element("span", "", r.name), element("b", "newton", r.percent[0]), element("b", "icm", r.percent[1] ?? "…"));
  }
  box.replaceChildren(...bars, legend);
}

// Definitions of the names shown in the table.
export function fillDefinitions(list: HTMLElement, report: Report): void {
  const parts = report.table.flatMap((r) => {
    const [dt, dd] = [document.createElement("dt"), document.createElement("dd")];
    dt.replaceChildren(...subscripted(r.name));
    dd.replaceChildren(...subscripted(r.title));
    return [dt, dd];
  });
  list.replaceChildren(...parts);
}
