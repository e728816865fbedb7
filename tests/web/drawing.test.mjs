// Pictures without a browser: in the close-up the balls are apart and above the floor, the bands of the timeline are at
// the contacts, and each picture can be drawn for each setting.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Canvas, crossings, theme } from "./canvas.mjs";
import { load, random } from "./modules.mjs";
import { randomScenario } from "./scenarios.mjs";

const lib = await load(
  "film",
  "forces",
  "map_drawing",
  "pen",
  "plot",
  "presets",
  "rebound_plot",
  "stage",
  "prediction_drawing",
  "timeline",
  "true_scale",
);
const { core } = lib;

// The examples, and random settings that have a solution.
const next = random(31);
const scenarios = [
  ...lib.presets.map((p) => p.scenario),
  ...Array.from({ length: 50 }, () => randomScenario(next, lib)),
];
const drops = scenarios
  .map((scenario) => lib.solve(core, lib.copyOf(scenario)))
  .filter((solved) => !("reason" in solved))
  .map(lib.dropOf);
assert.ok(drops.length > 50);

const momentOf = (d, time) => ({
  time,
  rate: d.clock.rate(time),
  newton: d.motion.newton.at(time),
  icm: d.motion.icm.at(time),
});

// Times of interest: release, begin and middle of contacts, random times, the end.
function instants(d) {
  const contacts = d.newton.run.contacts
    .slice(0, 4)
    .flatMap((c) => [c.begin, 0.5 * (c.begin + (Number.isFinite(c.end) ? c.end : d.newton.run.last))]);
  return [
    d.start,
    ...contacts,
    ...Array.from({ length: 6 }, () => d.clock.toPhysical(d.clock.length * next())),
    d.stop,
  ].filter((t) => t >= d.start && t <= d.stop);
}

const windows = [
  [1440, 700],
  [760, 430],
  [340, 420],
  [290, 360],
  [2500, 1300],
]; // of the film, on a telephone too

test("in words: the contacts, and the time of the film", () => {
  const dropOf = (id) => lib.dropOf(lib.solve(core, lib.copyOf(lib.presets.find((p) => p.id === id).scenario)));
  assert.match(lib.forcesSummary(dropOf("basketball")), /; one contact between balls\.$/);
  const steel = dropOf("steel");
  for (const [time, text] of [
    [-0.0004, "−0.400 ms"],
    [-0.02, "−0.020 s"],
    [5e-6, "5.00 µs"],
  ])
    assert.equal(lib.clockText(steel.origin + time, steel), text);
});

// ---- close-up -----------------------------------------------------------------------------------------------

// Balls of the close-up as [model][ball], with the part along the line that is not clipped, upwards or to the right.
function closeUp(g, d) {
  const begin = g.drawn.findIndex((x) => x.text === "Close-up");
  const balls = g.drawn
    .slice(begin)
    .filter((x) => x.kind === "fill" && x.path.length === 1 && x.path[0].radius !== undefined);
  const n = d.scenario.balls.length;
  assert.equal(balls.length, 2 * n);
  const along = d.scenario.cradle ? (p) => p.x : (p) => -p.y;
  const shown = balls.map(({ path: [circle], clip }) => {
    const edges = clip?.map(along) ?? [-Infinity, Infinity]; // a whole ball is not clipped
    const center = along(circle);
    return {
      center,
      radius: circle.radius,
      low: Math.max(center - circle.radius, Math.min(...edges)),
      high: Math.min(center + circle.radius, Math.max(...edges)),
    };
  });
  return [shown.slice(0, n), shown.slice(n)];
}

function checkBalls(balls, floor, ceiling, where) {
  balls.forEach((b, i) => {
    assert.ok(b.radius >= 3.9, `${where}: ball ${i + 1} has ${b.radius} pixels`);
    assert.ok(b.high - b.low > 0.9 * b.radius, `${where}: half of ball ${i + 1} is in sight`);
    assert.ok(b.low >= floor - 0.01, `${where}: ball ${i + 1} lies ${floor - b.low} pixels below the floor`);
    assert.ok(b.high <= ceiling, `${where}: ball ${i + 1} leaves the picture by ${b.high - ceiling} pixels`);
    if (i > 0)
      assert.ok(
        b.low >= balls[i - 1].high - 0.01,
        `${where}: ball ${i + 1} reaches ${balls[i - 1].high - b.low} pixels into the one below`,
      );
  });
}

// Touching balls touch in the picture, compressed balls are flattened, others are apart.
function checkGaps(balls, gaps, where) {
  for (let i = 1; i < balls.length; i++) {
    const between = balls[i].center - balls[i].radius - (balls[i - 1].center + balls[i - 1].radius);
    if (gaps[i] > 0) assert.ok(between >= -1e-6, `${where}: gap ${gaps[i]} drawn as ${between}`);
    else assert.ok(between <= 1e-6, `${where}: gap ${gaps[i]} drawn as ${between}`);
  }
}

test("close-up: balls stay above the floor, apart and in the picture", () => {
  let cradles = 0;
  for (const d of drops) {
    cradles += Number(d.scenario.cradle);
    const [w, h] = windows[Math.floor(windows.length * next())];
    for (const time of instants(d)) {
      const g = new Canvas();
      const moment = momentOf(d, time);
      lib.drawStage(g, w, h, d, moment, theme);
      const where = `${w} × ${h} at ${time}: ${JSON.stringify(d.scenario)}`;
      const floors = g.drawn.filter(
        (x) => x.kind === "stroke" && x.width === 2.5 && x.color === theme.ink && x.path.length === 2,
      );
      const floor = d.scenario.cradle ? 0 : -(floors.at(-1).path[0].y - 1);
      closeUp(g, d).forEach((balls, k) => {
        checkBalls(balls, floor, d.scenario.cradle ? w : 0, where);
        checkGaps(balls, [moment.newton, moment.icm][k].gap, where);
      });
    }
  }
  assert.ok(cradles > 5);
});

test("close-up: what is written at the contacts overprints nothing", () => {
  for (const d of drops) {
    const [w, h] = windows[Math.floor(windows.length * next())];
    for (const time of instants(d)) {
      const g = new Canvas();
      lib.drawStage(g, w, h, d, momentOf(d, time), theme);
      const texts = g.drawn.slice(g.drawn.findIndex((x) => x.text === "Close-up")).filter((x) => x.kind === "text");
      texts.forEach((a, i) => {
        for (const b of texts.slice(i + 1)) {
          const [over, down] = [
            Math.min(a.right, b.right) - Math.max(a.left, b.left),
            Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top),
          ];
          assert.ok(
            over <= 1 || down <= 1,
            `“${a.text}” over “${b.text}”, ${w} × ${h} at ${time}: ${JSON.stringify(d.scenario)}`,
          );
        }
        assert.ok(
          a.top >= -1 && a.bottom <= h + 1 && a.left >= -1 && a.right <= w + 1,
          `“${a.text}” leaves ${w} × ${h}: ${JSON.stringify(d.scenario)}`,
        );
      });
    }
  }
});

// ---- other pictures of the drop -----------------------------------------------------------------------------

test("forces and the story’s ruler: every number told to the canvas is finite", () => {
  for (const d of drops) {
    for (const [w, h] of windows) {
      const forces = new Canvas();
      lib.drawForces(forces, w, h, d, theme);
      assert.ok(
        forces.drawn.some((x) => x.kind === "stroke" && x.path.length > 100),
        "a curve",
      );
      if (d.scenario.cradle) continue;
      const tale = new Canvas();
      for (const falling of [false, true])
        lib.drawPrediction(
          tale,
          w,
          h,
          { drop: d, falling, guess: 2, ...momentOf(d, d.stop), reached: [d.newton.peaks.at(-1), d.icm.peaks.at(-1)] },
          18,
          theme,
        );
      assert.ok(tale.drawn.some((x) => /guess: 2 m/.test(x.text)));
      for (const number of tale.drawn.filter(
        (x) => x.kind === "text" && (x.color === theme.newton || x.color === theme.icm) && /m$/.test(x.text),
      ))
        assert.ok(
          tale.drawn.some(
            (x) => x.kind === "rect" && x.color === theme.ground && x.x <= number.left && x.x + x.w >= number.right,
          ),
          "a line runs through a number",
        );
    }
  }
});

test("a cradle at true scale: the numbers of its ruler stand apart, in half a small window too", () => {
  for (const d of drops.filter((d) => d.scenario.cradle))
    for (const w of [150, 240, 380, 700]) {
      const g = new Canvas();
      lib.drawTrueScale(g, { x: 0, y: 0, w, h: 200 }, d, momentOf(d, d.start), theme, "A");
      const numbers = g.drawn.filter((x) => x.kind === "text" && x.color === theme.muted && /^[−\d.]+$/.test(x.text));
      assert.ok(numbers.length > 0);
      numbers.forEach(
        (x, i) =>
          i > 0 && assert.ok(x.left >= numbers[i - 1].right + 2, `${w} pixels: ${numbers[i - 1].text} ${x.text}`),
      );
    }
});

test("rebound heights: names and numbers stand clear of each other, on a telephone too", () => {
  const points = Array.from({ length: 40 }, (_, i) => ({ x: 1e-7 * 10 ** (i / 8), newton: 1 + 0.05 * i, icm: 3.6 }));
  const place = { x: 0, newton: 1, icm: 3.6 };
  for (const [w, h] of [
    [262, 330],
    [330, 330],
    [520, 420],
    [760, 430],
    [1700, 900],
  ])
    for (const low of [1e-7, 1e-5])
      for (const [pinned, measured] of [
        [[], null],
        [points, { axis: "gap", list: [{ x: 1e-3, height: 2, uncertainty: 0.1 }] }],
      ])
        for (const cradle of [false, true]) {
          const g = new Canvas();
          const picture = {
            axis: "gap",
            span: { low, high: low * 1e5, log: true },
            points,
            touching: place,
            pinned,
            pinnedTouching: null,
            pinnedAt: null,
            marked: place,
            hovered: null,
            measured,
            released: 1.28,
            cradle,
          };
          lib.drawCurves(g, w, h, picture, theme);
          const texts = g.drawn.filter((x) => x.kind === "text" && !/let go|^A$/.test(x.text));
          texts.forEach((a, i) => {
            for (const b of texts.slice(i + 1)) {
              const [over, down] = [
                Math.min(a.right, b.right) - Math.max(a.left, b.left),
                Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top),
              ];
              assert.ok(over <= 1 || down <= 1, `“${a.text}” over “${b.text}”, ${w} × ${h}`);
            }
          });
        }
});

// Heights of both models over the gap, and their picture, for a drop of two balls.
function heightsOf({ scenario, newton, icm }) {
  const at = (gap) => {
    core.set({ ...lib.copyOf(scenario), gaps: [gap] });
    const height = (model) => (core.solve(model) ? core.reboundHeights(model)[1] : NaN);
    return { x: gap, newton: height(lib.Model.newton), icm: height(lib.Model.independent) };
  };
  const [low, high] = [1e-7, 0.1];
  const points = Array.from({ length: 100 }, (_, i) => at(low * (high / low) ** (i / 99)));
  const marked = { x: scenario.gaps[0], newton: newton.peaks[1], icm: icm.peaks[1] };
  return {
    axis: "gap",
    span: { low, high, log: true },
    points,
    touching: at(0),
    pinned: [],
    pinnedTouching: null,
    pinnedAt: null,
    marked,
    hovered: null,
    measured: null,
    released: 1.2 * scenario.height,
    cradle: false,
  };
}

// Whether the line from a to b crosses a text.
const enters = (a, b, text) =>
  Array.from({ length: 21 }, (_, i) => [a.x + (i / 20) * (b.x - a.x), a.y + (i / 20) * (b.y - a.y)]).some(
    ([x, y]) => x > text.left + 1 && x < text.right - 1 && y > text.top + 2 && y < text.bottom - 2,
  );

test("rebound heights: no curve runs through a number where there is room beside it", () => {
  let written = 0;
  let crossed = 0;
  for (const d of drops.filter(({ scenario: s }) => s.balls.length === 2 && !s.cradle).slice(0, 16)) {
    const picture = heightsOf(d);
    for (const [w, h] of [
      [330, 330],
      [520, 420],
      [760, 430],
      [1700, 900],
    ]) {
      const g = new Canvas();
      lib.drawCurves(g, w, h, picture, theme);
      const curves = g.drawn.filter((x) => x.kind === "stroke" && x.path.length > 50);
      for (const text of g.drawn.filter(
        (x) =>
          x.kind === "text" &&
          (/let go/.test(x.text) || ((x.color === theme.newton || x.color === theme.icm) && /m$/.test(x.text))),
      )) {
        written++;
        if (curves.some(({ path }) => path.some((b, i) => i > 0 && !b.move && enters(path[i - 1], b, text)))) crossed++;
      }
    }
  }
  assert.ok(written > 100 && crossed <= 0.02 * written, `${crossed} of ${written}`);
});

test("map: the numbers below it stand clear of each other, on a telephone too", () => {
  for (const w of [290, 340, 520, 900]) {
    const g = new Canvas();
    const pen = new lib.Pen(g, theme, Math.max(w / 42, 13));
    lib.drawCounts(pen, { left: 60, top: 30, width: w - 70, height: 300 }, 15, true, 400);
    const texts = g.drawn.filter((x) => x.kind === "text");
    assert.equal(texts.at(-1).text, "15+");
    texts.forEach((b, i) =>
      assert.ok(i === 0 || b.left > texts[i - 1].right, `“${texts[i - 1]?.text}” and “${b.text}”, ${w} pixels`),
    );
  }
});

// ---- timeline -----------------------------------------------------------------------------------------------

// Does the work of a pool of workers, one task at a time; `pause` is called after each.
function timelineOf(scenario, pause = () => {}) {
  let source;
  const timeline = new lib.Timeline({ add: (tasks) => (source = tasks), wake() {} }, () => {});
  timeline.start(lib.copyOf(scenario));
  for (let work = source(); work; work = source()) {
    const { column, restitution, adiabatic } = work.ask;
    core.setColumn(column);
    const rows = (model) => core.timeline(model, restitution);
    work.done(
      { newton: rows(lib.Model.newton), adiabatic: adiabatic ? rows(lib.Model.adiabatic) : [] },
      0.1 * restitution.length,
    );
    pause(timeline);
  }
  assert.ok(timeline.done);
  return timeline;
}

const [width, height] = [900, 500];
function drawn(timeline, d) {
  const g = new Canvas();
  const layout = timeline.draw(g, width, height, d, theme);
  const bands = g.drawn.filter((x) => x.kind === "fill" && x.path.length > 3 && /^(?:pair|faint)/.test(x.color));
  return {
    ...layout,
    bands: bands.map(({ path, color }) => ({
      path,
      color,
      top: Math.min(...path.map((p) => p.y)),
      bottom: Math.max(...path.map((p) => p.y)),
    })),
  };
}

// The floor contact exists for each ε. Its band has no gap between the lowest and the highest computed ε.
function checkUnbroken(bands, where) {
  const floor = bands.filter((b) => b.color === theme.faint).sort((a, b) => a.top - b.top);
  floor
    .slice(1)
    .forEach((b, i) =>
      assert.ok(b.top <= floor[i].bottom + 1e-6, `${where}: nothing between ${floor[i].bottom} and ${b.top}`),
    );
}

// A band consists of its left edge, upwards, and its right edge, downwards, which do not cross.
function checkSides(bands, where) {
  for (const { path } of bands)
    for (let i = 0; 2 * i < path.length; i++)
      assert.ok(
        path[path.length - 1 - i].x >= path[i].x,
        `${where}: a contact from ${path[i].x} to ${path[path.length - 1 - i].x}`,
      );
}

// Ranges of pixels in which pair j touches at this ε.
function touching(timeline, layout, j, e) {
  return layout.bands
    .filter((b) => b.color === (j === 0 ? theme.faint : theme.pairs[j]))
    .flatMap(({ path }) => {
      const x = crossings(path, layout.y.at(e));
      return Array.from({ length: x.length / 2 }, (_, i) => [x[2 * i], x[2 * i + 1]]);
    });
}

// A floor contact that never ends begins inside or outside the picture, depending on ε.
const rests = {
  ...lib.paper(),
  law: "tsuji",
  restitution: 0.18,
  height: 0.1463,
  constants: { ...lib.paper().constants, elastic_prefactor: 3.9332607e7 },
  balls: [
    [0.145, 21.85],
    [0.1121, 53.35],
    [0.05377, 892.3],
  ].map(([radius, density]) => ({ radius, density })),
  gaps: [6.62e-5, 9.47e-5],
  velocities: [0, 0, 0],
};
const few = drops.filter(({ scenario: s }) => s.balls.length < 4);
const known = new Set(lib.presets.map((p) => JSON.stringify(p.scenario)));
const examples = few.filter(({ scenario }) => known.has(JSON.stringify(scenario)));
const shown = [
  lib.dropOf(lib.solve(core, lib.copyOf(rests))),
  ...examples.slice(0, 6),
  ...few.filter((d) => !examples.includes(d)).slice(0, 12),
];
const timelines = [];

test("timeline: the floor contact is never pressed into a strip by contacts that come much later", () => {
  const fig5 = lib.presets.find(({ id }) => id === "fig5").scenario;
  const timeline = timelineOf(fig5);
  const { x, frame } = drawn(timeline, lib.dropOf(lib.solve(core, lib.copyOf(fig5))));
  const floor = Math.max(...timeline.rows.map((row) => row.tFloorEnd).filter(Number.isFinite));
  assert.ok(x.at(floor) - x.at(0) > 0.19 * frame.width, `${x.at(floor) - x.at(0)} of ${frame.width} pixels`);
  assert.equal(timeline.goesOn, true);
  assert.equal(timelineOf(lib.presets.find(({ id }) => id === "steel").scenario).goesOn, false);
});

test("timeline: its bands have no holes, however many rows there are", () => {
  for (const d of shown) {
    let rounds = 0;
    const check = (timeline) =>
      d.scenario.cradle || checkUnbroken(drawn(timeline, d).bands, `${rounds}: ${JSON.stringify(d.scenario)}`);
    const timeline = timelineOf(d.scenario, (timeline) => ++rounds % 11 === 1 && check(timeline));
    check(timeline);
    checkSides(drawn(timeline, d).bands, JSON.stringify(d.scenario));
    timelines.push(timeline);
  }
});

// Rows on both sides of ε, and those whose region contains it; regions are half a pixel wider to avoid hairlines.
function rowsAround({ rows }, { y }, e) {
  const border = (a, b) => y.at(0.5 * (a.restitution + (b ?? a).restitution));
  const above = rows.findIndex((r) => r.restitution > e);
  const reaches = (r, i) => y.at(e) <= border(r, rows[i - 1]) + 0.5 && y.at(e) >= border(r, rows[i + 1]) - 0.5;
  return rows.filter((r, i) => i === above - 1 || i === above || reaches(r, i));
}

test("timeline: at any ε the bands are where the balls touch", () => {
  const order = (row) => row.contacts.map((c) => `${c.pair}${Number.isFinite(c.end)}`).join();
  let looked = 0;
  let between = 0;
  shown.forEach((d, k) => {
    const layout = drawn(timelines[k], d);
    for (let i = 0; i < 60; i++) {
      const e = 0.02 + 0.98 * next();
      core.set({ ...lib.copyOf(d.scenario), restitution: e });
      const [row] = core.timeline(lib.Model.newton, [e]);
      if (!rowsAround(timelines[k], layout, e).every((r) => order(r) === order(row))) {
        between++; // contacts between two rows are not known
        continue;
      }
      for (let j = d.scenario.cradle ? 1 : 0; j < d.scenario.balls.length; j++) {
        const where = `pair ${j} at ε = ${e}: ${JSON.stringify(d.scenario)}`;
        const bands = touching(timelines[k], layout, j, e);
        const contacts = row.contacts
          .filter((c) => c.pair === j)
          .map((c) => [
            layout.x.at(c.begin),
            layout.x.at(Number.isFinite(c.end) ? c.end : Math.max(c.begin, layout.x.high)),
          ]);
        const right = layout.frame.left + layout.frame.width;
        const inFrame = (spans) =>
          spans.map(([from, to]) => [from, Math.min(to, right)]).filter(([from, to]) => to - from > 2);
        const covers = (spans, x) => spans.some(([from, to]) => from - 1 <= x && x <= to + 1);
        // A line between two rows may miss narrower contacts.
        for (const [spans, others, what] of [
          [contacts, bands, "no band"],
          [bands, contacts, "no contact"],
        ])
          for (const [from, to] of inFrame(spans)) {
            assert.ok(
              covers(others, 0.5 * (from + to)),
              `${what} at ${0.5 * (from + to)}, ${where}: ${JSON.stringify(contacts)}, ${JSON.stringify(bands)}`,
            );
            looked++;
          }
      }
    }
  });
  assert.ok(looked > 1000 && between < 0.03 * 60 * shown.length, `${looked} looked at, ${between} left out`);
});
