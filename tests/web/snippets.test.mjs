// "Copy as Python" and "Copy as command": both run with hardlimit and give the numbers of the page.
// PYTHON: an interpreter that has hardlimit installed.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { delimiter, dirname, join } from "node:path";
import { test } from "node:test";
import { fromPython, load, random } from "./modules.mjs";
import { randomScenario } from "./scenarios.mjs";

const lib = await load("snippets", "presets");
const { core, copyOf, exactNumbers, hasOwn, presets, setOwn, solve, toCommand, toPython } = lib;
const python = process.env.PYTHON ?? "python3";

// Every third drop has contacts with constants of their own.
function settings(seed, count) {
  const next = random(seed);
  return Array.from({ length: count }, (_, i) => {
    const s = randomScenario(next, lib);
    if (i % 3 > 0 || s.cradle) return s;
    setOwn(s, true);
    for (const list of Object.values(s.own))
      list.forEach((x, j) => (list[j] = Number((x * (0.6 + 0.4 * next())).toPrecision(6))));
    return s;
  });
}

const close = (a, b, what) =>
  assert.ok(a === b || Math.abs(a - b) <= 1e-9 * Math.abs(b), `${what}: page ${a}, Python ${b}`);

function check(s, said, where) {
  const solved = solve(core, s);
  assert.ok(!("reason" in solved), where);
  const numbers = exactNumbers(solved);
  for (const model of ["newton", "icm"]) {
    assert.equal(numbers[`${model}_contacts`], said[model].contacts, `${where}: contacts of ${model}`);
    s.balls.forEach((_, i) =>
      close(
        numbers[`${model}_${s.cradle ? "velocity" : "rise"}_${i + 1}`],
        said[model].values[i],
        `${where}: ${model}, ball ${i + 1}`,
      ),
    );
  }
  if (said.answer) assert.equal(solved.comparison.answer, said.answer, where);
}

const program = `
import contextlib, io, json, math, shlex, sys, warnings
warnings.simplefilter("ignore")
from click.testing import CliRunner
from hardlimit.cli import main
def tidy(x): return None if x is None or math.isnan(x) else float(x)
for kind, text, cradle in json.load(sys.stdin):
    if kind == "python":
        names = {}
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(text, names)
        result = names["result"]
        values = {m: r.final_velocities if cradle else r.rebound_heights
                  for m, r in (("newton", result.newton), ("icm", result.independent))}
        contacts = {"newton": int(result.newton.n_contacts), "icm": int(result.independent.n_contacts)}
        assert result.verdict.sentence in printed.getvalue()
        answer = result.verdict.answer
    else:
        words = shlex.split(text)
        assert words.pop(0) == "hardlimit"
        told = CliRunner().invoke(main, [*words, "--json"], catch_exceptions=False)
        assert told.exit_code == 0, told.output
        models = json.loads(told.stdout)["models"]
        pairs = (("newton", models["newton"]), ("icm", models["independent"]))
        values = {m: r["rebound_heights"] for m, r in pairs}
        contacts = {m: r["n_contacts"] for m, r in pairs}
        answer = None
    print(json.dumps({**{m: {"contacts": contacts[m], "values": [tidy(x) for x in values[m]]} for m in values},
                      "answer": answer}), flush=True)
`;

test("60 random settings and all examples as Python", async () => {
  const all = [...presets.map((p) => p.scenario), ...settings(441, 60)];
  const said = await fromPython(
    program,
    all.map((s) => ["python", toPython(s), s.cradle]),
  );
  all.forEach((s, i) => check(s, said[i], toPython(s)));
});

test("40 random settings as options of the command", async () => {
  const all = settings(442, 70)
    .filter((s) => !s.cradle && !hasOwn(s))
    .slice(0, 40);
  const said = await fromPython(
    program,
    all.map((s) => ["command", toCommand(s), false]),
  );
  all.forEach((s, i) => check(s, said[i], toCommand(s)));
});

test("contacts of their own and a cradle as commands of a terminal", () => {
  const folder = mkdtempSync(join(tmpdir(), "command-"));
  const PATH = `${dirname(python)}${delimiter}${process.env.PATH}`;
  for (const id of ["basketball", "cradle", "fig7"]) {
    const s = presets.find((p) => p.id === id).scenario;
    const command = toCommand(s).trimEnd() + " --json";
    const { models } = JSON.parse(execFileSync("sh", ["-c", command], { cwd: folder, env: { ...process.env, PATH } }));
    const key = s.cradle ? "velocities" : "rebound_heights"; // without gravity those at the end are the last ones
    const of = ({ n_contacts: contacts, [key]: values }) => ({ contacts, values });
    check(s, { newton: of(models.newton), icm: of(models.independent) }, id);
  }
  rmSync(folder, { recursive: true });
});

test("the program names the tolerance of its verdict, if the page has another", () => {
  const s = copyOf(presets[0].scenario);
  assert.doesNotMatch(toPython(s), /#/);
  assert.match(toPython(s, 0.05), /# This verdict is for 1 %, not 5 %\.\n/);
});
