// The controls: a slider and a text field for every number.
import { make, setAttribute, setText, Sheet } from "../support/dom";
import { digits, parse, sub, withUnit } from "../support/format";
import {
  clampTo,
  constants,
  constantsOf,
  densityFor,
  hasOwn,
  laws,
  massOf,
  MOST_BALLS,
  ranges,
  restitutionOf,
  setBallCount,
  setOwn,
  settle,
  type Range,
  type Scenario,
} from "../scenario/scenario";
import { ballById, measuredBalls, measuredLike, typical } from "../scenario/measured";
import { capital, labelOf, parameterOfColumn } from "../scenario/tables";
import { fromSlider, steps, toSlider } from "../scenario/slider";
import { touchable } from "../support/touch";

interface Control {
  element: HTMLElement;
  refresh(): void;
}

// Where a number is in a scenario: its owner and the key.
type Place = (s: Scenario) => [owner: object, key: string | number];

// The mass of a ball, of which a scenario has the density.
class Mass {
  constructor(private readonly ball: Scenario["balls"][number]) {}
  get mass(): number {
    return massOf(this.ball);
  }
  set mass(x: number) {
    this.ball.density = densityFor(x, this.ball.radius);
  }
}

// Sliders and fields are created at the first use. They are reused when the law or the number of balls changes, because
// creating those of six balls takes longer than a frame.
export class Controls {
  private scenario: Scenario;
  private list: Control[] = []; // controls that are shown
  private readonly controls = new Map<string, Control>(); // by id and label
  private shape = "";
  private edits = 0; // number of changes
  private written = -Infinity; // when the values were written [ms]
  private readonly about = make("p", { className: "about" }); // text about the example
  private readonly correction = make("p", { className: "correction", role: "alert" }); // how an entry was corrected

  constructor(
    private readonly box: HTMLElement,
    scenario: Scenario,
    private readonly changed: () => void,
  ) {
    this.scenario = scenario;
  }

  // Returns whether other controls are shown than before. `fully`: values are written even if they were just written.
  set(scenario: Scenario, about: string, fully: boolean): boolean {
    if (scenario !== this.scenario) {
      this.correction.textContent = "";
      this.edits++;
    }
    this.scenario = scenario;
    setText(this.about, about);
    const shape = `${scenario.law} ${scenario.balls.length} ${scenario.cradle} ${hasOwn(scenario)}`;
    const changed = shape !== this.shape;
    if (changed) this.build();
    this.shape = shape;
    const now = performance.now();
    if (fully || changed || now - this.written >= Sheet.legible) {
      this.written = now;
      for (const control of this.list) control.refresh();
    }
    return changed;
  }

  // Corrections of other values are reported below the entry.
  private edit(change: (s: Scenario) => void, at: HTMLElement | null = null, notes: string[] = []): void {
    this.edits++;
    change(this.scenario);
    settle(this.scenario, notes);
    this.correct(notes, at);
    this.changed();
  }

  private correct(notes: string[], at: HTMLElement | null): void {
    this.correction.textContent = notes.join("; ");
    if (notes.length > 0) (at ?? this.box.firstElementChild)?.after(this.correction);
  }

  private build(): void {
    const focused = document.activeElement?.id;
    const s = this.scenario;
    this.list = [];
    const parts: HTMLElement[] = [];
    const add = (c: Control): void => {
      this.list.push(c);
      parts.push(c.element);
    };
    const column = (name: string): string => labelOf(parameterOfColumn(name));
    add(this.number("restitution", labelOf(restitutionOf(s)), ranges.restitution, (q) => [q, "restitution"]));
    if (s.balls.length === 2) add(this.gap(1, column("gap")));
    if (!s.cradle) add(this.number("height", column("height"), ranges.height, (q) => [q, "height"]));
    add(
      this.once("law", () =>
        this.choice(
          "law",
          "Contact law",
          laws.map(({ name }) => [name, capital(name)]),
          () => this.scenario.law,
          (v) => this.edit((q) => (q.law = v)),
        ),
      ),
    );
    for (const name of constantsOf(s)) {
      const { label, range } = constants[name];
      add(this.number(name, hasOwn(s) ? `${label}, floor` : label, range, (q) => [q.constants, name]));
    }
    if (!s.cradle) {
      add(this.once("own", () => this.ownSwitch()));
      if (hasOwn(s))
        for (let pair = 1; pair < s.balls.length; pair++)
          for (const name of constantsOf(s)) {
            const { label, range } = constants[name];
            const title = `${label}, balls ${pair} and ${pair + 1}`;
            add(this.number(`${name}${pair}`, title, range, (q) => [q.own[name], pair - 1]));
          }
    }
    add(this.once("count", () => this.stepper()));
    for (let i = s.balls.length - 1; i >= 0; i--) {
      const n = s.balls.length;
      const [first, last] = s.cradle ? [", first", ", last"] : [", lowest", ", top"];
      const place = i === 0 ? first : i === n - 1 ? last : "";
      const title = make("h3", { textContent: `Ball ${i + 1}${place}`, id: `ball${i + 1}-title` });
      const group = make("div", { className: "ball", role: "group" });
      group.setAttribute("aria-labelledby", title.id);
      group.append(title);
      const inside = (c: Control): void => {
        this.list.push(c);
        group.append(c.element);
      };
      inside(this.once(`kind${i}`, () => this.kind(i)));
      const name = sub(i + 1);
      inside(this.number(`radius${i + 1}`, column("radius") + name, ranges.radius, (q) => [q.balls[i], "radius"]));
      inside(this.number(`mass${i + 1}`, column("mass") + name, ranges.mass, (q) => [new Mass(q.balls[i]), "mass"]));
      inside(this.density(i));
      if (i > 0 && n > 2) inside(this.gap(i, s.cradle ? `Gap to ball ${i}` : `Gap below, to ball ${i}`));
      if (s.cradle)
        inside(this.number(`velocity${i + 1}`, column("velocity"), ranges.velocity, (q) => [q.velocities, i]));
      parts.push(group);
    }
    this.box.replaceChildren(...parts, this.about);
    if (focused) document.getElementById(focused)?.focus();
  }

  private once(key: string, make: () => Control): Control {
    const known = this.controls.get(key) ?? make();
    this.controls.set(key, known);
    return known;
  }

  // A ball of the list below, with the middle of what its rules allow. Its ε and stiffness belong to contacts.
  private kind(i: number): Control {
    const element = make("label", { className: "own" });
    const select = make("select", { id: `kind${i + 1}` });
    select.append(new Option("own values", ""), ...measuredBalls.map((b) => new Option(b.name, b.id)));
    element.append("Ball", select);
    select.addEventListener("change", () => {
      if (!select.value) return;
      const { name, by, restitution } = ballById(select.value);
      const { radius, mass } = typical(select.value);
      const [low, high] = restitution.map((e) => digits(e, 2));
      this.edit((s) => (s.balls[i] = { radius, density: densityFor(mass, radius) }), element, [
        `${name} (${by}): radius and mass in the middle of its rules; alone it has ε = ${low} to ${high}; ε and stiffness stay`,
      ]);
    });
    const refresh = (): void => void (select.value = measuredLike(this.scenario.balls[i])?.id ?? "");
    return { element, refresh };
  }

  private density(i: number): Control {
    return this.once(`density${i}`, () => {
      const element = make("p", { className: "aside" });
      const refresh = (): void =>
        setText(
          element,
          `Density ${withUnit(this.scenario.balls[i].density, "kg/m³")}: stays when R${sub(i + 1)} changes, so ` +
            `m${sub(i + 1)} follows`,
        );
      return { element, refresh };
    });
  }

  private gap(pair: number, label: string): Control {
    return this.number(`gap${pair}`, label, ranges.gap, (q) => [q.gaps, pair - 1]);
  }

  private number(id: string, label: string, r: Range, place: Place): Control {
    return this.once(`${id} ${label}`, () => this.makeNumber(id, label, r, place));
  }

  private makeNumber(id: string, label: string, r: Range, place: Place): Control {
    const get = (s: Scenario): number => {
      const [owner, key] = place(s);
      return owner[key as never];
    };
    const put = (s: Scenario, x: number): void => {
      const [owner, key] = place(s);
      Object.assign(owner, { [key]: x });
    };
    const element = make("div", { className: "control" });
    const name = make("label", { textContent: label, htmlFor: id });
    const ariaLabel = `${label}, value${r.unit ? ` with unit (${r.unit})` : ""}`;
    const field = make("input", { type: "text", id: `${id}-value`, ariaLabel });
    const slider = make("input", { type: "range", id, min: "0", max: String(steps(r)) });
    const textOf = (x: number): string => (r.zero && x === 0 ? "touching" : withUnit(x, r.unit, 4));
    let shown = NaN; // the value in the field
    let refused = -1; // number of changes when an entry was refused
    slider.addEventListener("input", () => this.edit((s) => put(s, fromSlider(r, Number(slider.value))), element));
    slider.addEventListener("change", () => refresh()); // when the slider is released
    field.addEventListener("change", () => {
      const x = /^\s*touching\s*$/i.test(field.value) && r.zero ? 0 : parse(field.value, r.unit);
      field.setAttribute("aria-invalid", String(!Number.isFinite(x)));
      if (!Number.isFinite(x)) {
        refused = this.edits;
        this.correct(
          [
            `${label}: “${field.value.slice(0, 20)}” is not a ${r.unit ? `value in ${r.unit}` : "number"}; ` +
              `${textOf(get(this.scenario))} stays`,
          ],
          element,
        );
        return;
      }
      const kept = clampTo(r, x);
      const range = `${r.zero ? 0 : withUnit(r.low, r.unit, 4)} … ${withUnit(r.high, r.unit, 4)}`;
      this.edit(
        (s) => put(s, kept),
        element,
        kept === x ? [] : [`${label}: ${withUnit(x, r.unit, 4)} is outside ${range}: ${textOf(kept)} used`],
      );
      refresh(); // a late result would take it for a new value, and overwrite what is being typed
    });
    field.addEventListener("focus", () => field.select());
    const cell = make("span");
    cell.append(field);
    element.append(name, cell, slider);
    touchable(slider);
    const refresh = (): void => {
      const x = get(this.scenario);
      const text = textOf(x);
      const at = String(toSlider(r, x));
      if (slider.value !== at) slider.value = at;
      setAttribute(slider, "aria-valuetext", text);
      // A late result does not overwrite text that is being typed, or a refused entry.
      const left = x === shown && (document.activeElement === field || refused === this.edits);
      shown = x;
      if (left) return;
      if (field.value !== text) field.value = text;
      field.removeAttribute("aria-invalid");
    };
    return { element, refresh };
  }

  private choice(
    id: string,
    title: string,
    options: [string, string][],
    get: () => string,
    put: (v: string) => void,
  ): Control {
    const element = make("fieldset", { className: "choice" });
    element.append(make("legend", { textContent: title }));
    const inputs = options.map(([value, text]) => {
      const label = make("label");
      const input = make("input", { type: "radio", name: id, id: `${id}-${value}`, value });
      input.addEventListener("change", () => input.checked && put(value));
      label.append(input, text);
      element.append(label);
      return input;
    });
    const refresh = (): void => inputs.forEach((input) => (input.checked = input.value === get()));
    return { element, refresh };
  }

  private ownSwitch(): Control {
    const element = make("label", { className: "own" });
    const input = make("input", { type: "checkbox", id: "own" });
    input.addEventListener("change", () => this.edit((s) => setOwn(s, input.checked)));
    element.append(input, "Ball–ball contacts differ from the floor’s");
    return { element, refresh: () => void (input.checked = hasOwn(this.scenario)) };
  }

  private stepper(): Control {
    const element = make("div", { className: "control count" });
    const name = make("span", { id: "count-label", textContent: "Number of balls" });
    const group = make("div", { className: "stepper", role: "group" });
    group.setAttribute("aria-labelledby", name.id);
    const value = make("output", { id: "count" });
    const button = (textContent: string, ariaLabel: string, id: string, by: number): HTMLButtonElement => {
      const b = make("button", { type: "button", id, textContent, ariaLabel });
      b.addEventListener("click", () =>
        this.edit((s) => setBallCount(s, Math.min(Math.max(s.balls.length + by, 2), MOST_BALLS))),
      );
      return b;
    };
    const less = button("−", "One ball less", "count-less", -1);
    const more = button("+", "One ball more", "count-more", 1);
    group.append(less, value, more);
    element.append(name, group);
    const refresh = (): void => {
      const n = this.scenario.balls.length;
      setText(value, String(n));
      less.setAttribute("aria-disabled", String(n <= 2));
      more.setAttribute("aria-disabled", String(n >= MOST_BALLS));
    };
    return { element, refresh };
  }
}
