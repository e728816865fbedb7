// The parts of the story and of the panels that need no browser: sentences, curves, measured balls and heights, links.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { Canvas, theme } from "./canvas.mjs";
import { load, random as randomness } from "./modules.mjs";
import { randomScenario } from "./scenarios.mjs";

const lib = await load(
  "measurements",
  "measured",
  "report",
  "sentence",
  "sentences",
  "story_view",
  "link",
  "map_box",
  "map_drawing",
  "pen",
  "plot",
  "trust",
  "presets",
  "toml",
  "view",
);
const whyText = (facts) => lib.joined(lib.why(facts));
const { core } = lib;

// The facts that why() takes.
function factsOf(s) {
  core.set(s);
  const newton = core.solve(lib.Model.newton);
  const icm = core.solve(lib.Model.independent);
  return newton && icm && Number.isFinite(newton.last) && newton.outcome !== 3 && newton.outcome !== 6
    ? { balls: s.balls.length, cradle: s.cradle, newton, icm }
    : null;
}

function wellFormed(text, what) {
  assert.match(text, /^[A-Z]/, what);
  assert.match(text, /\.$/, what);
  assert.doesNotMatch(
    text,
    /NaN|undefined|null|Infinity|∞|–|  | [.,;]|\.\.|,,|; [A-Z]|\bone contacts\b|\b(?:two|three) (?:ball|pair|contact)\b|\b1 times\b|−/,
    what,
  );
  for (const [, number, unit] of text.matchAll(/(\d[\d.·⁻⁰-⁹]*)(\s*)(?=\S)/g))
    assert.equal(unit, " ", `a unit follows ${number}: ${what}`);
  for (const [, unit] of text.matchAll(/\d ([a-zµ/]+)/g))
    assert.match(unit, /^(?:[nµm]?s|[nµmck]?m|m\/s|times)$/, what);
  assert.ok(text.length < 420, `${text.length} characters: ${what}`);
}

test("why: a well-formed sentence for every setting", () => {
  const random = randomness(9);
  const kinds = new Map();
  let told = 0;
  for (let i = 0; i < 400; i++) {
    const s = randomScenario(random, lib);
    const facts = factsOf(s);
    if (!facts) continue;
    const text = whyText(facts);
    wellFormed(text, `${text} ← ${JSON.stringify(s)}`);
    const kind = text.replace(/[\d.·⁻⁰-⁹]+ (?:[nµm]?s)/g, "T");
    kinds.set(kind, text);
    told++;
  }
  assert.ok(told > 300, `${told} settings`);
  const all = [...kinds.values()].join("\n");
  for (const branch of [
    /has let go when the balls meet/,
    /while the floor is still pushing/,
    /at the very instant/,
    /touch twice/,
    /Up to \w+ contacts/,
    /up to \w+ pairs/,
    /never two pairs|The balls touch once/,
    /breaks down/,
    /do not meet/,
  ])
    assert.match(all, branch);
});

test("why: the paper's Fig. 2", () => {
  const text = whyText(factsOf(lib.paper()));
  assert.equal(
    text,
    "The floor pushes for 775 µs; the collision model lets the balls meet after 18.8 µs, while the floor is still " +
      "pushing. By Newton’s equations they touch four times, between 194 µs and 721 µs.",
  );
});

test("why: far apart the models agree", () => {
  const s = lib.paper();
  s.gaps = [0.01];
  assert.match(
    whyText(factsOf(s)),
    /^The floor pushes for \d+ µs and has let go when the balls meet after [\d.]+ ms: one collision after the other, as the collision model has it\.$/,
  );
});

test("measured heights: what is read", () => {
  const read = (text) => lib.readMeasurements(text);
  assert.deepEqual(read("gap (mm), height (m), uncertainty (cm)\n# by hand\n0, 1.02, 3\n\n5,1.31\n"), {
    axis: "gap",
    list: [
      { x: 0, height: 1.02, uncertainty: 0.03 },
      { x: 0.005, height: 1.31, uncertainty: 0 },
    ],
  });
  assert.deepEqual(read("\uFEFFheight (cm);restitution\r\n98,5;0,8\r\n"), {
    axis: "e",
    list: [{ x: 0.8, height: 0.985, uncertainty: 0 }],
  });
  assert.deepEqual(read("ratio\theight\n3\t1\n"), { axis: "ratio", list: [{ x: 3, height: 1, uncertainty: 0 }] });
  assert.deepEqual(read('"gap [um]","height (m)"\n"10","1.5"\n').list, [{ x: 10 * 1e-6, height: 1.5, uncertainty: 0 }]);
});

test("measured heights: one clear line for what is wrong", () => {
  const faults = {
    "": "measurements: the file is empty",
    "# nothing\n": "measurements: the file is empty",
    "gap (mm), height (m)\n": "measurements: there is no line of values",
    "0, 1.02\n": "line 1: got the column “0”",
    "gap, speed\n1,2\n": "line 1: got the column “speed”",
    "gap (mm)\n1\n": "line 1: got the columns gap; one must be height",
    "height (m)\n1\n": "line 1: got the columns height; one must be gap, restitution or ratio",
    "gap (inch), height (m)\n1,1\n": "line 1: got the unit “inch” for gap",
    "restitution (m), height (m)\n1,1\n": "line 1: got the unit “m” for restitution, must be none",
    "gap (mm), height (m)\n1, high\n": "line 2, height: got “high”, must be a number above 0",
    "gap (mm), height (m)\n-1, 1\n": "line 2, gap: got “-1”, must be a number not below 0",
    "restitution, height (m)\n1.2, 1\n": "line 2, restitution: got “1.2”, must be a number from 0 to 1",
    "gap (mm), height (m)\n1\n": "line 2, height: got “”",
    "gap (mm), height (m)\n1, 2, 3\n": "line 2: got 3 values, must be at most 2",
    "gap (mm), height (m)\n1, 1e999\n": "line 2, height: got “1e999”",
  };
  for (const [text, begin] of Object.entries(faults))
    assert.throws(
      () => lib.readMeasurements(text),
      (e) => e.message.startsWith(begin) && !e.message.includes("\n"),
      `${JSON.stringify(text)} → ${begin}`,
    );
  assert.throws(() => lib.readMeasurements("gap,height\n" + "1,1\n".repeat(20_000)), /must be at most/);
});

test("measured heights: nothing in a file throws anything but that line", () => {
  const random = randomness(4);
  const pieces = [
    "gap",
    "height",
    " (mm)",
    "(",
    ")",
    ",",
    ";",
    "\t",
    "\n",
    "1",
    "0.5",
    "-",
    "e",
    '"',
    "#",
    " ",
    "µ",
    "\r\n",
    "ratio",
    "NaN",
    "Infinity",
    "\u0000",
  ];
  for (let i = 0; i < 3000; i++) {
    const text = Array.from(
      { length: Math.floor(20 * random()) },
      () => pieces[Math.floor(pieces.length * random())],
    ).join("");
    try {
      for (const m of lib.readMeasurements(text).list)
        assert.ok(
          m.x >= 0 && Number.isFinite(m.x) && m.height > 0 && Number.isFinite(m.height) && m.uncertainty >= 0,
          text,
        );
    } catch (e) {
      assert.match(e.message, /^(?:measurements: |line \d+)[^\n]*$/, JSON.stringify(text));
    }
  }
});

test("measured balls: stiffness, restitution and contact time belong together", () => {
  for (const [mass, stiffness, e] of [
    [0.6, 4.2e4, 0.76],
    [0.0577, 2e4, 0.5],
    [1, 1e6, 1],
    [1, 1e3, 0.3],
  ]) {
    const time = lib.contactTime(mass, stiffness, e);
    assert.ok(Math.abs(lib.stiffnessFor(mass, time, e) / stiffness - 1) < 1e-9);
    const s = lib.paper();
    Object.assign(s, { restitution: e, height: 1.1, gaps: [0.5] });
    s.constants.stiffness = stiffness;
    s.balls = [
      { radius: 0.1, density: lib.densityFor(mass, 0.1) },
      { radius: 0.01, density: 1 },
    ];
    const { newton } = factsOf(s);
    // Gravity makes the contact slightly longer.
    if (stiffness >= 1e4) assert.ok(Math.abs(newton.tFloorEnd / time - 1) < 0.02, `${newton.tFloorEnd} ${time}`);
  }
  for (const b of lib.measuredBalls) {
    for (const [low, high] of [b.mass, b.diameter, b.restitution]) assert.ok(low > 0 && low <= high, b.id);
    assert.ok(b.restitution[1] < 1 && b.source.length > 5, b.id);
  }
  const { restitution: r } = lib.ballById("tennis");
  assert.deepEqual(
    r.map((x) => x.toFixed(2)),
    ["0.73", "0.76"],
  );
  // The lowest point of a tennis ball rebounds from 2.54 m to 1.35 to 1.47 m.
  const ball = lib.presets[0].scenario.balls[1];
  const alone = lib.aloneRise(ball, 1.3);
  for (const [end, rise] of [
    ["low", 1.35],
    ["high", 1.47],
  ])
    assert.ok(Math.abs(alone[end] - ball.radius - (rise / 2.54) * (1.3 - ball.radius)) < 1e-12);
  assert.equal(alone.by, "ITF");
  assert.equal(lib.aloneRise({ ...ball, radius: 0.05 }, 1.3), null, "no tennis ball");
});

test("the story: well formed for every step and setting", () => {
  const random = randomness(3);
  let told = 0;
  for (const scenario of [
    ...lib.presets.map((p) => lib.copyOf(p.scenario)),
    ...Array.from({ length: 50 }, () => randomScenario(random, lib)),
  ]) {
    const solved = lib.solve(core, scenario);
    if ("reason" in solved) continue;
    const drop = lib.dropOf(solved);
    const report = lib.reportOf(drop, 0.01);
    for (const step of lib.steps)
      for (const guess of [null, 2.5])
        for (const gaps of [null, { touching: 0.9, best: 3.1, at: 0.02 }, { touching: NaN, best: NaN, at: 0 }])
          for (const trusted of [null, ...[Infinity, NaN, -0.002, 0.0123].map((gap) => ({ gap, widest: 0.1 }))])
            for (const fall of ["before", "falling", "over"]) {
              const [lent, back] = [step === "count" && guess !== null, step === "gap" && guess !== null];
              const text = lib.joined(lib.story(step, { drop, report, guess, fall, gaps, trusted, lent, back }));
              assert.match(text, /^[A-Z\d].*[.?…]$/, text);
              assert.doesNotMatch(text, /NaN|undefined|null|Infinity|  | [.,;]|\.\./, `${step}: ${text}`);
            }
    told++;
  }
  assert.ok(told > 40);
});

test("the link keeps the story", () => {
  const random = randomness(5);
  const pick = (list) => list[Math.floor(random() * list.length)];
  for (let i = 0; i < 300; i++) {
    const step = pick([null, ...lib.steps]);
    const view = {
      step,
      panel: step ? null : pick([null, ...lib.panels]),
      curve: pick(lib.curveAxes),
      guess: pick([null, 0, 2.5]),
      pin: pick([null, lib.presets[0].scenario, lib.paper(), randomScenario(random, lib)]),
      own: false,
    };
    const q = new URLSearchParams();
    lib.storyToQuery(view, q);
    const read = lib.firstStoryView();
    const notes = [];
    lib.storyFromQuery(read, new URLSearchParams(q.toString()), notes);
    assert.deepEqual({ ...read, pin: null }, { ...view, pin: null });
    assert.equal(read.pin === null, view.pin === null);
    if (view.pin && notes.length === 0) assert.ok(lib.sameScenario(read.pin, view.pin), q.toString());
  }
});

test("a chapter has balls of its own, unless the link brings some", () => {
  const balls = (link) => lib.settingOf(new URLSearchParams(link), []).scenario;
  const [opening, paper] = ["basketball", "fig2"].map((id) => lib.presets.find((p) => p.id === id).scenario);
  for (const [link, scenario, own] of [
    ["", opening, false],
    ["story=watch", opening, false],
    ["story=count", paper, false],
    ["story=map&guess=2", paper, false],
    ["story=count&example=basketball", paper, false],
    ["story=gap", opening, false],
    ["story=count&example=astro", lib.presets.find((p) => p.id === "astro").scenario, true],
    ["story=count&gap=0.001", { ...paper, gaps: [0.001] }, true],
    ["story=gap&gap=0.001&example=basketball", { ...opening, gaps: [0.001] }, true],
  ]) {
    assert.ok(lib.sameScenario(balls(link), scenario), link);
    const view = lib.firstStoryView();
    lib.storyFromQuery(view, new URLSearchParams(link), []);
    assert.equal(view.own, own, link);
  }
});

test("a scenario in a link is the same again, whatever the page opens with", () => {
  const random = randomness(6);
  for (const s of [
    ...lib.presets.map((p) => p.scenario),
    ...Array.from({ length: 100 }, () => randomScenario(random, lib)),
  ]) {
    const q = new URLSearchParams();
    lib.scenarioToQuery(s, q);
    const base = lib.presets.find((p) => p.id === (q.get("example") ?? lib.baseOf(q)));
    const read = lib.copyOf(base.scenario);
    const notes = [];
    lib.fromQuery(read, q, notes);
    if (notes.length === 0) assert.ok(lib.sameScenario(read, s), q.toString());
  }
});

test("the documentation names every parameter of a link, and what it may be", () => {
  const text = readFileSync(new URL("../../docs/explorer.md", import.meta.url), "utf8").replace(/^```[^]*?^```/gm, "");
  const told = new Set([...text.matchAll(/`\??([^`]+)`/g)].map(([, name]) => name));
  const q = new URLSearchParams();
  const changed = lib.paper();
  for (const name of Object.keys(changed.constants)) changed.constants[name] *= 1.01;
  lib.toQuery(
    {
      ...changed,
      law: "tsuji",
      cradle: true,
      restitution: 0.5,
      height: 2,
      balls: [{ radius: 1, density: 1 }],
      gaps: [],
      velocities: [1],
    },
    q,
  );
  lib.viewToQuery(
    { map: { axis: "ratio", show: "effective", zoom: { x: [0.1, 1], y: [1, 2] } }, slow: false, time: 1 },
    q,
  );
  lib.storyToQuery({ step: "slow", guess: 1, panel: "film", curve: "e", pin: lib.paper() }, q);
  assert.ok(q.size > 20);
  for (const key of q.keys()) assert.ok(told.has(key.replace(/^a\..*/, "a.…")), key);
  const steps = lib.steps.filter((step) => step !== "watch");
  for (const name of [
    ...lib.presets.map((p) => p.id),
    ...lib.laws.map((law) => law.name),
    ...steps,
    ...lib.curveAxes,
    ...lib.panels.filter((p) => p !== "film"),
  ])
    assert.ok(told.has(name), name);
  for (const name of ["story=watch", "panel=film"]) assert.ok(told.has(name), name);
});

test("where both models agree: the line of the core is where the verdict changes", () => {
  const s = lib.paper();
  for (const restitution of [0.5, 0.7, 0.9]) {
    s.restitution = restitution;
    core.set(s);
    const [low, high] = [1e-5, 0.1];
    const [gap] = core.agreementGaps([restitution], low, high, 0.01);
    const answer = (x) => {
      const { comparison } = lib.solve(core, { ...lib.copyOf(s), gaps: [x] });
      return comparison.error <= 0.01;
    };
    for (const factor of [1, 1.1, 2, 5])
      assert.ok(gap * factor > high || answer(gap * factor), `${restitution}: ${gap} × ${factor}`);
    assert.ok(!answer(gap * (low / high) ** (1 / 160)), `${restitution}: below ${gap}`);
  }
});

test("the TOML file of a setting is that setting, and what cannot be read is refused in one line", () => {
  const random = randomness(8);
  for (let i = 0; i < 100; i++) {
    const s = randomScenario(random, lib);
    if (!s.cradle && random() < 0.5) {
      lib.setOwn(s, true);
      for (const values of Object.values(s.own)) values[0] = values[0] === 0 ? 0.1 : 0.9 * values[0];
    }
    const notes = [];
    const read = lib.fromToml(lib.toToml(s), notes);
    assert.deepEqual(notes, []);
    assert.deepEqual(read, {
      ...s,
      height: s.cradle ? read.height : s.height,
      constants: {
        ...read.constants,
        ...Object.fromEntries(lib.constantsOf(s).map((name) => [name, s.constants[name]])),
      },
    });
  }
  const example = lib.fromToml(
    readFileSync(new URL("../../examples/basketball_and_tennis_ball.toml", import.meta.url), "utf8"),
    [],
  );
  assert.ok(lib.sameScenario(example, lib.presets[0].scenario), "the example file has the balls of the page");
  const units = lib.fromToml(
    'height = "60 cm"\ngaps = ["0.1 mm"]\n[[balls]]\nradius = "10 cm"\ndensity = 840\n[[balls]]\nradius = ' +
      '0.01\nmass = "3.5 g"\n[law]\nname = "linear"\nstiffness = 5e7\nrestitution = 0.7\n',
    [],
  );
  assert.deepEqual([units.height, units.gaps[0], units.balls[0].radius], [0.6, 1e-4, 0.1]);
});

const ball = (radius, more = "density = 840") => `[[balls]]\nradius = ${radius}\n${more}\n`;
const law = '[law]\nname = "linear"\nstiffness = 5e7\nrestitution = 0.7\n';
const file = (top, { balls = ball("0.1") + ball("0.01"), laws = law } = {}) => `${top}\n${balls}${laws}`;
const drop = "height = 0.6\ngaps = 1e-4";
const cradle = "cradle = true\nvelocities = [1, 0, 0]";
const three = ball("0.1").repeat(3);

test("a TOML file that the page cannot show is refused in one line, with what is wrong", () => {
  for (const [text, said] of [
    ["", /^balls: got 0, must be 2 to 6/],
    ["nonsense", /^not valid TOML: .* \(at line 1, column \d+\)$/],
    [file("height = 0.6\ngaps = [\n  1e-4, # a comment\n]\nx = y"), /^not valid TOML: .* \(at line 5, column 5\)$/],
    [file(`${drop}\nheight = 0.7`), /^not valid TOML: .* \(at line 3,/],
    [file(drop, { balls: ball("0.1").replace("[[balls]]", "[balls]") }), /^balls: got .*, must be a list$/],
    [file("height = 0.6\ngapps = 1e-4"), /^gapps: unknown to this page, must be one of balls, .*gaps/],
    [file("height = 0.6"), /^gaps: missing, must be a list of 1$/],
    [file("gaps = 0"), /^height: missing/],
    [file("height = true\ngaps = 0"), /^height: got true, must be a number in m, or a text with .*cm$/],
    [file('height = "20 inch"\ngaps = 0'), /^height: got “20 inch”, must be/],
    [file("height = inf\ngaps = 0"), /^height: got Infinity/],
    [file('height = "a\\nb"\ngaps = 0'), /^height: got “a b”/],
    [file("height = 0.6\ngaps = [1e-4, 1e-4]"), /^gaps: got \[0.0001,0.0001\], must be a list of 1$/],
    [
      file(drop, { balls: ball("0.1") + ball("0.01", "density = 840\nmass = 1") }),
      /^balls\[1\]\.density \| mass: got both/,
    ],
    [file(drop, { balls: ball("0.1") + ball("0.01", "") }), /^balls\[1\]\.density \| mass: missing/],
    [file(drop, { laws: law + law.replace("[law]", "[[laws]]") }), /^law \| laws: got both/],
    [file(drop, { laws: "" }), /^law \| laws: missing/],
    [file(drop, { laws: `${law}damping = 3\n` }), /^law\.damping: unknown to this page/],
    [file(drop, { laws: law.replace("linear", "Linear") }), /^law\.name: got “Linear”, must be one of linear/],
    [file(drop, { laws: law.replace("restitution = 0.7", "") }), /^law\.restitution: missing/],
    [
      file(drop, { laws: law.replace("5e7", '"50 N/mm"') }),
      /^law\.stiffness: got “50 N\/mm”, must be a number in N\/m/,
    ],
    [file("height = 0.6\ngaps = -1e-4"), /^gaps: got -0\.0001, must be ≥ 0$/],
    [file(`${drop}\ngravity = -1`), /^gravity: got -1, must be ≥ 0$/],
    [file(drop, { balls: ball("0.1") + ball("-0.01") }), /^balls\[1\]\.radius: got -0\.01, must be > 0$/],
    [file(drop, { balls: ball("0.1") + ball("0.0") }), /^balls\[1\]\.radius: got 0, must be > 0$/],
    [file(drop, { laws: law.replace("0.7", "1.5") }), /^law\.restitution: got 1\.5, must be > 0 and ≤ 1$/],
    [file(drop, { laws: law.replace("5e7", "-5e7") }), /^law\.stiffness: got -50000000, must be > 0$/],
    [file(`${cradle}\nheight = 0.6`, { balls: three }), /^height: got 0\.6, must be left out for a cradle$/],
    [file(`${cradle}\ngravity = 9.81`, { balls: three }), /^gravity: got 9\.81, must be 0 or left out/],
  ])
    assert.throws(
      () => lib.fromToml(text, []),
      ({ message }) => said.test(message) && !message.includes("\n"),
      text,
    );
});

test("values of a TOML file outside the ranges of the page are moved with a note, and are in the link", () => {
  const two = law.replace("[law]", "[[laws]]");
  for (const [text, said] of [
    [file("height = 600\ngaps = 1e-4"), /^height = 600 is outside 0\.01 … 10: 10 used$/],
    [file("height = 0.6\ngaps = [1e-12]"), /^gaps\[0\] = 1e-12 is outside 0 and 1e-8 … 1: 0 used$/],
    [file(drop, { laws: law.replace("0.7", "0.01") }), /^law\.restitution = 0\.01 is outside 0\.02 … 1: 0\.02 used$/],
    [file(`${drop}\nvelocities = [0, -1]`), /^a drop starts from rest on this page/],
    [file(`${drop}\ngravity = 1.62`), /^gravity = 1\.62 m\/s² is not 9\.81/],
    [file(drop, { laws: two + two.replace("0.7", "0.5") }), /^restitution: the contacts differ/],
    [
      file(cradle, { balls: three, laws: two + two.replace("5e7", "1e6") }),
      /^in a cradle all contacts have the same law/,
    ],
    [file(drop), null],
    [file(drop, { balls: ball("0.1") + ball("0.25", 'mass = "5 g"') }), null],
    [
      file(
        '"height" = 0x1\r\ngaps = [\r\n  "0.1 mm", # one\r\n]\r\nlaw = { name = "linear", stiffness = 5e7, ' +
          "restitution = 0.7 }",
        { laws: "" },
      ),
      null,
    ],
    [
      file(`${drop}\nlaw.name = "linear"\nlaw.stiffness = "50 MN/m"\nlaw.restitution = 0.7`, {
        balls: ball("0.1", 'density = "840 kg/m^3"').repeat(2),
        laws: "",
      }),
      null,
    ],
  ]) {
    const notes = [];
    const s = lib.fromToml(text, notes);
    if (said) assert.match(notes[0], said);
    assert.equal(notes.length, said ? 1 : 0, `${text}: ${notes}`);
    const q = new URLSearchParams();
    lib.toQuery(s, q);
    const again = lib.paper();
    lib.fromQuery(again, q, notes);
    assert.equal(notes.length, said ? 1 : 0, String(notes));
    assert.deepEqual(again, s, text);
  }
});

test("each contact has its own law in the core, the link and the file", () => {
  const s = lib.copyOf(lib.presets[0].scenario);
  assert.ok(Math.abs(s.own.stiffness[0] - 13_600) < 400, String(s.own.stiffness)); // 42 and 20 kN/m in series
  const height = (x) => lib.solve(core, x).newton.peaks[1];
  const same = { ...s, own: {} };
  assert.ok(
    height(s) > 0.577 + 0.1 && height(same) < 0.5,
    "with both balls in series it rises above its release, with one stiffness it does not",
  );
  const q = new URLSearchParams();
  lib.toQuery(s, q);
  assert.equal(q.get("k"), `42000,${s.own.stiffness[0]}`);
  const again = lib.paper();
  lib.fromQuery(again, q, []);
  assert.deepEqual(again.own, s.own);
  assert.equal(lib.toToml(s).match(/\[\[laws\]\]/g).length, 2);
});

test("the map: zooming keeps a point in its place, moving keeps the size, and neither leaves the limits", () => {
  const random = randomness(12);
  const share = ([low, high], x) => (x - low) / (high - low);
  const logs = (y) => y.map(Math.log);
  for (let i = 0; i < 300; i++) {
    const limits = lib.mapLimits(i % 2 ? "gap" : "ratio");
    const part = ([low, high]) => [random(), random()].sort((a, b) => a - b).map((u) => low + u * (high - low));
    const box = { x: part(limits.x), y: part(logs(limits.y)).map(Math.exp) };
    const at = [box.x[0] + random() * (box.x[1] - box.x[0]), box.y[0] * (box.y[1] / box.y[0]) ** random()];
    const near = lib.zoomed(box, limits, 1 + random(), at);
    assert.ok(Math.abs(share(near.x, at[0]) - share(box.x, at[0])) < 1e-6);
    assert.ok(Math.abs(share(logs(near.y), Math.log(at[1])) - share(logs(box.y), Math.log(at[1]))) < 1e-6);
    const moved = lib.panned(box, limits, 4 * random() - 2, 4 * random() - 2);
    assert.ok(Math.abs(moved.x[1] - moved.x[0] - (box.x[1] - box.x[0])) < 1e-9);
    assert.ok(Math.abs(moved.y[1] / moved.y[0] / (box.y[1] / box.y[0]) - 1) < 1e-9);
    for (const { x, y } of [near, moved, lib.zoomed(box, limits, 0.01, at)])
      assert.ok(
        x[0] >= limits.x[0] - 1e-12 &&
          x[1] <= limits.x[1] + 1e-12 &&
          y[0] >= limits.y[0] * (1 - 1e-12) &&
          y[1] <= limits.y[1] * (1 + 1e-12),
      );
  }
});

// Lines of agreement of every kind: [gap of the column at ε], as agreement_gaps() of the core has them.
const lines = (random) => [
  () => 1e-3,
  (e) => 1e-4 * 30 ** e,
  (e) => 1e-4 * 1e4 ** (e * e), // from the bottom to the top
  (e) => (e > 0.5 ? 2e-3 : Infinity),
  (e, i) => (i === 20 ? 1e-3 : NaN), // a single column
  () => 1e-6, // everything agrees
  () => 9.9e-3, // at the upper edge
  () => [1e-3 * random(), Infinity, NaN, -1e-3][Math.floor(4 * random())],
  () => Infinity,
  () => NaN,
  () => -1e-3,
  (e) => (e > 0.5 ? Infinity : NaN),
];

test("the map: both sides of the line have names, clear of it and of the mark, in every window", () => {
  const random = randomness(41);
  const kinds = new Set();
  for (const gapAt of lines(random))
    for (const [w, h] of [
      [340, 300],
      [390, 500],
      [760, 260],
      [1280, 700],
      [2500, 1300],
    ]) {
      const points = Array.from({ length: 64 }, (_, i) => 0.05 + (0.95 * i) / 63).map((restitution, i) => ({
        restitution,
        gap: gapAt(restitution, i),
      }));
      const mark = [0.05 + 0.95 * random(), 1e-6 * 1e4 ** random()];
      const g = new Canvas();
      const size = lib.fontSize(w);
      const f = { left: 60, top: 30, width: w - 80, height: h - 100 };
      const x = new lib.Scale(0.05, 1, f.left, f.left + f.width);
      const y = new lib.Scale(1e-6, 1e-2, f.top + f.height, f.top, true);
      lib.drawTrust(new lib.Pen(g, theme, size), { points, tolerance: 0.01 }, x, y, f, mark);
      const { above, below, none } = lib.regionNames(points, 0.01);
      const texts = g.drawn.filter(({ kind }) => kind === "text");
      const where = `${gapAt}, ${w} × ${h}, mark ${mark}`;
      const line = points.filter(({ gap }) => gap > 0 && gap < Infinity).map((p) => [x.at(p.restitution), y.at(p.gap)]);
      for (const { text, left, right, top, bottom } of texts) {
        kinds.add(text);
        assert.ok(left >= f.left && right <= f.left + f.width && top >= f.top && bottom <= f.top + f.height, where);
        const [mx, my] = [x.at(mark[0]), y.at(mark[1])];
        assert.ok(
          mx < left - 8 || mx > right + 8 || my < top - 8 || my > bottom + 8,
          `${text} over the mark: ${where}`,
        );
        for (const [, py] of line.filter(([px]) => px >= left && px <= right))
          assert.ok(above.includes(text) ? bottom < py : top > py, `${text} on the wrong side: ${where}`);
      }
      // A region with room for a name has one.
      const room = [
        Math.min(...line.map(([, py]) => py)) - f.top,
        f.top + f.height - Math.max(...line.map(([, py]) => py)),
      ];
      const wide = line.length === 64;
      [above, below].forEach((names, i) => {
        if (wide && room[i] > 6 * size)
          assert.ok(
            texts.some(({ text }) => names.includes(text)),
            `${names[0]}: ${where}`,
          );
      });
      assert.equal(none.length > 0, line.length === 0, where);
      if (none.length > 0) assert.ok(texts.length === 1 && none.includes(texts[0].text), where);
      const words = lib.mapInWords("effective", 4, { points, tolerance: 0.01 });
      assert.match(words, /^Colours: effective ε over ε: 0 to 1\. [A-Z]?.*(?:trusted|line|compare).*\.$/, words);
    }
  assert.ok(kinds.size >= 7, [...kinds].join());
  assert.equal(lib.mapInWords("count", 4, null), "Colours: ball–ball contacts (Newton): 0 to 4.");
});
