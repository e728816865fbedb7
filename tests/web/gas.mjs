// Comparison of the gas with Python: both engines from the same state to the same time, and the law of the error.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";

// Reads cases, runs them with hardlimit, and prints the differences and the expected sentences of each.
const program = String.raw`
import json, math, sys, warnings
import numpy as np
import hardlimit as hl
from hardlimit.boxes import theory
from scipy import stats
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

def name_of(s, mu):
    return "law" if mu > 0 and s["rule"] == "constant" else s["rule"]

def law_of(s, friction):
    return hl.error_law(
        packing_fraction=s["phi"], restitution=s["restitution"], dimension=2, rule=name_of(s, s["friction"]),
        friction=friction, inertia_factor=0.5,
    )

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

def difference(values, reference):
    "Ratio of means less one, its standard error and the half-width of its 99 % interval."
    n, ratio = len(values), np.mean(values) / np.mean(reference)
    error = np.std((values - ratio * reference) / np.mean(reference), ddof=1) / math.sqrt(n)
    return float(ratio - 1.0), float(error), float(stats.t.ppf(0.995, n - 1) * error)

def measured(case, elastic):
    """What the starts say at their end: size and error of the difference, surplus of energy, and the verdict.

    The page's table of Student's t is right to 0.3 %; verdicts within this of their limit are left open (None).
    """
    starts, s = case["starts"], case["setting"]
    if len(starts) < 8:
        return {"verdict": "waiting"}
    energy = np.array([one["energy"] for one in starts], float)  # start, world, time
    contacts = np.array([one["contacts"] for one in starts], float)
    if elastic:
        of = contacts
    elif s["gravity"] > 0:
        of = 1.0 - energy
    else:
        of = energy**-0.5 - 1.0
    complete = [k for k in range(1, of.shape[2]) if np.isfinite(of[:, :, k]).all() and of[:, 1, k].mean() > 0.0]
    if not complete:
        return {"verdict": "waiting"}
    value, error, half = difference(of[:, 0, complete[-1]], of[:, 1, complete[-1]])
    share = np.array([one["share"] or 0.0 for one in starts], float)
    spread = stats.t.ppf(0.995, len(share) - 1) * share.std(ddof=1) / math.sqrt(len(share))
    def side(x, bar):
        if min(abs(abs(x) - f * bar - 0.01) for f in (-1, 1)) < 0.005 * bar:
            return None
        return "differs" if abs(x) - bar > 0.01 else "agrees" if abs(x) + bar <= 0.01 else "open"
    verdict = side(value, half)
    if elastic:
        both = {verdict, side(share.mean(), spread)}
        verdict = "differs" if "differs" in both else None if None in both else "agrees" if both == {"agrees"} else "open"
        verdict = verdict and "elastic-" + verdict
    elif s["gravity"] > 0 and verdict in ("agrees", "open"):
        verdict = "rests"
    said = {"verdict": verdict, "value": value, "error": error, "faster": value > 0.0, "share": float(share.mean())}
    if not elastic and complete[-1] == of.shape[2] - 1:
        said["surplus"], said["surplus_error"], _ = difference(energy[:, 1, -1], energy[:, 0, -1])
        said["energies"] = energy[:, :, -1].mean(axis=0).tolist()
    return said

def compare(case):
    faults, i, s = [], case["input"], case["setting"]
    n, mu = i["number"], s["friction"]
    start = [np.array(case["start"][name]).reshape(n, 2) for name in ("positions", "velocities")]
    rotation = {"angular_velocities": np.array(case["start"]["spins"]), "inertia_factor": 0.5} if mu > 0 else {}
    system = hl.ParticleSystem(
        *start, i["radius"], mass=i["mass"], box=(i["edge"], i["edge"]),
        boundary="periodic" if i["periodic"] else "wall", gravity=(0.0, i["gravity"]), **rotation,
    )
    near("packing fraction", system.packing_fraction, s["phi"], faults)
    friction = hl.Friction(mu, stiffness_ratio=s["stiffnessRatio"]) if mu > 0 else None
    linear = hl.LinearDashpot(stiffness=i["stiffness"], restitution=i["restitution"], friction=friction)
    tc = float(linear.between(*[hl.Ball(i["radius"], mass=i["mass"])] * 2).duration())
    temperature = 0.5 * 0.5**2
    gas = theory.Gas(n, i["radius"], i["mass"], i["edge"] ** 2, 2)
    rate = float(gas.collision_rate(temperature))
    said = case["law"]
    near("collision rate", rate, said["collisionRate"], faults)
    near("contact duration", tc, said["contactDuration"], faults)
    near("t_c ν", tc * rate, s["tcNu"], faults)
    answer = {"gas": i["periodic"] and s["gravity"] == 0, "outside": []}
    elastic = s["restitution"] == 1.0 and mu == 0.0
    try:
        law = law_of(s, friction)
    except ValueError:
        law = None
    if (law is not None) != said["known"]:
        faults.append(f"known: {law}, {said['known']}")
    if law is not None:
        # With friction the page has a table.
        exact = mu == 0.0
        for name, mine in (("coefficient", law.coefficient), ("coefficientError", law.coefficient_error), ("decay", law.decay)):
            if exact:
                near(name, mine, said["law"][name], faults, 1e-11)
            elif abs(mine - said["law"][name]) > 0.8 * law.coefficient_error:
                faults.append(f"{name}: {mine}, {said['law'][name]}, bar {law.coefficient_error}")
        error, bar = law.error(s["tcNu"]), law.error_bar(s["tcNu"])
        if exact:
            near("error", error, said["error"], faults, 1e-9)
            near("error bar", bar, said["errorBar"], faults, 1e-9)
            near("trusted", law.largest_tc_nu(0.01), said["trusted"], faults, 1e-9)
        answer["outside"] = [word for word in ("packing", "restitution") if word in law.extrapolated.split(" and ")[0]]
        answer["law"] = "differs" if abs(error) - bar > 0.01 else "agrees" if abs(error) + bar <= 0.01 else "open"
        if not exact and answer["law"] != ("differs" if abs(said["error"]) - said["errorBar"] > 0.01 else "agrees" if abs(said["error"]) + said["errorBar"] <= 0.01 else "open"):
            answer["law"] = None  # too close to call
        answer["frictionOutside"] = bool(law.extrapolated) and any(x in law.extrapolated for x in ("μ =", "k_t/k_n =", "ε ="))
    answer["elastic"] = elastic
    try:
        newton = hl.molecular_dynamics(system, law=linear, until=case["time"], engine="events", samples=1, log=True)
    except ValueError as refusal:
        answer["refused"] = "must be stiffer" in str(refusal)
        return faults, answer
    rule = {"law": linear} if s["rule"] == "soft" or mu > 0 else {"restitution": i["restitution"]}
    if s["rule"] == "tc":
        rule["contact_duration"] = i["contactDuration"]
    hard = hl.event_driven(system, **rule, rule=name_of(s, mu), until=case["time"], samples=1, log=True)
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
        if mu > 0:
            same(f"{name}: spins", np.ravel(run.system.angular_velocities), world["spins"], faults)
            same(f"{name}: energy of rotation", last.rotational_energy, observed["rotational"], faults)
        table = np.array(world["log"], float).reshape(-1, 7)
        if run is hard:
            table = table[:, [0, 2, 3, 4, 5]]
        log = np.array(run.log[: table.shape[1]], float).T  # without what friction adds
        same(f"{name}: log", in_order(log), in_order(table), faults)
    if case["newton"]["ended"]:
        near("share", newton.overlapped_share, case["newton"]["overlapped"] / case["newton"]["ended"], faults)
    samples = case["samples"]
    answer["grows"] = divergence(samples)
    answer["starts"] = measured(case, elastic)
    # The first of the starts is the film's.
    if case["starts"]:
        until, one = case["until"], case["starts"][0]
        runs = hl.event_driven(system, **rule, rule=name_of(s, mu), until=until, samples=1), hl.molecular_dynamics(
            system, law=linear, until=until, engine="events", samples=1
        )
        for k, run in enumerate(runs):
            if (run.outcome_name == "ok") != (one["outcomes"][k] == 0):
                faults.append(f"start: outcome {run.outcome_name}, {one['outcomes']}")
            if run.outcome_name != "ok":
                continue
            first, last = run.series.isel(time=0), run.series.isel(time=-1)
            whole = float(first.kinetic_energy + (first.rotational_energy if mu > 0 else 0.0))
            whole += i["mass"] * -i["gravity"] * float(np.sum(system.positions[:, 1]))
            near(f"start: energy {k}", 1.0 - float(last.dissipated_energy) / whole, one["energy"][k][-1], faults, 1e-11)
            same(f"start: contacts {k}", run.n_collisions if k == 0 else run.n_contacts, one["contacts"][k][-1], faults)
            if mu > 0:
                near(f"start: T_r/T {k}", 2.0 * float(last.rotational_energy / last.kinetic_energy), one["ratio"][k][-1], faults, 1e-11)
    if answer["gas"] and len(samples) > 1 and hard.outcome_name == "ok" and mu == 0:
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
      const half = 2 * report.setting.number;
      const [positions, velocities] = [state.slice(0, half), state.slice(half, 2 * half)];
      return { log: log_, positions, velocities, spins: state.slice(2 * half) };
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

const near = (mine, theirs, what) =>
  mine.forEach((x, i) =>
    assert.ok(Math.abs(x - theirs[i]) <= 1e-8 * Math.abs(theirs[i]) + 1e-12, `${what}: ${x}, ${theirs[i]}`),
  );

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
  const { setting, hard, newton, law, starts } = report;
  const failed = (world, film) => film || starts.some(({ outcomes }) => outcomes[world] !== 0);
  const stopped = answer.outcomes[0] !== "ok";
  const verdict = failed(1, answer.outcomes[1] !== "ok")
    ? "newton-stopped"
    : (stopped && answer.outcomes[0] !== "collapse") || starts.some(({ outcomes }) => ![0, 4].includes(outcomes[0]))
      ? "unfinished"
      : failed(0, stopped)
        ? "stopped"
        : answer.starts.verdict;
  if (verdict !== null) assert.equal(said.verdict, verdict, what);
  // The law is about cooling; with friction about the rule constant and restitutions of its table.
  const lawSays = answer.elastic
    ? "elastic"
    : !answer.gas
      ? "elsewhere"
      : law.known
        ? answer.law
        : setting.rule === "constant"
          ? "unknown"
          : "rule";
  if (lawSays !== null) assert.equal(said.law, lawSays, what);
  const range =
    answer.elastic || !law.known ? undefined : (answer.outside[0] ?? (answer.frictionOutside ? "friction" : undefined));
  assert.equal(said.range, range, what);
  assert.equal(said.hard, stopped ? (answer.outcomes[0] === "collapse" ? "collapse" : "stopped") : undefined, what);
  assert.equal(said.newton, answer.outcomes[1] === "ok" ? undefined : "stopped", what);
  assert.equal(said.contacts, newton.ended > 0 ? "overlapping" : "none", what);
  assert.equal(said.distance, report.time === 0 ? undefined : answer.grows ? "grows" : "unknown", what);
  // What a verdict says in words.
  const first = report.sentences.find(({ topic }) => topic === "verdict");
  const opening = {
    differs: /^No: /,
    agrees: /^Yes, to 1\s%: /,
    open: /^Cannot be said yet/,
    rests: /^Cannot be said: /,
  };
  const kind = first.id.replace("elastic-", "");
  assert.match(
    first.text,
    opening[kind] ?? { stopped: /^No: /, waiting: /^Cannot be said yet/ }[kind] ?? /^Cannot/,
    what,
  );
  if (kind in opening) {
    const { value, error, faster, share } = answer.starts;
    near([first.numbers.size, first.numbers.bar], [Math.abs(value), error], what);
    const words = answer.elastic ? ["too many", "too few"] : ["too fast", "too slowly"];
    assert.ok(
      first.text.includes(words[faster ? 0 : 1]) && !first.text.includes(words[faster ? 1 : 0]),
      `${what}: ${first.text}`,
    );
    if (answer.elastic) near([first.numbers.share], [share], what);
    assert.ok(first.text.includes(`of ${starts.length} starts`), `${what}: ${first.text}`);
  }
  const { surplus, surplus_error: surplusError, energies } = answer.starts;
  const stated = report.sentences.find(({ topic }) => topic === "mean");
  assert.equal(
    stated !== undefined,
    surplus !== undefined || (starts.length > 1 && starts.length < 8 && stated !== undefined),
    what,
  );
  if (stated && surplus !== undefined) {
    const { numbers } = stated;
    near(
      [numbers.surplus, numbers.bar, numbers.hard, numbers.newton],
      [Math.abs(surplus), surplusError, ...energies],
      what,
    );
    assert.ok(stated.text.includes(surplus > 0 ? " more (" : " less ("), `${what}: ${stated.text}`);
  }
  // The numbers in the sentences.
  for (const { topic, text, numbers } of report.sentences) {
    const has = (...shown) => shown.forEach((x) => assert.ok(text.includes(x), `${what}: ${text}: ${x}`));
    assert.ok(!/NaN|undefined|null|Infinity|–\s?%/.test(text), `${what}: ${text}`);
    if (topic === "law" && "error" in numbers) {
      assert.deepEqual(
        [numbers.error, numbers.bar, numbers.trusted],
        [Math.abs(law.error), law.errorBar, law.trusted],
        what,
      );
      has(law.error > 0 ? "too fast" : "too slowly");
    }
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
