// The balls with their sources, as a table.
import { find } from "./dom";
import { digits, withUnit } from "./format";
import { experiments, measuredBalls, middle, stiffnessFor, type MeasuredBall } from "./measured";

const span = ([low, high]: [number, number], say: (x: number) => string): string => (say(low) === say(high) ? say(low) : `${say(low)} to ${say(high)}`);

function cells(b: MeasuredBall): string[] {
  const mass = middle(b.mass);
  const stiffness = b.contact ? withUnit(stiffnessFor(mass, b.contact.time, middle(b.restitution)), "N/m", 2) : "–";
  return [
    span(b.mass, (x) => withUnit(x, "kg")),
    span(b.diameter, (x) => withUnit(x, "m")),
    `${span(b.restitution, (x) => digits(x, 2))}: ${b.bounce}`,
    b.contact ? `${withUnit(b.contact.time, "s", 2)}: ${b.contact.how}` : "not given by the rules",
    stiffness,
    b.source,
  ];
}

export function fillMeasured(): void {
  const rows = measuredBalls.map((b) => {
    const tr = document.createElement("tr");
    const th = document.createElement("th");
    th.scope = "row";
    th.textContent = b.name;
    tr.append(th, ...cells(b).map((textContent) => Object.assign(document.createElement("td"), { textContent })));
    return tr;
  });
  find("balls-table").querySelector("tbody")!.replaceChildren(...rows);
  find("experiments").replaceChildren(...experiments.map((textContent) => Object.assign(document.createElement("li"), { textContent })));
}
