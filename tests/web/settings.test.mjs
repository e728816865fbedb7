// 300 random settings: nothing throws, the numbers are Python's, and the film includes all contacts of both models.
// PYTHON: an interpreter that has hardlimit installed.
import assert from "node:assert/strict";
import { test } from "node:test";
import { fromPython, load, random, randomLink } from "./modules.mjs";

const count = 300;
const { core, solve, dropOf, exactNumbers, fromQuery, toQuery, toToml, paper, trajectoryCsv, reportOf } =
  await load("report");

function settings() {
  const next = random(20260);
  return Array.from({ length: count }, () => {
    const q = randomLink(next);
    const scenario = paper();
    fromQuery(scenario, q, []);
    return { link: q.toString(), scenario };
  });
}

const program = `
import json, math, sys, tempfile, tomllib
from pathlib import Path
import hardlimit as hl
from hardlimit.column.files import read
def tidy(x): return None if math.isnan(x) else float(x)
path = Path(tempfile.mkdtemp()) / "column.toml"
for text in json.load(sys.stdin):
    path.write_text(text)
    column = read(str(path))
    out = {}
    for name, solver in (("newton", hl.newton), ("icm", hl.independent)):
        r = solver(column)
        out[name] = {"outcome": r.outcome_code, "contacts": int(r.n_contacts), "t_end": tidy(r.t_end),
                     "relative_velocity": tidy(r.relative_velocity), "separation_velocity": tidy(r.separation_velocity),
                     "rises": [tidy(z) for z in r.rebound_heights]}
    print(json.dumps(out), flush=True)
`;
function checkNumbers(numbers, said, n, where) {
  for (const model of ["newton", "icm"]) {
    const of = (key) => numbers[`${model}_${key}`];
    assert.equal(of("contacts"), said[model].contacts, `${where}: contacts`);
    for (const key of n === 2 ? ["t_end", "relative_velocity", "separation_velocity"] : ["t_end"])
      assert.equal(of(key), said[model][key], `${where}: ${model} ${key}`);
    said[model].rises.forEach((z, i) =>
      assert.equal(of(`rise_${i + 1}`), z, `${where}: ${model} rise of ball ${i + 1}`),
    );
  }
}

const unresolved = 5;

function checkFilm(d, where) {
  for (const [name, t] of [
    ["newton", d.newton],
    ["icm", d.icm],
  ]) {
    assert.ok(d.stop >= t.run.last, `${where}: the film ends before the sequence of ${name}`);
    if (t.run.outcome !== unresolved) assert.ok(t.known >= t.run.last);
    for (const c of t.run.contacts) {
      if (c.begin > t.run.last) continue;
      const screen = d.clock.toScreen(c.begin);
      assert.ok(screen >= 0 && screen <= d.clock.length);
      assert.ok(
        Math.abs(d.clock.toPhysical(screen) - c.begin) < 1e-9 * (d.stop - d.start) + 1e-6 * d.clock.rate(c.begin),
        `${where}: the film at a contact`,
      );
    }
    const contacts = t.run.contacts.filter((_, i) => i < 200);
    for (const time of [d.start, ...contacts.map((c) => c.begin), t.known]) {
      const s = d.motion[name].at(time);
      assert.ok([...s.position, ...s.gap].every(Number.isFinite), `${where}: ${name} at ${time}`);
    }
    const last = t.samples.times[t.samples.times.length - 1];
    assert.ok(
      last >= Math.min(t.known, d.stop) - 1e-12,
      `${where}: ${name} is known to ${t.known}, sampled to ${last}`,
    );
  }
}

test(`${count} random settings`, async (t) => {
  const all = settings();
  const answers = fromPython(
    program,
    all.map(({ scenario }) => toToml(scenario)),
  );
  let slowest = 0;
  let resolved = 0;
  const drops = all.map(({ scenario, link }) => {
    const where = `?${link}`;
    const again = paper();
    const q = new URLSearchParams();
    toQuery(scenario, q);
    fromQuery(again, q, []);
    assert.deepEqual(again, scenario, "a link keeps every digit");
    const begin = performance.now();
    const solved = solve(core, scenario);
    slowest = Math.max(slowest, performance.now() - begin);
    assert.ok(!("reason" in solved), where);
    const d = dropOf(solved);
    checkFilm(d, where);
    const { newton, icm } = reportOf(d, 0.01);
    assert.ok(
      [...newton, ...icm].every(({ text }) => !/NaN|undefined|Infinity/.test(text)),
      `${where}: ${JSON.stringify([newton, icm])}`,
    );
    return {
      where,
      numbers: exactNumbers(d),
      balls: scenario.balls.length,
      resolved: d.newton.run.outcome !== unresolved && d.icm.run.outcome !== unresolved,
    };
  });
  const python = await answers;
  for (const [i, { where, numbers, balls, resolved: here }] of drops.entries()) {
    if (!here || [python[i].newton, python[i].icm].some((r) => r.outcome === unresolved)) continue;
    resolved++;
    checkNumbers(numbers, python[i], balls, where);
  }
  t.diagnostic(`${resolved} of ${count} resolved by both; slowest ${slowest.toFixed(0)} ms`);
  assert.ok(resolved > 0.97 * count);
});

test("the file of the trajectories reaches the end of the film", () => {
  for (const { scenario } of settings().slice(0, 12)) {
    const d = solve(core, scenario);
    const lines = trajectoryCsv(core, scenario)
      .trim()
      .split("\n")
      .filter((line) => !line.startsWith("#"));
    const times = lines.slice(1).map((line) => Number(line.split(",")[0]));
    assert.ok(Math.abs(times[0] - d.start) < 1e-12 && Math.abs(times[times.length - 1] - d.stop) < 1e-9);
    for (const track of [d.newton, d.icm])
      for (const c of track.run.contacts.slice(0, 100)) assert.ok(times.includes(c.begin));
  }
});
