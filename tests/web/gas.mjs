// Comparison of the gas with Python: both engines from the same state to the same time, and the law of the error.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";

// Reads cases, runs them with hardlimit, and prints the differences and the expected sentences of each.
const program = String.raw`
import json, math, sys, warnings
import numpy as np
import hardlimit as hl
from hardlimit.boxes import theory
warnings.simplefilter("ignore", hl.CompressionWarning)

def in_order(table):
    return table[np.lexsort(table.T[::-1])]

def same(name, mine, theirs, faults):
    mine, theirs = np.asarray(mine, float), np.asarray(theirs, float)
    if mine.shape != theirs.shape or not np.array_equal(mine, theirs, equal_nan=True):
        faults.append(f"{name}: {mine.shape} {theirs.shape} {mine.ravel()[:3]} {theirs.ravel()[:3]}")

def near(name, mine, theirs, faults, rel=1e-12):
    if not (math.isclose(mine, theirs, rel_tol=rel, abs_tol=1e-300) or (math.isnan(mine) and math.isnan(theirs))):
        faults.append(f"{name}: {mine!r} {theirs!r}")

def predicted(law, tc_nu, tc, samples, bound):
    "Newton's energy by the law: the event-driven energies at times stretched by 1 + e, and later by half a contact."
    t = np.array([s["time"] for s in samples])
    y = np.array([s["energy"][0] for s in samples]) ** -0.5
    e = np.array([law.error(tc_nu / m) + bound * law.error_bar(tc_nu / m) for m in 0.5 * (y[1:] + y[:-1])])
    stretched = np.append(0.0, np.cumsum((1.0 + e) * np.diff(t)))
    at = t[-1] - (0.5 + 0.25 * bound) * tc
    if at <= 0.0:
        return 1.0
    k = min(max(int(np.searchsorted(stretched, at)), 1), len(t) - 1)
    return (y[k - 1] + (y[k] - y[k - 1]) / (stretched[k] - stretched[k - 1]) * (at - stretched[k - 1])) ** -2

def divergence(samples):
    "E-folds of the worlds' distance per collision of each disk, where its logarithm is straight; None: nowhere."
    c, d = (np.array([np.nan if s[name] is None else s[name] for s in samples]) for name in ("collisions", "distance"))
    far = np.flatnonzero(d > 0.3)
    c, d = (x[: far[0]] if len(far) else x for x in (c, d))
    c, d = c[d > 0.0], np.log(d[d > 0.0])
    for part in range(5):
        x, y = (z[part * len(c) // 8 :] for z in (c, d))
        if len(x) < 10:
            return None
        line = np.polynomial.Polynomial.fit(x, y, 1)
        begin, end = (float(line(z)) for z in (x[0], x[-1]))
        if 1.0 - np.var(y - line(x)) / np.var(y) >= 0.98 and end - begin >= 2.0:
            return dict(rate=(end - begin) / float(x[-1] - x[0]), **{"from": float(x[0])}, to=float(x[-1]), near=math.exp(begin), far=math.exp(end))
    return None

def compare(case):
    faults, i, s = [], case["input"], case["setting"]
    n = i["number"]
    start = [np.array(case["start"][name]).reshape(n, 2) for name in ("positions", "velocities")]
    system = hl.ParticleSystem(
        *start, i["radius"], mass=i["mass"], box=(i["edge"], i["edge"]),
        boundary="periodic" if i["periodic"] else "wall", gravity=(0.0, i["gravity"]),
    )
    near("packing fraction", system.packing_fraction, s["phi"], faults)
    linear = hl.LinearDashpot(stiffness=i["stiffness"], restitution=i["restitution"])
    tc = float(linear.between(*[hl.Ball(i["radius"], mass=i["mass"])] * 2).duration())
    temperature = 0.5 * 0.5**2
    gas = theory.Gas(n, i["radius"], i["mass"], i["edge"] ** 2, 2)
    rate = float(gas.collision_rate(temperature))
    said = case["law"]
    near("collision rate", rate, said["collisionRate"], faults)
    near("contact duration", tc, said["contactDuration"], faults)
    near("t_c ν", tc * rate, s["tcNu"], faults)
    law = hl.error_law(packing_fraction=s["phi"], restitution=s["restitution"], dimension=2, rule=s["rule"])
    for name, mine in (("coefficient", law.coefficient), ("coefficientError", law.coefficient_error), ("decay", law.decay)):
        near(name, mine, said["law"][name], faults, 1e-11)
    error, bar = law.error(s["tcNu"]), law.error_bar(s["tcNu"])
    near("error", error, said["error"], faults, 1e-9)
    near("error bar", bar, said["errorBar"], faults, 1e-9)
    near("trusted", law.largest_tc_nu(0.01), said["trusted"], faults, 1e-9)
    answer = {"outside": [word for word in ("packing", "restitution") if word in law.extrapolated]}
    answer["gas"] = i["periodic"] and s["gravity"] == 0
    answer["verdict"] = "differs" if abs(error) - bar > 0.01 else "agrees" if abs(error) + bar <= 0.01 else "open"
    try:
        newton = hl.molecular_dynamics(system, law=linear, until=case["time"], engine="events", samples=1, log=True)
    except ValueError as refusal:
        answer["refused"] = "must be stiffer" in str(refusal)
        return faults, answer
    rule = {"law": linear} if s["rule"] == "soft" else {"restitution": i["restitution"]}
    if s["rule"] == "tc":
        rule["contact_duration"] = i["contactDuration"]
    hard = hl.event_driven(system, **rule, rule=s["rule"], until=case["time"], samples=1, log=True)
    answer["outcomes"] = [hard.outcome_name, newton.outcome_name]
    both = (("event-driven", hard, case["hard"], case["worlds"][0]), ("Newton", newton, case["newton"], case["worlds"][1]))
    for name, run, observed, world in both:
        near(f"{name}: time", run.time, observed["time"], faults)
        contacts = run.n_contacts if run is newton else run.n_collisions
        same(f"{name}: contacts", contacts, observed["contacts"], faults)
        last = run.series.isel(time=-1)
        same(f"{name}: energies", [last.kinetic_energy, last.dissipated_energy], [observed["kinetic"], observed["dissipated"]], faults)
        same(f"{name}: velocities", run.system.velocities.ravel(), world["velocities"], faults)
        apart = (run.system.positions.ravel() - np.array(world["positions"])) / i["edge"]
        if i["periodic"]:
            apart -= np.round(apart)
        if np.abs(apart).max() > 1e-13:
            faults.append(f"{name}: positions differ by {np.abs(apart).max()} edges")
        table = np.array(world["log"], float).reshape(-1, 7)
        if run is hard:
            table = table[:, [0, 2, 3, 4, 5]]
        same(f"{name}: log", in_order(np.array(run.log, float).T), in_order(table), faults)
    if case["newton"]["ended"]:
        near("share", newton.overlapped_share, case["newton"]["overlapped"] / case["newton"]["ended"], faults)
    samples = case["samples"]
    answer["grows"] = divergence(samples)
    if answer["gas"] and len(samples) > 1 and hard.outcome_name == "ok":
        for k, bound in enumerate((0, -1, 1)):
            near(f"predicted {bound}", predicted(law, s["tcNu"], tc, samples, bound), samples[-1]["predicted"][k], faults, 1e-9)
    if hard.outcome_name == newton.outcome_name == "ok":
        one, other = (np.array(world["positions"]).reshape(n, 2) for world in case["worlds"])
        distance = math.sqrt(np.mean(np.sum((one - other) ** 2, axis=1))) / (2.0 * i["radius"])
        near("distance", distance, samples[-1]["distance"], faults, 1e-9)
    return faults, answer

for line in sys.stdin:
    print(json.dumps(compare(json.loads(line))), flush=True)
`;

export class Python {
  constructor() {
    this.process = spawn(process.env.PYTHON ?? "python3", ["-c", program], { stdio: ["pipe", "pipe", "inherit"] });
    this.waiting = [];
    let text = "";
    this.process.stdout.on("data", (data) => {
      text += data;
      for (let end = text.indexOf("\n"); end >= 0; end = text.indexOf("\n")) {
        this.waiting.shift().done(JSON.parse(text.slice(0, end)));
        text = text.slice(end + 1);
      }
    });
    this.process.on("exit", () => this.waiting.forEach(({ fail }) => fail(new Error("Python has ended"))));
  }
  // The differences, and Python's results for the setting.
  compare(report, { logs, states }) {
    const worlds = logs.map((log, i) => {
      const [log_, state] = [log, states[i]].map((x) => Array.from(x));
      const half = state.length / 2;
      return { log: log_, positions: state.slice(0, half), velocities: state.slice(half) };
    });
    const text = JSON.stringify({ ...report, worlds }, (_, x) =>
      typeof x === "number" && !Number.isFinite(x) ? null : x,
    );
    this.process.stdin.write(`${text}\n`);
    return new Promise((done, fail) => this.waiting.push({ done, fail }));
  }
  end() {
    this.process.stdin.end();
  }
}

// The statements of the page agree with Python.
export async function agrees(python, report, worlds) {
  const what = report.link;
  const [faults, answer] = await python.compare(report, worlds);
  assert.deepEqual(faults, [], what);
  const said = Object.fromEntries(report.sentences.map(({ topic, id }) => [topic, id]));
  if (answer.refused !== undefined) {
    assert.ok(answer.refused, what);
    return assert.deepEqual(said, { verdict: "too-soft" }, what);
  }
  const { setting, hard, newton, law } = report;
  const stopped = answer.outcomes[0] !== "ok";
  const verdict =
    answer.gas && stopped
      ? "stopped"
      : answer.outcomes[1] !== "ok"
        ? "newton-stopped"
        : setting.restitution === 1
          ? newton.ended === 0
            ? "elastic-begins"
            : newton.overlapped > 0.01 * newton.ended
              ? "elastic-differs"
              : "elastic-agrees"
          : !answer.gas
            ? "elsewhere"
            : answer.verdict;
  assert.equal(said.verdict, verdict, what);
  // The law makes no statement at ε = 1.
  assert.equal(said.range, setting.restitution < 1 ? answer.outside[0] : undefined, what);
  assert.equal(said.hard, stopped ? (answer.outcomes[0] === "collapse" ? "collapse" : "stopped") : undefined, what);
  assert.equal(said.newton, answer.outcomes[1] === "ok" ? undefined : "stopped", what);
  assert.equal(said.contacts, newton.ended > 0 ? "overlapping" : "none", what);
  assert.equal(said.distance, report.time === 0 ? undefined : answer.grows ? "grows" : "unknown", what);
  // The numbers in the sentences.
  for (const { topic, text, numbers } of report.sentences) {
    const has = (...shown) => shown.forEach((x) => assert.ok(text.includes(x), `${what}: ${text}: ${x}`));
    assert.ok(!/NaN|undefined|null|Infinity/.test(text), `${what}: ${text}`);
    if (topic === "verdict" && "error" in numbers)
      assert.deepEqual(
        [numbers.error, numbers.bar, numbers.trusted],
        [Math.abs(law.error), law.errorBar, law.trusted],
        what,
      );
    if (topic === "contacts" && newton.ended > 0) has(`(${newton.overlapped} of ${newton.ended})`);
    if (topic === "distance" && answer.grows)
      for (const [name, x] of Object.entries(answer.grows))
        assert.ok(
          Math.abs(numbers[name] / x - 1) < 1e-8 || numbers[name] === x,
          `${what}: ${name}: ${numbers[name]}, ${x}`,
        );
    if (topic === "hard") assert.equal(numbers.time, hard.time, what);
    if (topic === "measured") assert.deepEqual([numbers.hard, numbers.newton], report.samples.at(-1).energy, what);
  }
}
