// The table of results, the energy bars and the sentence on top.
import type { State } from "../core/core";
import type { Solved, Track } from "../core/drop";
import { digits, lengths, withUnit } from "../support/format";
import { capital, independent, namesOf } from "../core/tables";
import { SHALLOW } from "../story/why";

interface Row {
  name: string;
  title: string;
  values: [string, string];
  lead?: boolean;
  id: string;
}

const rebound =
  "greatest height of its centre above the floor after its first bounce. The next floor contact of the lowest ball counts no more; collisions still to come between the balls do";

// Greatest height of a ball in the film if above its rebound height, else null.
export const laterHeight = (t: Track, i: number): number | null => (t.later[i] > t.peaks[i] * (1 + 1e-6) ? t.later[i] : null);

function rows(d: Solved): Row[] {
  const { newton, icm, scenario } = d;
  const n = scenario.balls.length;
  const both = (f: (t: Track) => string): [string, string] => [f(newton), f(icm)];
  const list: Row[] = [];
  const row = (id: string, name: string, title: string, values: [string, string], lead = false): void =>
    void list.push({ id, name, title, values, lead });
  row("contacts", "Ball–ball contacts", "contacts of the sequence", both((t) => String(t.run.nContacts)), true);
  const v = (t: Track, i: number): string => withUnit(t.final.velocity[i], "m/s", 3, true);
  if (scenario.cradle) {
    for (let i = n - 1; i >= 0; i--) row(`v${i}`, `Ball ${i + 1} leaves with`, "velocity after the last contact", both((t) => v(t, i)), i === n - 1);
    return list;
  }
  row("top", "Top ball rises to", rebound, lengths(newton.peaks[n - 1], icm.peaks[n - 1]), true);
  const later = [newton, icm].map((t) => laterHeight(t, n - 1));
  if (later.some((z) => z !== null))
    row("later", "… and later to", "after the lowest ball has met the floor again, while the film runs", lengths(later[0] ?? NaN, later[1] ?? NaN));
  row("low", "Lowest ball rises to", "the same for the lowest ball", lengths(newton.peaks[0], icm.peaks[0]));
  if (n > 2) {
    row("vtop", "Top ball leaves with", "velocity when the sequence is over; – if it still falls then", both((t) => (t.final.velocity[n - 1] > 0 ? v(t, n - 1) : "–")));
    return list;
  }
  row("vr", "Relative velocity v′_r", "upper minus lower velocity when the last contact of the sequence ends", both((t) => withUnit(t.run.relativeVelocity, "m/s", 3, true)));
  row("vs", "Separation velocity", "the same once no force acts", both((t) => withUnit(t.run.separationVelocity, "m/s", 3, true)));
  row("eff", "ε_eff", `restitution that would give v′ᵣ with ${independent.label}`, both((t) => digits(t.run.effective)));
  row("ratio", "ε_eff/ε", `1: ${independent.label} are right`, both((t) => digits(t.run.effective / scenario.restitution)));
  row("sep", "ε_eff/ε at separation", "the same from the separation velocity", both((t) => digits(t.run.effectiveSeparation / scenario.restitution)));
  row("floor", "Floor contact lasts", "first contact of the lowest ball with the floor", [withUnit(newton.run.tFloorEnd, "s"), "0 s"]);
  return list;
}

// "ε_eff" with a real subscript.
export function subscripted(text: string): (string | HTMLElement)[] {
  return text.split(/(_\w+)/).map((part) => {
    if (!part.startsWith("_")) return part;
    const sub = document.createElement("sub");
    sub.textContent = part.slice(1);
    return sub;
  });
}

// The numbers in full precision, for tests and the CSV file.
export function exactNumbers(d: Solved): Record<string, number | null> {
  const out: Record<string, number | null> = {};
  const put = (name: string, x: number): void => void (out[name] = Number.isFinite(x) ? x : null);
  for (const [model, t] of [["newton", d.newton], ["icm", d.icm]] as const) {
    put(`${model}_contacts`, t.run.nContacts);
    put(`${model}_t_end`, t.run.tEnd);
    put(`${model}_t_floor_end`, t.run.tFloorEnd);
    put(`${model}_relative_velocity`, t.run.relativeVelocity);
    put(`${model}_separation_velocity`, t.run.separationVelocity);
    put(`${model}_effective_restitution`, t.run.effective);
    t.peaks.forEach((z, i) => put(`${model}_rise_${i + 1}`, z));
    t.final.velocity.forEach((v, i) => put(`${model}_velocity_${i + 1}`, v));
  }
  return out;
}

export function fillTable(table: HTMLElement, d: Solved): void {
  const list = rows(d);
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

// Fractions of the initial energy: the balls from the top, then the dissipated energy.
function shares(t: Track): number[] {
  const s: State = t.final;
  const balls = Array.from(s.energy).reverse();
  const lost = t.initialEnergy - balls.reduce((a, b) => a + b, 0) - s.stored;
  return [...balls, Math.max(lost, 0)].map((e) => Math.max(e, 0) / t.initialEnergy);
}

const percent = (x: number): string => (x > 0 && x < 0.0005 ? "<0.1 %" : `${(100 * x).toFixed(1)} %`);

export function fillEnergy(box: HTMLElement, d: Solved): void {
  const n = d.scenario.balls.length;
  const names = [...d.scenario.balls.map((_, i) => ballName(n - 1 - i, d.scenario.cradle ? 0 : n)), "lost in contacts"];
  const colors = [...d.scenario.balls.map((_, i) => `var(--ball${n - i})`), "var(--lost)"];
  const tracks: [string, string, Track][] = [[namesOf.newton.short, "newton", d.newton], [namesOf.icm.short, "icm", d.icm]];
  const parts: HTMLElement[] = [];
  for (const [name, className, track] of tracks) {
    const title = document.createElement("div");
    title.className = `energy-name ${className}`;
    title.textContent = name;
    const bar = document.createElement("div");
    bar.className = "bar";
    bar.setAttribute("role", "img");
    const part = shares(track);
    bar.setAttribute("aria-label", `${name}: ${names.map((x, i) => `${x} ${percent(part[i])}`).join(", ")}`);
    part.forEach((share, i) => {
      const piece = document.createElement("div");
      piece.style.width = `${100 * share}%`;
      piece.style.background = colors[i];
      bar.append(piece);
    });
    parts.push(title, bar);
  }
  const legend = document.createElement("div");
  legend.className = "legend";
  const [a, b] = [shares(d.newton), shares(d.icm)];
  names.forEach((name, i) => {
    const swatch = document.createElement("i");
    swatch.style.background = colors[i];
    const label = document.createElement("span");
    label.textContent = name;
    const left = document.createElement("b");
    left.className = "newton";
    left.textContent = percent(a[i]);
    const right = document.createElement("b");
    right.className = "icm";
    right.textContent = percent(b[i]);
    legend.append(swatch, label, left, right);
  });
  box.replaceChildren(...parts, legend);
}

// n = 0: a cradle, which has neither top nor bottom.
export const ballName = (i: number, n: number): string =>
  n > 0 && i === n - 1 ? "top ball" : n > 0 && i === 0 ? "lowest ball" : `ball ${i + 1}`;

const words = ["no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve"];
const spell = (n: number): string => words[n] ?? String(n);
const ICM = capital(independent.label);

const contactsOf = (k: number): string => (k === 1 ? "one contact" : `${spell(k)} contacts`);

// One sentence on Newton's equations, one on independent collisions.
export function verdict(d: Solved): [string, string] {
  const { newton, icm, scenario } = d;
  const n = scenario.balls.length;
  const k = newton.run.nContacts;
  const deepest = newton.run.largestCompression;
  const stretched = deepest >= SHALLOW ? ` A contact is compressed by ${digits(100 * deepest, 2)} % of the smaller radius; contact laws are meant for less than 5 %.` : "";
  const contacts = capital(contactsOf(k));
  const unknown = newton.run.outcome !== 0 ? `${capital(newton.run.message)}.` : "";
  if (scenario.cradle) {
    const v = (t: Track): string => withUnit(t.final.velocity[n - 1], "m/s", 3, true);
    return [unknown || `${contacts}; the last ball leaves with ${v(newton)}.${stretched}`, `${ICM}: ${spell(icm.run.nContacts)}, and ${v(icm)}.`];
  }
  const [rise, risen] = lengths(newton.peaks[n - 1], icm.peaks[n - 1]);
  if (unknown) return [unknown, Number.isNaN(icm.peaks[n - 1]) ? "" : `${ICM}: ${spell(icm.run.nContacts)}, and up to ${risen}.`];
  const ratio = newton.run.effective / scenario.restitution;
  const where = (Number.isNaN(newton.peaks[n - 1]) ? `${contacts}; the top ball does not bounce before the floor is met again.` : `${contacts}, and the top ball rises to ${rise}.`) + stretched;
  if (Number.isNaN(icm.peaks[n - 1])) return [where, `${ICM}: ${icm.run.outcome !== 0 ? icm.run.message : "the top ball is not met"}.`];
  if (n === 2 && k === 1 && Math.abs(ratio - 1) < 0.01) return [where, `${ICM} say ${rise === risen ? "the same" : "nearly the same"}: ${risen}.`];
  const times = icm.peaks[n - 1] / newton.peaks[n - 1];
  const factor = times > 1.15 ? `, ${digits(times, 2)} times as high` : "";
  return [where, `${ICM}: ${spell(icm.run.nContacts)}, and up to ${risen}${factor}.`];
}

// Definitions of the names shown in the table.
export function fillDefinitions(list: HTMLElement, d: Solved): void {
  const parts = rows(d).flatMap((r) => {
    const [dt, dd] = [document.createElement("dt"), document.createElement("dd")];
    dt.replaceChildren(...subscripted(r.name));
    dd.replaceChildren(...subscripted(r.title));
    return [dt, dd];
  });
  list.replaceChildren(...parts);
}
