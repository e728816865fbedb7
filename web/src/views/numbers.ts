// Draws the report: the table of results, the energy bars, the definitions.
import { changes, setAttribute, setText } from "../support/dom";
import { namesOf } from "../scenario/tables";
import type { Report, ShareRow } from "../report/report";

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
  for (const [model, names] of Object.entries(namesOf)) setText(table.querySelector(`th.${model}`)!, names.short);
  const body = table.querySelector("tbody")!;
  while (body.children.length > list.length) body.lastElementChild!.remove();
  list.forEach((r, i) => {
    let tr = body.children[i] as HTMLTableRowElement | undefined;
    if (!tr) {
      tr = document.createElement("tr");
      const th = document.createElement("th");
      th.scope = "row";
      const [newton, icm] = ["newton", "icm"].map((className) =>
        Object.assign(document.createElement("td"), { className }),
      );
      tr.append(th, newton, icm);
      body.append(tr);
    }
    setAttribute(tr, "class", r.lead ? "lead" : "");
    setAttribute(tr, "data-id", r.id);
    [r.name, ...r.values].forEach((text, k) => {
      const cell = tr.children[k] as HTMLElement;
      if (!text.includes("_")) setText(cell, text);
      else if (cell.textContent !== text.replaceAll("_", "")) cell.replaceChildren(...subscripted(text));
    });
  });
}

const element = (tag: string, className: string, text = ""): HTMLElement =>
  Object.assign(document.createElement(tag), { className, textContent: text });

export function fillEnergy(box: HTMLElement, { shares }: Report): void {
  const { rows } = shares;
  const models = (["newton", "icm"] as const).filter((model) => shares[model]);
  const shape = [models, rows.map((r) => r.name + r.color)].join();
  if (changes(box, shape)) buildEnergy(box, models, rows);
  models.forEach((model, k) => {
    const part = shares[model]!;
    const bar = box.children[2 * k + 1];
    bar.setAttribute(
      "aria-label",
      `${namesOf[model].short}: ${rows.map((r) => `${r.name} ${r.percent[k]}`).join(", ")}`,
    );
    const widths = [...part.balls].reverse();
    if (rows.length > widths.length + 1) widths.push(part.stored);
    [...widths, part.lost].forEach((share, i) => ((bar.children[i] as HTMLElement).style.width = `${100 * share}%`));
  });
  rows.forEach(({ percent }, i) => {
    const legend = box.lastElementChild!.children;
    setText(legend[4 * i + 2], percent[0]);
    setText(legend[4 * i + 3], percent[1] ?? "…");
  });
}

function buildEnergy(box: HTMLElement, models: ("newton" | "icm")[], rows: ShareRow[]): void {
  const colored = (tag: string, { color }: ShareRow): HTMLElement => {
    const piece = document.createElement(tag);
    piece.style.background = `var(--${color})`;
    return piece;
  };
  const bars = models.flatMap((model) => {
    const bar = element("div", "bar");
    bar.setAttribute("role", "img");
    bar.append(...rows.map((r) => colored("div", r)));
    return [element("div", `energy-name ${model}`, namesOf[model].short), bar];
  });
  const legend = element("div", "legend");
  for (const r of rows)
    legend.append(colored("i", r), element("span", "", r.name), element("b", "newton"), element("b", "icm"));
  box.replaceChildren(...bars, legend);
}

// Definitions of the names shown in the table.
export function fillDefinitions(list: HTMLElement, report: Report): void {
  const key = report.table.map((r) => r.name + r.title).join();
  if (!changes(list, key)) return;
  const parts = report.table.flatMap((r) => {
    const [dt, dd] = [document.createElement("dt"), document.createElement("dd")];
    dt.replaceChildren(...subscripted(r.name));
    dd.replaceChildren(...subscripted(r.title));
    return [dt, dd];
  });
  list.replaceChildren(...parts);
}
