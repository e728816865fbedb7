// The report of the page, over 300 random settings with ties and extremes: every number in it and the condition of
// every sentence is compared with Python. PYTHON: an interpreter that has hardlimit installed. SEED: that of the
// settings.
import assert from "node:assert/strict";
import { test } from "node:test";
import { fromPython, load, random } from "./modules.mjs";

const count = 300;
const seed = Number(process.env.SEED ?? 27);
const lib = await load("report", "presets", "rebound", "sentences", "story_view", "view");
const { core, solve, dropOf, reportOf, fromQuery, paper } = lib;

// ---- settings -----------------------------------------------------------------------------------------------

// Settings that once had wrong sentences.
const once = [
  "e=0.02&k=1000&h=0.13&r=0.1217,0.0335&rho=80.66,366.4&gap=0",
  "law=linear&e=0.76&k=42000,13000&h=1.1217&r=0.1217,0.0335&rho=80.66,366.4&gap=0",
  "law=linear&e=0.85&k=500000&h=0.5&r=0.027,0.019,0.0135,0.009&rho=946.1,939.7,950.9,949.7&gap=0,5e-5,5e-5",
];

function randomLink(next) {
  const log = (low, high) => Number((low * (high / low) ** next()).toPrecision(4));
  const n = 2 + Math.floor(4.3 * next() ** 2);
  const law = ["linear", "linear", "viscoelastic", "tsuji"][Math.floor(4 * next())];
  const list = (m, make) => Array.from({ length: m }, make).join();
  const extreme = next() < 0.15;
  const q = new URLSearchParams({
    law,
    e: next() < 0.1 ? "1" : next() < 0.1 ? "0.02" : (0.3 + 0.7 * next()).toFixed(3),
  });
  const each = (make) => (next() < 0.3 ? list(n, make) : make());
  if (law === "linear")
    q.set(
      "k",
      each(() => log(extreme ? 1e3 : 3e4, 1e8)),
    );
  if (law === "viscoelastic") {
    q.set(
      "Y",
      each(() => log(extreme ? 1e6 : 1e7, 1e11)),
    );
    q.set("nu", (0.49 * next()).toFixed(2));
    q.set("v", log(0.1, 10));
  }
  if (law === "tsuji")
    q.set(
      "K",
      each(() => log(1e7, 1e10)),
    );
  const common = [log(0.005, 0.1), log(300, 8000)];
  const alike = next() < 0.25;
  q.set(
    "r",
    list(n, () => (alike ? common[0] : log(0.005, 0.1))),
  );
  q.set(
    "rho",
    list(n, () => (alike ? common[1] : log(300, 8000))),
  );
  q.set(
    "gap",
    list(n - 1, () => (next() < 0.3 ? 0 : log(1e-7, 0.1))),
  );
  if (next() < 0.12) {
    q.set("setup", "cradle");
    q.set("u", [1, ...Array.from({ length: n - 1 }, () => (next() < 0.7 ? 0 : (next() - 0.7).toFixed(2)))].join());
  } else
    q.set("h", next() < 0.2 ? Number((1.002 * Number(q.get("r").split(",")[0]) + 1e-3).toPrecision(6)) : log(0.15, 2));
  return q;
}

// A basketball and a tennis ball, within their rules.
function knownBalls(next) {
  const from = (low, high) => Number((low + (high - low) * next()).toPrecision(4));
  const [radii, masses] = [
    [from(0.12, 0.1235), from(0.0328, 0.0342)],
    [from(0.57, 0.645), from(0.0562, 0.0592)],
  ];
  return new URLSearchParams({
    e: from(0.3, 1),
    k: next() < 0.5 ? from(1e4, 1e5) : `${from(1e4, 1e5)},${from(2e3, 1e5)}`,
    r: radii.join(),
    rho: masses.map((mass, i) => lib.densityFor(mass, radii[i])).join(),
    gap: next() < 0.5 ? 0 : 10 ** (-6 * next()),
    h: from(0.15, 2),
  });
}

function settings() {
  const next = random(seed);
  const known = random(seed + 1);
  const links = [
    ...once.map((text) => new URLSearchParams(text)),
    ...Array.from({ length: count - once.length }, () => randomLink(next)),
    ...Array.from({ length: 20 }, () => knownBalls(known)),
  ];
  return links.map((q) => {
    const scenario = paper();
    fromQuery(scenario, q, []);
    return { link: `?${q.toString().replaceAll("%2C", ",")}`, scenario };
  });
}

// ---- Python -------------------------------------------------------------------------------------------------

const program = `
import json, math, sys, tempfile, warnings
from pathlib import Path
import numpy as np
import hardlimit as hl
from hardlimit.column.files import read
warnings.simplefilter("ignore")
def tidy(x): return float(x) if math.isfinite(x) else None
path = Path(tempfile.mkdtemp()) / "column.toml"
def energies(r, column):
    """Shares of the energy at release: the balls, the contacts, what was dissipated."""
    core = r._core
    mass = np.array([b.mass for b in column.balls])
    z, v, t = core.t_first, core.t_last, r.trajectory(times=[core.t_first, core.t_last])
    gaps_zero = np.cumsum([2 * b.radius for b in column.balls]) - np.array([b.radius for b in column.balls])
    height = t.position.values - gaps_zero  # above the place where nothing is compressed
    g = column.gravity
    below = np.minimum(height[1], 0.0) if g else np.zeros(len(mass))
    ball = 0.5 * mass * t.velocity.values[1] ** 2 + mass * g * (height[1] - below)
    v0 = np.array(column.velocities)  # at release; a collision may follow at once
    release = column.initial_positions if column.floor else height[1] + gaps_zero
    whole = (0.5 * mass * v0**2 + mass * g * (release - gaps_zero - below)).sum()
    return [float(x) / whole for x in [*ball, float(t.contact_energy[1]), float(t.dissipated_energy[1])]]
def overlapping(r):
    """Number of contacts of balls that overlap another contact in time."""
    pair, begin, end = r.contact_times
    end = np.where(np.isnan(end), math.inf, end)
    return sum(bool(np.any((np.arange(len(pair)) != i) & (begin < end[i]) & (begin[i] < end)))
               for i in np.flatnonzero(pair)[: r.n_contacts])
def lone(column):
    """The lowest ball alone on the floor: its speeds before and after the contact, whose end is finite."""
    if not column.floor: return None
    alone = hl.Column([column.balls[0]], gaps=[], height=column.height, law=column.laws[0], gravity=column.gravity)
    r = hl.newton(alone)
    if not math.isfinite(r.t_floor_end): return None
    leaves = r.trajectory(times=[r.t_floor_end]).velocity.values[0][0]
    return {"arrives": alone.impact_speed, "leaves": float(leaves), "end": r.t_floor_end}
def meeting(r):
    """Velocity of the lowest ball as balls first touch."""
    pair, begin, _ = r.contact_times
    first = begin[pair > 0]
    return float(r.trajectory(times=[first.min()]).velocity.values[0][0]) if len(first) else None
def column_of(text):
    path.write_text(text)
    return read(str(path))
def variant(text):
    """The top ball's height and the verdict, at another gap."""
    column = column_of(text)
    return {"top": tidy(hl.newton(column).rebound_heights[-1]), "answer": hl.compare(column).verdict[0]}
for texts in json.load(sys.stdin):
    column = column_of(texts[0])
    out = {"variants": [variant(text) for text in texts[1:]]}
    for name, solver in (("newton", hl.newton), ("icm", hl.independent)):
        r = solver(column)
        pair, begin, end = r.contact_times
        last = r._core.t_last
        end_v = r.trajectory(times=[last]).velocity.values[0]
        out[name] = {"outcome": r.outcome, "contacts": int(r.n_contacts), "t_end": tidy(r.t_end), "t_floor_end": tidy(r.t_floor_end),
                     "relative_velocity": tidy(r.relative_velocity), "separation_velocity": tidy(r.separation_velocity),
                     "effective_restitution": tidy(r.effective_restitution),
                     "rises": [tidy(z) for z in r.rebound_heights], "velocities": [tidy(v) for v in r.final_velocities],
                     "compression": tidy(r.largest_compression), "last": last, "events": len(pair), "too_deep": r._core.too_deep,
                     "list": [[int(p), float(b), tidy(e)] for p, b, e in list(zip(pair, begin, end))[:3000] if b <= last],
                     "shares": energies(r, column)}
    c = hl.compare(column)
    out["answer"], out["sentence"] = c.verdict
    out["overlapping"] = overlapping(c.newton)
    out["lone"] = lone(column)
    out["meets"] = meeting(c.newton)
    out["restitution"] = column.contacts[0].restitution(getattr(column.laws[0], "impact_speed", 1.0))
    out["release"] = float(column.initial_positions[-1])
    print(json.dumps(out), flush=True)
`;
// ---- what a sentence claims ---------------------------------------------------------------------------------

const top = (m) => m.rises[m.rises.length - 1];
const leaves = (m) => m.velocities[m.velocities.length - 1];
const is = (m, text) => m.outcome.startsWith(text);

// The contacts of Newton's sequence, for the sentences that explain a result.
function contactsOf(py) {
  const list = py.newton.list.map(([pair, begin, end]) => ({ pair, begin, end: end ?? Infinity }));
  const between = list.filter((c) => c.pair > 0);
  const floor = list.find((c) => c.pair === 0);
  const inside = (t) => list.filter((c) => c.begin <= t && t < c.end).length;
  return {
    list,
    between,
    floor,
    first: Math.min(...between.map((c) => c.begin)),
    most: Math.max(0, ...list.map((c) => inside(c.begin))),
    instant: py.icm.list.find(([pair]) => pair === 1)?.[1],
  };
}

const collisionsOf = ({ icm }) => icm.list.map(([pair]) => ({ pair })).filter((c) => c.pair > 0);
const pairsOf = (contacts) => contacts.map((c) => c.pair);

// For each sentence: the condition that must hold in Python, and the numbers in the text.
const newtonClaims = {
  "too-deep": (p) => [is(p.newton, "too deep"), { time: p.newton.last, pair: p.newton.too_deep }],
  unresolved: (p) => [is(p.newton, "not resolved"), { events: p.newton.events }],
  "cradle-no-contact": (p, s) => [s.cradle && p.newton.contacts === 0, {}],
  cradle: (p, s) => [s.cradle && p.newton.contacts > 0, { contacts: p.newton.contacts, velocity: leaves(p.newton) }],
  "at-rest": (p) => [
    is(p.newton, "at rest") && top(p.newton) !== null,
    { contacts: p.newton.contacts, height: top(p.newton) },
  ],
  "at-rest-flat": (p) => [is(p.newton, "at rest") && top(p.newton) === null, {}],
  "no-contact-rises": (p) => [
    p.newton.contacts === 0 && top(p.newton) !== null,
    { contacts: 0, height: top(p.newton) },
  ],
  "no-contact": (p) => [p.newton.contacts === 0 && top(p.newton) === null, {}],
  "no-bounce": (p) => [p.newton.contacts > 0 && top(p.newton) === null, { contacts: p.newton.contacts }],
  rises: (p) => [is(p.newton, "ok") && p.newton.contacts > 0, { contacts: p.newton.contacts, height: top(p.newton) }],
  compressed: (p) => [p.newton.compression >= 0.05, { compression: p.newton.compression }],
};
const ratio = (p) => (top(p.icm) === null || top(p.newton) === null ? NaN : top(p.icm) / top(p.newton));
const icmRise = (p) => ({ contacts: p.icm.contacts, height: top(p.icm), ratio: ratio(p) });
const icmClaims = {
  unresolved: (p) => [is(p.icm, "not resolved"), { events: p.icm.events }],
  "cradle-no-contact": (p, s) => [s.cradle && p.icm.contacts === 0, {}],
  "cradle-collapse": (p, s) => [s.cradle && is(p.icm, "inelastic collapse"), { velocity: leaves(p.icm) }],
  cradle: (p, s) => [s.cradle && is(p.icm, "ok"), { contacts: p.icm.contacts, velocity: leaves(p.icm) }],
  collapse: (p) => [is(p.icm, "inelastic collapse") && top(p.icm) !== null, { height: top(p.icm), ratio: ratio(p) }],
  "collapse-flat": (p) => [is(p.icm, "inelastic collapse") && top(p.icm) === null, {}],
  "at-rest": (p) => [is(p.icm, "at rest") && top(p.icm) !== null, { height: top(p.icm), ratio: ratio(p) }],
  "at-rest-flat": (p) => [is(p.icm, "at rest") && top(p.icm) === null, {}],
  "no-contact-rises": (p) => [p.icm.contacts === 0 && top(p.icm) !== null, icmRise(p)],
  "no-contact": (p) => [p.icm.contacts === 0 && top(p.icm) === null, {}],
  "no-bounce": (p) => [p.icm.contacts > 0 && top(p.icm) === null, { contacts: p.icm.contacts }],
  "rises-later": (p, s) => [s.balls.length > 2 && is(p.icm, "ok") && p.icm.contacts > 0, icmRise(p)],
  rises: (p) => [is(p.icm, "ok") && p.icm.contacts > 0, icmRise(p)],
};
const pushes = ({ floor }) => ({ floorEnd: floor.end });
const meeting = (c) => ({ floorEnd: c.floor.end, first: c.first });
const longest = ({ list }) => Math.max(...list.map((c) => c.end - c.begin));
const whyClaims = {
  "too-deep": (c, p) => [p.newton.too_deep >= 0, {}],
  unresolved: (c, p) => [is(p.newton, "not resolved"), {}],
  "cradle-none": (c) => [c.list.length === 0, {}],
  "cradle-once": (c) => [c.list.length === 1, { longest: longest(c) }],
  "cradle-in-turn": (c) => [c.most === 1, { contacts: c.list.length, longest: longest(c) }],
  "cradle-together": (c) => [c.most > 1, { contacts: c.list.length, longest: longest(c), most: c.most }],
  "never-meet": (c, p) => [
    p.newton.contacts === 0 || c.between.length === 0,
    p.newton.t_floor_end === null ? {} : { floorEnd: p.newton.t_floor_end },
  ],
  "floor-stays": (c) => [c.floor.end === Infinity, {}],
  "two-after-once": (c) => [c.first >= c.floor.end && c.between.length === 1, meeting(c)],
  "two-after-often": (c) => [
    c.first >= c.floor.end && c.between.length > 1,
    { ...meeting(c), contacts: c.between.length },
  ],
  "two-not-met": (c) => [c.first < c.floor.end && c.instant === undefined, pushes(c)],
  "two-at-once": (c) => [c.first < c.floor.end && c.instant === 0, pushes(c)],
  "two-meet": (c) => [c.first < c.floor.end && c.instant > 0, { ...pushes(c), instant: c.instant }],
  "many-together": (c) => [c.most > 1 && c.first < c.floor.end, { ...meeting(c), most: c.most }],
  "many-together-later": (c) => [c.most > 1 && c.first >= c.floor.end, { ...meeting(c), most: c.most }],
  "many-in-turn": (c) => [c.most === 1 && c.first >= c.floor.end, meeting(c)],
  "touch-often": (c) => [
    c.between.length > 1,
    { contacts: c.between.length, first: c.first, end: c.between.at(-1).end },
  ],
  "touch-for-ever": (c) => [c.between[0].end === Infinity, {}],
  "touch-beyond-floor": (c) => [
    c.between.length === 1 && c.between[0].end > c.floor.end,
    { lasts: c.between[0].end - c.first },
  ],
  "touch-on-floor": (c) => [
    c.between.length === 1 && c.between[0].end <= c.floor.end,
    { lasts: c.between[0].end - c.first },
  ],
  "breaks-down": (c, p) => [is(p.icm, "inelastic collapse"), {}],
  "too-many": (c, p) => [is(p.icm, "not resolved"), {}],
};

const units = {
  "": 1,
  "%": 0.01,
  m: 1,
  cm: 0.01,
  mm: 1e-3,
  µm: 1e-6,
  nm: 1e-9,
  s: 1,
  ms: 1e-3,
  µs: 1e-6,
  ns: 1e-9,
  "m/s": 1,
  "cm/s": 0.01,
  "mm/s": 1e-3,
  "µm/s": 1e-6,
  "nm/s": 1e-9,
};
const superscript = (text) => Number([..."⁰¹²³⁴⁵⁶⁷⁸⁹"].reduce((t, c, i) => t.replaceAll(c, i), text.replace("⁻", "-")));

// Each quantity in a text is one of the numbers, within the printed digits.
function checkQuantities({ text, numbers, id }, where) {
  for (const [, digits, power, unit] of text.matchAll(
    /([−-]?\d+(?:\.\d+)?)(?:·10([⁻⁰-⁹]+))? (%|[nµmc]?m\/s|[nµmc]?m|[nµm]?s)(?![a-zµ/])/g,
  )) {
    const scale = units[unit] * (power ? 10 ** superscript(power) : 1);
    const shown = Number(digits.replace("−", "-")) * scale;
    const places = digits.includes(".") ? -digits.split(".")[1].length : /0*$/.exec(digits)[0].length;
    const half = 0.5001 * scale * 10 ** places;
    const known = Object.entries(numbers)
      .flatMap(([key, x]) => (key === "ratio" ? [x - 1, 1 - x] : [x, Math.abs(x)]))
      .concat(id === "compressed" || id === "band-deep" ? [0.05] : [], 0.01);
    assert.ok(
      known.some((x) => Math.abs(x - shown) <= half),
      `${where}: ${digits} ${unit} in “${text}” is none of ${JSON.stringify(numbers)}`,
    );
  }
}

const close = (a, b, what) =>
  assert.ok(
    a === b ||
      (Number.isNaN(a) && (b === null || Number.isNaN(b))) ||
      Math.abs(a - b) <= 1e-9 * Math.max(Math.abs(a), Math.abs(b)) + 1e-15,
    `${what}: ${a}, Python ${b}`,
  );

function checkSentences(list, claims, where, ...facts) {
  for (const s of list) {
    assert.ok(claims[s.id], `${where}: unknown sentence ${s.id}`);
    const [holds, numbers] = claims[s.id](...facts);
    assert.ok(holds, `${where}: “${s.text}” (${s.id}) is not so`);
    assert.deepEqual(Object.keys(s.numbers).sort(), Object.keys(numbers).sort(), `${where}: ${s.id}`);
    for (const [key, x] of Object.entries(numbers)) close(s.numbers[key], x, `${where}: ${s.id}.${key}`);
    assert.match(s.text, /^[A-Z\d][^]*\.$/, where);
    assert.doesNotMatch(s.text, /NaN|undefined|null|Infinity|–|  | [.,;]|\.\.|,,/, `${where}: ${s.text}`);
    checkQuantities(s, where);
  }
}

// ---- the story ----------------------------------------------------------------------------------------------

const TOLERANCE = 0.01;
const STEPS = 160; // of the core's search for the line of agreement

// The facts that the plots give, with few points of the curve; and the settings whose results they claim, of which
// Python solves the same.
function plotsOf(scenario, drop) {
  const { run } = drop.newton;
  const floor = Number.isFinite(run.tFloorEnd) ? run.tFloorEnd : drop.to - drop.from;
  const speed = scenario.cradle ? Math.max(...scenario.velocities.map(Math.abs)) : run.impactSpeed;
  const [low, high] = lib.wholeMap(scenario, "gap", floor, speed).y;
  const span = lib.spanOf(scenario, "gap", floor, speed);
  const curve = [0, ...[0, 0.35, 0.7, 1].map((share) => span.low * (span.high / span.low) ** share)];
  const moved = (gap) => lib.movedTo(scenario, "gap", gap);
  const heights = curve.map((gap) => {
    core.set(moved(gap));
    return core.solve(lib.Model.newton) ? core.reboundHeights(lib.Model.newton).at(-1) : NaN;
  });
  const best = heights.reduce((a, h, i) => (h > heights[a] ? i : a), 0);
  core.set(scenario);
  const [gap] = core.agreementGaps([scenario.restitution], low, high, TOLERANCE);
  const stiffer = [0.5, 2].map((factor) => {
    const s = lib.copyOf(scenario);
    if (!s.own.stiffness) lib.setOwn(s, true);
    s.own.stiffness = s.own.stiffness?.map((k) => factor * k);
    return s;
  });
  const line = Number.isFinite(gap) ? [gap < 0 ? -gap : gap, (gap < 0 ? -gap : gap) * (low / high) ** (1 / STEPS)] : [];
  return {
    facts: { gaps: { touching: heights[0], best: heights[best], at: curve[best] }, trusted: { gap, widest: high } },
    bands: drop.band ? stiffer.map(lib.toToml) : [],
    texts: [...curve, high, scenario.gaps[lib.firstGap(scenario)], ...line].map((x) => lib.toToml(moved(x))),
    lowest: low,
  };
}

const ended = (m) => is(m, "ok") && m.contacts > 0;
const said = (answer) => answer === "yes" || answer === "by luck"; // the models agree

// For each sentence of the story: what must hold in Python, and its numbers.
const both = ({ newton, icm }) => ({ newton, icm, tolerance: TOLERANCE });
const agreed = ({ py, newton, icm, verdict }) => [
  ended(py.newton) && ended(py.icm) && Math.abs(icm / newton - 1) <= TOLERANCE && verdict === (py.answer !== "yes"),
  both({ newton, icm }),
];
const differs = ({ py, newton, icm, text }) => [
  ended(py.newton) &&
    ended(py.icm) &&
    Math.abs(icm / newton - 1) > TOLERANCE &&
    (!/lower than where/.test(text) || newton < py.release) &&
    (!/times as high as where/.test(text) || newton >= 1.05 * py.release),
  both({ newton, icm }),
];
const cradles = ({ py, cradle, newton, icm }) => [cradle && ended(py.newton) && ended(py.icm), both({ newton, icm })];
const touches = (p) => ({ newton: p.newton.contacts, icm: p.icm.contacts });
const followed = (p) => p.newton.contacts > 0 && !is(p.newton, "too deep") && !is(p.newton, "not resolved");
const overlap = (p) => ({ overlapping: p.overlapping });
const line = ({ py }) => py.variants.slice(5).map((v) => said(v.answer)); // at the top, here, at the line, below it
const many = ({ py, report }) => report.setting.balls.length > 2 && followed(py);
const unanswered = ({ newton }) => is(newton, "too deep") || is(newton, "not resolved");
const pair = ({ report: { setting: s } }) => s.balls.length === 2 && !s.cradle;
const restitution = ({ py, cradle, report: { setting: s }, text }, onCradle) => {
  const numbers = { restitution: s.restitution };
  if (s.law === "viscoelastic") numbers.impact_speed = s.constants.impact_speed;
  const stated = text.includes(`ε = ${Number(s.restitution.toPrecision(3))}`);
  return [cradle === onCradle && stated && Math.abs(py.restitution / s.restitution - 1) < 1e-9, numbers];
};
const storyClaims = {
  "balls-lent": (f) => {
    const { balls, gaps } = f.report.setting;
    return [f.step !== "gap" && pair(f), { lower: balls[0].radius, upper: balls[1].radius, gap: gaps[0] }];
  },
  "balls-back": (f) => [f.step === "gap" && pair(f), {}],
  worlds: () => [true, {}], // what the models are
  band: ({ py: { bands, newton, icm } }) => [
    bands.length === 2 && ended(newton) && ended(icm),
    { soft: bands[0], stiff: bands[1] },
  ],
  "band-deep": ({ py }) => [
    py.bands.length === 2 && py.newton.compression >= 0.05,
    { compression: py.newton.compression },
  ],
  lone: ({ py, cradle }) => [!cradle && py.lone !== null, py.lone],
  restitution: (f) => restitution(f, false),
  "restitution-cradle": (f) => restitution(f, true),
  "out-unanswered": ({ py }) => [unanswered(py), {}],
  "out-no-contact": ({ py }) => [!unanswered(py) && py.newton.contacts === 0, {}],
  "out-floor": (f) => {
    const { floor, first, between } = contactsOf(f.py);
    const together = floor.begin <= first && first < Math.min(floor.end, between[0].end);
    return [pair(f) && followed(f.py) && together && f.py.overlapping > 0, {}];
  },
  "out-slower": (f) => [
    storyClaims["out-floor"](f)[0] && f.py.lone !== null && f.py.meets < f.py.lone.leaves,
    { meets: f.py.meets, leaves: f.py.lone?.leaves },
  ],
  "out-many": ({ py }) => [followed(py) && py.overlapping > 0, {}],
  "out-nothing": ({ py }) => [followed(py) && py.overlapping === 0, {}],
  "seen-floor": (f) => [storyClaims["out-floor"](f)[0], { contacts: f.py.newton.contacts }],
  "seen-many": (f) => [followed(f.py) && f.py.overlapping > 0 && !(pair(f) && storyClaims["out-floor"](f)[0]), {}],
  "seen-apart": ({ py }) => [followed(py) && py.overlapping === 0, {}],
  forces: ({ cradle }) => [!cradle, {}],
  "forces-cradle": ({ cradle }) => [cradle, {}],
  colours: (f) => [pair(f), {}],
  "watch-cradle": cradles,
  "watch-agree": agreed,
  "watch-differ": differs,
  "predict-cradle": ({ cradle, fall }) => [cradle && fall === "before", {}],
  predict: ({ py, fall }) => [fall === "before", { release: py.release }],
  "drop-wait": ({ fall }) => [fall === "falling", {}],
  "drop-wait-cradle": ({ cradle, fall }) => [cradle && fall === "falling", {}],
  "drop-cradle": cradles,
  "drop-agree": agreed,
  "drop-differ": differs,
  guess: ({ newton }) => [Number.isFinite(newton), { guess: 2.5 }],
  "count-without-end": ({ py }) => [
    followed(py) && (is(py.icm, "inelastic collapse") || is(py.icm, "at rest")),
    touches(py),
  ],
  "count-too-many": ({ py }) => [followed(py) && is(py.icm, "not resolved"), touches(py)],
  "count-differs": ({ py }) => [followed(py) && py.newton.contacts !== py.icm.contacts, touches(py)],
  "count-overlaps": ({ py }) => [
    followed(py) && py.newton.contacts === py.icm.contacts && py.overlapping > 0,
    { ...touches(py), ...overlap(py) },
  ],
  "count-same": ({ py }) => [
    followed(py) && py.newton.contacts === py.icm.contacts && py.overlapping === 0,
    touches(py),
  ],
  "gap-cradle": ({ cradle }) => [cradle, {}],
  "gap-unknown": ({ py }) => [py.variants[0].top === null || py.variants.slice(0, 5).every((v) => v.top === null), {}],
  "gap-none-better": ({ py: { variants } }) => [
    variants.slice(0, 5).every((v) => v.top === null || v.top <= variants[0].top * (1 + TOLERANCE) * (1 + 1e-9)),
    { touching: variants[0].top, tolerance: TOLERANCE },
  ],
  "gap-better": ({ py: { variants }, plots }) => {
    const best = Math.max(...variants.slice(0, 5).map((v) => v.top ?? 0));
    return [best > variants[0].top * (1 + TOLERANCE), { touching: variants[0].top, best, at: plots.gaps.at }];
  },
  // A tennis ball rebounds from 2.54 m to 1.35 to 1.47 m.
  alone: ({ py, report }) => {
    const { radius } = report.setting.balls.at(-1);
    const rise = (height) => radius + (height / 2.54) * (py.release - radius);
    return [!report.setting.cradle, { low: rise(1.35), high: rise(1.47) }];
  },
  "no-experiment": ({ cradle }) => [!cradle, {}],
  "map-cradle": ({ cradle }) => [cradle, {}],
  "map-many": (f) => [many(f), { contacts: f.py.newton.contacts, ...overlap(f.py) }],
  "map-many-unanswered": (f) => [f.report.setting.balls.length > 2 && !many(f), {}],
  "map-pending": () => [false, {}],
  "map-unknown": ({ py, plots }) => [
    py.variants[5].answer === "undecided",
    { tolerance: TOLERANCE, widest: plots.trusted.widest },
  ],
  "map-nowhere": (f) => [!line(f)[0], { tolerance: TOLERANCE, widest: f.plots.trusted.widest }],
  "map-not-at-the-top": (f) => [
    !line(f)[0] && line(f)[2],
    { tolerance: TOLERANCE, widest: f.plots.trusted.widest, gap: -f.plots.trusted.gap },
  ],
  map: (f) => {
    const [top, here, at, below] = line(f);
    const { gap } = f.plots.trusted;
    const present = f.report.setting.gaps[0];
    return [
      top && at && (!below || gap <= f.lowest * 1.0001) && (here || present < gap),
      { tolerance: TOLERANCE, gap },
    ];
  },
};

function checkStory(report, drop, py, plots, where) {
  const { cradle } = report.setting;
  const last = (m) => (cradle ? leaves(m) : top(m)) ?? NaN;
  const facts = { py, report, cradle, plots: plots.facts, lowest: plots.lowest };
  Object.assign(facts, { newton: last(py.newton), icm: last(py.icm) });
  const rising = [py.newton, py.icm].every((m) => ended(m) && Number.isFinite(last(m)));
  for (const step of lib.steps)
    for (const fall of ["before", "falling", "over"]) {
      const others = { lent: pair(facts) && step !== "gap", back: pair(facts) && step === "gap" };
      const list = lib.story(step, { drop, report, guess: 2.5, fall, ...others, ...plots.facts });
      const verdict = list.includes(report.verdict);
      for (const s of list) {
        if (report.why.includes(s) || s === report.verdict) continue; // the report's own
        if (report.newton.includes(s) || report.icm.includes(s)) {
          // The laboratory's words stand only where the chapter has none.
          assert.ok(
            step === "count" ? !followed(py) : fall === "over" || step === "watch",
            `${where}: ${step} ${s.id}`,
          );
          assert.ok(step === "count" || !rising, `${where}: ${step} ${s.id}`);
          continue;
        }
        const claim = storyClaims[s.id];
        assert.ok(claim, `${where}: unknown sentence ${s.id}`);
        const [holds, numbers] = claim({ ...facts, step, fall, text: s.text, verdict });
        assert.ok(holds, `${where}: “${s.text}” (${s.id}) is not so`);
        assert.deepEqual(Object.keys(s.numbers).sort(), Object.keys(numbers).sort(), `${where}: ${s.id}`);
        for (const [key, x] of Object.entries(numbers)) close(s.numbers[key], x, `${where}: ${s.id}.${key}`);
        if (step !== "count")
          checkQuantities({ ...s, numbers: { ...s.numbers, guess: 2.5, release: py.release } }, where);
        storySeen.set(s.id, (storySeen.get(s.id) ?? 0) + 1);
      }
    }
}
const storySeen = new Map();

function checkCounts(text, n, where) {
  const words = [
    "no",
    "one",
    "two",
    "three",
    "four",
    "five",
    "six",
    "seven",
    "eight",
    "nine",
    "ten",
    "eleven",
    "twelve",
  ];
  const said = /^(\w+) contacts?\b/i.exec(text)?.[1].toLowerCase();
  if (said) assert.equal(said, words[n] ?? String(n), `${where}: ${text}`);
}

function checkTable(table, py, where) {
  const said = (m) => ({
    contacts: m.contacts,
    top: top(m),
    low: m.rises[0],
    vtop: leaves(m),
    vr: m.relative_velocity,
    vs: m.separation_velocity,
    eff: m.effective_restitution,
    floor: m === py.icm ? 0 : m.t_floor_end,
  });
  for (const row of table) {
    [py.newton, py.icm].forEach((m, k) => {
      const expected = row.id[0] === "v" && /\d/.test(row.id) ? m.velocities[Number(row.id.slice(1))] : said(m)[row.id];
      if (expected !== undefined) close(row.numbers[k], expected, `${where}: ${row.id}`);
      assert.equal(
        row.values[k] === "–",
        !Number.isFinite(row.numbers[k]),
        `${where}: ${row.id} says ${row.values[k]}`,
      );
    });
  }
}

function checkShares({ newton, icm, rows }, py, where) {
  for (const [k, [name, mine]] of [
    ["newton", newton],
    ["icm", icm],
  ].entries()) {
    const all = [...mine.balls, mine.stored, mine.lost];
    assert.ok(
      all.every((x) => x >= 0 && x <= 1),
      `${where}: ${name} ${all}`,
    );
    assert.ok(
      Math.abs(all.reduce((a, b) => a + b, 0) - 1) < 1e-12,
      `${where}: ${name} sums to ${all.reduce((a, b) => a + b, 0)}`,
    );
    all.forEach((x, i) =>
      assert.ok(
        Math.abs(x - py[name].shares[i]) < 2e-6,
        `${where}: share ${i} of ${name}: ${x}, Python ${py[name].shares[i]}`,
      ),
    );
    const percent = rows.map((r) => (r.percent[k] === "<0.1 %" ? 0 : Number(r.percent[k].replace(" %", ""))));
    assert.equal(percent.reduce((a, b) => a + b, 0).toFixed(1), "100.0", `${where}: ${percent}`);
  }
}

test(`${count} random settings: every sentence and number is Python's`, async (t) => {
  const all = settings();
  const drops = [];
  const plots = [];
  const reports = all.map(({ scenario, link }) => {
    const solved = solve(core, scenario);
    assert.ok(!("reason" in solved), link);
    drops.push(dropOf(solved));
    plots.push(plotsOf(scenario, drops.at(-1)));
    return reportOf(drops.at(-1), TOLERANCE);
  });
  const answers = fromPython(
    program,
    all.map(({ scenario }, i) => [lib.toToml(scenario), ...plots[i].texts, ...plots[i].bands]),
  );
  const seen = new Map();
  const faults = [];
  const python = await answers;
  for (const [i, r] of reports.entries()) {
    const { link, scenario } = all[i];
    const py = python[i];
    py.bands = py.variants.splice(plots[i].texts.length).map(({ top }) => top);
    const where = link;
    const facts = contactsOf(py);
    checkSentences(r.newton, newtonClaims, where, py, scenario);
    checkSentences(r.icm, icmClaims, where, py, scenario);
    checkSentences(r.why, whyClaims, where, facts, py, scenario);
    if (r.why.some((s) => /as the collision model has it/.test(s.text)))
      assert.equal(String(pairsOf(facts.between)), String(pairsOf(collisionsOf(py))), where);
    checkCounts(r.newton[0].text, py.newton.contacts, where);
    assert.equal(r.verdict.answer, py.answer, where);
    assert.equal(r.verdict.text, py.sentence, where);
    if ("overlapping" in r.verdict.numbers) assert.equal(r.verdict.numbers.overlapping, py.overlapping, where);
    checkTable(r.table, py, where);
    checkShares(r.shares, py, where);
    try {
      checkStory(r, drops[i], py, plots[i], where);
    } catch (error) {
      faults.push(error.message);
    }
    for (const s of [...r.newton, ...r.icm, ...r.why, r.verdict]) seen.set(s.id, (seen.get(s.id) ?? 0) + 1);
  }
  assert.deepEqual(faults, []);
  t.diagnostic([...seen, ...storySeen].map(([id, n]) => `${id} ${n}`).join(", "));
  assert.ok(seen.size >= 30, `${seen.size} kinds of sentences`);
});
