// The balls with their numbers and sources, one block each.
import { find } from "../support/dom";
import { digits, withUnit } from "../support/format";
import { experiments, measuredBalls, middle, stiffnessFor, type MeasuredBall } from "../scenario/measured";

const span = ([low, high]: [number, number], show: (x: number) => string): string =>
  show(low) === show(high) ? show(low) : `${show(low)} to ${show(high)}`;

function facts(b: MeasuredBall): [string, string][] {
  const list: [string, string][] = [
    ["Mass", span(b.mass, (x) => withUnit(x, "kg"))],
    ["Diameter", span(b.diameter, (x) => withUnit(x, "m"))],
    ["Restitution", `${span(b.restitution, (x) => digits(x, 2))} (${b.bounce})`],
  ];
  if (b.contact) {
    const stiffness = stiffnessFor(middle(b.mass), b.contact.time, middle(b.restitution));
    list.push(
      ["Contact with the floor", `about ${withUnit(b.contact.time, "s", 2)} (${b.contact.how})`],
      ["Stiffness", `about ${withUnit(stiffness, "N/m", 2)}`],
    );
  }
  list.push(["Source", b.source]);
  return list;
}

export function fillMeasured(): void {
  const blocks = measuredBalls.map((b) => {
    const block = document.createElement("div");
    const name = Object.assign(document.createElement("h3"), { textContent: b.name });
    const list = document.createElement("dl");
    for (const [term, text] of facts(b)) {
      const row = document.createElement("div");
      row.append(
        Object.assign(document.createElement("dt"), { textContent: term }),
        Object.assign(document.createElement("dd"), { textContent: text }),
      );
      list.append(row);
    }
    block.append(name, list);
    return block;
  });
  find("balls").replaceChildren(...blocks);
  find("experiments").replaceChildren(
    ...experiments.map((textContent) => Object.assign(document.createElement("li"), { textContent })),
  );
}
