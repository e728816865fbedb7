// Compares setting A with the present setting B: both films at the same instant, the differences, the results.
import { find, refocus, setHidden, setText, type Sheet } from "../support/dom";
import { dropOf, type Drop } from "../core/drop";
import { digits, lengths, withUnit } from "../support/format";
import type { StoryView } from "../scenario/story_view";
import type { Pool } from "../core/pool";
import { constantAt, constants, constantsOf, copyOf, massOf, type Scenario } from "../scenario/scenario";
import { drawTrueScale } from "./true_scale";
import { observed, type Drawing } from "../state/signals";
import type { State } from "../state/state";
import { labelOf, namesOf, parameterOfColumn } from "../scenario/tables";

type Row = [string, string, string];

// The parameters in which two settings differ.
export function differences(a: Scenario, b: Scenario): Row[] {
  const rows: Row[] = [];
  const row = (name: string, x: string, y: string): void => void (x !== y && rows.push([name, x, y]));
  const gap = (x: number | undefined): string => (x === undefined ? "–" : x === 0 ? "touching" : withUnit(x, "m", 4));
  row("law", a.law, b.law);
  row("set-up", a.cradle ? "cradle" : "drop", b.cradle ? "cradle" : "drop");
  row("balls", String(a.balls.length), String(b.balls.length));
  row("ε", digits(a.restitution, 4), digits(b.restitution, 4));
  if (!a.cradle || !b.cradle)
    row("height of the lowest centre", withUnit(a.height, "m", 4), withUnit(b.height, "m", 4));
  for (let i = 0; i < Math.max(a.gaps.length, b.gaps.length); i++)
    row(
      a.balls.length === 2 && b.balls.length === 2 ? labelOf(parameterOfColumn("gap")) : `gap ${i + 1}–${i + 2}`,
      gap(a.gaps[i]),
      gap(b.gaps[i]),
    );
  for (const name of new Set([...constantsOf(a), ...constantsOf(b)])) {
    const text = (s: Scenario): string =>
      constantsOf(s).includes(name)
        ? [...new Set(s.balls.map((_, i) => withUnit(constantAt(s, name, i), constants[name].range.unit, 4)))].join(
            ", ",
          )
        : "–";
    row(constants[name].label, text(a), text(b));
  }
  for (let i = 0; i < Math.max(a.balls.length, b.balls.length); i++) {
    const text = (s: Scenario, f: (k: number) => string): string => (i < s.balls.length ? f(i) : "–");
    row(
      `radius of ball ${i + 1}`,
      text(a, (k) => withUnit(a.balls[k].radius, "m", 4)),
      text(b, (k) => withUnit(b.balls[k].radius, "m", 4)),
    );
    row(
      `mass of ball ${i + 1}`,
      text(a, (k) => withUnit(massOf(a.balls[k]), "kg", 4)),
      text(b, (k) => withUnit(massOf(b.balls[k]), "kg", 4)),
    );
    if (a.cradle || b.cradle)
      row(
        `velocity of ball ${i + 1}`,
        text(a, (k) => withUnit(a.velocities[k], "m/s")),
        text(b, (k) => withUnit(b.velocities[k], "m/s")),
      );
  }
  return rows;
}

// Results of both models, Newton first.
function results(a: Drop, b: Drop): { name: string; model: "newton" | "icm"; values: [string, string] }[] {
  const top = (d: Drop): number => d.scenario.balls.length - 1;
  const models = ["newton", "icm"] as const;
  if (a.scenario.cradle || b.scenario.cradle)
    return models.map((model) => ({
      name: `Last ball leaves with, ${namesOf[model].short}`,
      model,
      values: [a, b].map((d) => withUnit(d[model].leaves[top(d)], "m/s", 3, true)) as [string, string],
    }));
  const rises = models.map((model) => ({
    name: `Top ball rises to, ${namesOf[model].short}`,
    model,
    values: lengths(a[model].peaks[top(a)], b[model].peaks[top(b)]),
  }));
  const counts = models.map((model) => ({
    name: `Ball–ball contacts, ${namesOf[model].short}`,
    model,
    values: [String(a[model].run.nContacts), String(b[model].run.nContacts)] as [string, string],
  }));
  return [...rises, ...counts];
}

export class Compare {
  private drop: Drop | null = null; // of setting A
  readonly picture: Drawing;
  private fault = "";
  private key = "";

  constructor(
    private readonly state: State,
    private readonly view: StoryView,
    private readonly sheet: Sheet,
    private readonly pool: Pool,
    private readonly changed: () => void,
  ) {
    observed(this, ["drop"]);
    this.picture = state.drawing(() => this.draw());
    find("pin").addEventListener("click", () => this.set(view.pin ? null : copyOf(state.scenario)));
    find("unpin").addEventListener("click", () => {
      this.set(null);
      refocus();
    });
    find("swap").addEventListener("click", () => this.swap());
  }

  set(pin: Scenario | null): void {
    this.view.pin = pin;
    this.state.writeLink();
    this.changed();
  }

  private swap(): void {
    const { pin } = this.view;
    if (!pin) return;
    this.view.pin = copyOf(this.state.scenario);
    this.state.scenario = copyOf(pin);
    this.state.edited();
    this.changed();
  }

  // After any change of either setting.
  refresh(): void {
    const { pin } = this.view;
    find("pin").setAttribute("aria-pressed", String(pin !== null));
    setHidden(find("compare"), pin === null);
    document.documentElement.toggleAttribute("data-pinned", pin !== null);
    setText(
      find("compare-state"),
      pin
        ? "A is pinned, B is the present setting."
        : "No setting is pinned as A. “Pin as A” is in the menu of the laboratory.",
    );
    const key = pin ? JSON.stringify(pin) : "";
    if (key !== this.key) {
      this.key = key;
      this.drop = null;
      this.fault = "";
      if (pin) void this.solve(pin, key);
    }
    this.fillTable();
  }

  private async solve(pin: Scenario, key: string): Promise<void> {
    const solved = await this.pool.ask("solve", { scenario: copyOf(pin), tolerance: this.state.view.tolerance });
    if (key !== this.key) return;
    if ("reason" in solved) this.fault = solved.reason;
    else this.drop = dropOf(solved);
    this.fillTable();
  }

  private fillTable(): void {
    const { pin } = this.view;
    const b = this.state.drop;
    if (!pin || !b) return;
    const body = find("compare-table").querySelector("tbody")!;
    const rows: HTMLTableRowElement[] = [];
    const add = (name: string, values: string[], kind: string): void => {
      const tr = document.createElement("tr");
      const th = document.createElement("th");
      th.scope = "row";
      th.textContent = name;
      tr.append(
        th,
        ...values.map((text) => Object.assign(document.createElement("td"), { textContent: text, className: kind })),
      );
      rows.push(tr);
    };
    const changed = differences(pin, b.scenario);
    if (changed.length === 0) add("Settings", ["the same", "the same"], "");
    for (const [name, x, y] of changed)
      add(
        name.replace(/^[a-z]/, (c) => c.toUpperCase()),
        [x, y],
        "",
      );
    if (this.drop) for (const r of results(this.drop, b)) add(r.name, r.values, r.model);
    else add("A", [this.fault || "computing …", ""], "");
    body.replaceChildren(...rows);
    find("compare").dataset.ready = String(this.drop !== null);
  }

  // Draws both settings at the time of the film.
  private draw(): void {
    const { sheet, state } = this;
    if (!this.view.pin || !state.drop || sheet.width < 40) return;
    const { g, width, height } = sheet;
    g.clearRect(0, 0, width, height);
    const time = state.time();
    const half = width / 2;
    const drops = [this.drop, state.drop];
    const tops = drops.map((d) => (d ? d.top : 0));
    drops.forEach((d, k) => {
      if (!d) return;
      const shared = d.scenario.cradle ? d : { ...d, top: Math.max(...tops) }; // the same scale for both
      const moment = { time, rate: 1, newton: d.motion.newton.at(time), icm: d.motion.icm.at(time) };
      drawTrueScale(
        g,
        { x: k * half + 4, y: 0, w: half - 12, h: height },
        shared,
        moment,
        state.theme,
        k === 0 ? "A" : "B",
      );
    });
  }
}
