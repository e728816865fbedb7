// Axes of the map, its CSV file, the pen of SVG pictures, without a browser. What the map says at a point is what the
// page says of the setting there, for every pair of axes.
import assert from "node:assert/strict";
import { test } from "node:test";
import { load, random } from "./modules.mjs";
import { randomScenario } from "./scenarios.mjs";

const lib = await load("axes", "map_points", "map_box", "view", "tables_csv", "svg_pen", "rises", "toml");
const { axes, core, copyOf, hasAxis, mapAxes, mapPoints, MAP_VALUES, Model, paper, placed } = lib;

const pairs = mapAxes.flatMap((x) => mapAxes.filter((y) => y !== x).map((y) => [x, y]));
const pairSetting = (next) => {
  for (;;) {
    const s = randomScenario(next, lib);
    if (s.balls.length === 2 && !s.cradle) return s;
  }
};
// A value of an axis, not far from that of the setting.
const near = (next, s, axis) => {
  const [low, high] = axes[axis].limits(s);
  const x = axes[axis].log ? Math.max(axes[axis].get(s), low) * 10 ** (next() - 0.5) : 0.3 + 0.7 * next();
  return Math.min(Math.max(x, low), high);
};

test("each axis: what is put is read, and nothing else of the setting changes", () => {
  const next = random(61);
  for (let i = 0; i < 200; i++) {
    const s = randomScenario(next, lib);
    for (const axis of mapAxes.filter((name) => hasAxis(s, name))) {
      const x = near(next, s, axis);
      const moved = placed(s, [[axis, x]]);
      if (!moved) continue; // the ball would start in the floor
      const where = `${axis} = ${x} in ${JSON.stringify(s)}`;
      assert.ok(Math.abs(axes[axis].get(moved) / x - 1) < 1e-12, where);
      for (const other of mapAxes.filter((name) => name !== axis && hasAxis(s, name))) {
        if (axis === "ratio" && other === "mass") continue; // at constant density
        const [before, after] = [s, moved].map((at) => axes[other].get(at));
        assert.ok(Math.abs(after - before) <= 1e-12 * Math.abs(before), `${other} after ${where}`);
      }
      const chosen = axes[axis].rounded(s, x);
      assert.ok(Math.abs(chosen / x - 1) < 6e-4 || chosen < x, where);
    }
  }
});

test("a point of the map is the solution of its setting, on every pair of axes", () => {
  const next = random(62);
  let known = 0;
  for (const [x, y] of pairs)
    for (let i = 0; i < 3; i++) {
      const scenario = pairSetting(next);
      const points = Float64Array.from({ length: 8 }, (_, k) => near(next, scenario, k % 2 ? y : x));
      const values = mapPoints(core, { scenario, axes: [x, y], tolerance: null, points });
      for (let k = 0; k < 4; k++) {
        const moved = placed(scenario, [
          [x, points[2 * k]],
          [y, points[2 * k + 1]],
        ]);
        const [count, effective, separation] = values.subarray(MAP_VALUES * k);
        const where = `${x} = ${points[2 * k]}, ${y} = ${points[2 * k + 1]} of ${JSON.stringify(scenario)}`;
        if (!moved) {
          assert.ok(Number.isNaN(count), where);
          continue;
        }
        core.set(moved);
        const run = core.solve(Model.newton);
        if (!run || run.outcome === lib.failures.invalid || run.outcome >= lib.failures.unresolved) {
          assert.ok(Number.isNaN(count), where);
          continue;
        }
        known++;
        assert.equal(count, run.nContacts, where);
        for (const [a, b] of [
          [effective, run.effective],
          [separation, run.effectiveSeparation],
        ])
          assert.ok(
            Number.isNaN(a) ? Number.isNaN(b) : Math.abs(a * moved.restitution - b) < 1e-5,
            `${where}: ${a * moved.restitution}, ${b}`,
          );
      }
    }
  assert.ok(known > 200, String(known));
});

test("the verdict on the map is that of the page", () => {
  const next = random(63);
  for (let i = 0; i < 60; i++) {
    const scenario = randomScenario(next, lib);
    const [x, y] = pairs[Math.floor(next() * pairs.length)];
    if (!hasAxis(scenario, x) || !hasAxis(scenario, y)) continue;
    const tolerance = [0.001, 0.01, 0.1][i % 3];
    const points = Float64Array.of(near(next, scenario, x), near(next, scenario, y));
    const [, , , answer, error] = mapPoints(core, { scenario, axes: [x, y], tolerance, points });
    const moved = placed(scenario, [
      [x, points[0]],
      [y, points[1]],
    ]);
    if (!moved) assert.ok(Number.isNaN(answer));
    else {
      const solved = lib.solve(core, moved, tolerance);
      if ("reason" in solved) assert.ok(Number.isNaN(answer));
      else {
        assert.equal(lib.answers[answer], solved.comparison.answer, JSON.stringify(moved));
        assert.ok(Object.is(error, solved.comparison.error));
      }
    }
  }
});

test("the link keeps both axes; older links mean what they meant", () => {
  const read = (text) => {
    const [view, notes] = [lib.firstView(), []];
    lib.viewFromQuery(view, new URLSearchParams(text), notes, paper());
    return { ...view.map, notes };
  };
  for (const [across, axis] of pairs)
    for (const show of lib.mapShows) {
      const view = lib.firstView();
      const zoom = { x: axes[across].limits(paper()), y: axes[axis].limits(paper()) };
      Object.assign(view.map, { across, axis, show, zoom });
      const q = new URLSearchParams();
      lib.viewToQuery(view, q);
      const { notes, ...map } = read(q.toString());
      assert.deepEqual(notes, [], q.toString());
      assert.deepEqual({ ...map, zoom: null }, { across, axis, show, zoom: null }, q.toString());
      map.zoom.x.concat(map.zoom.y).forEach((x, i) => assert.ok(Math.abs(x / [...zoom.x, ...zoom.y][i] - 1) < 1e-5));
    }
  assert.deepEqual(read("map=ratio&show=effective&zoom=0.1,0.5,2,20"), {
    axis: "ratio",
    across: "e",
    show: "effective",
    zoom: { x: [0.1, 0.5], y: [2, 20] },
    notes: [],
  });
  assert.equal(read("map=e").across, "gap");
  assert.match(read("map=k&across=k").notes[0], /across = k is the other axis of the map too: e used/);
  assert.match(read("across=speed").notes[0], /none of gap, ratio, e, k, mass, h/);
});

test("zooming and moving keep within the limits of every pair of axes", () => {
  const next = random(64);
  for (const [across, axis] of pairs) {
    const limits = lib.mapLimits(axis, across);
    const logs = [axes[across].log, axes[axis].log];
    let box = limits;
    for (let i = 0; i < 60; i++) {
      const at = [box.x, box.y].map(([low, high]) => low + next() * (high - low));
      box =
        next() < 0.5
          ? lib.zoomed(box, limits, 4 ** (next() - 0.3), at, logs)
          : lib.panned(box, limits, next() - 0.5, next() - 0.5, logs);
      for (const key of ["x", "y"])
        assert.ok(
          limits[key][0] <= box[key][0] && box[key][0] < box[key][1] && box[key][1] <= limits[key][1],
          `${across} ${axis}`,
        );
    }
  }
});

test("the whole map does not change when a point of it is chosen, but for the decades of the gap over ε", () => {
  const next = random(65);
  for (let i = 0; i < 100; i++) {
    const s = pairSetting(next);
    for (const [across, axis] of pairs) {
      if ([across, axis].includes("e") && [across, axis].includes("gap")) continue;
      const whole = lib.wholeMap(s, axis, 1e-3, 3, across);
      for (const { x, y } of [whole]) assert.ok(x[0] < x[1] && y[0] < y[1] && x[0] > 0 && y[0] > 0);
      const inside = ([low, high], log) => (log ? low * (high / low) ** next() : low + next() * (high - low));
      const moved = placed(s, [
        [across, inside(whole.x, axes[across].log)],
        [axis, inside(whole.y, axes[axis].log)],
      ]);
      if (!moved || moved.height < lib.lowestHeight(moved) || across === "ratio" || axis === "ratio") continue;
      assert.deepEqual(lib.wholeMap(moved, axis, 2e-2, 3, across), whole, `${across} ${axis}`);
    }
  }
});

// ---- files ----------------------------------------------------------------------------------------------------

const parsed = (text) => {
  const lines = text.trimEnd().split("\n");
  const rows = lines.filter((line) => !line.startsWith("#")).map((line) => line.split(","));
  return {
    comments: lines.filter((line) => line.startsWith("#")),
    head: rows[0],
    rows: rows.slice(1).map((row) => row.map(Number)),
  };
};

test("the CSV files of the curve and of the map contain the setting and the core's values", () => {
  const s = copyOf(paper());
  const points = [1e-5, 1e-3].map((gap) => {
    const [newton, icm] = lib.risesOf(core, [lib.columnOf(placed(s, [["gap", gap]]))]);
    return { x: gap, newton, icm };
  });
  const curve = parsed(lib.curveCsv(s, "gap", points, { x: 0, newton: 0.5, icm: NaN }));
  assert.deepEqual(curve.head, ["gap_m", "newton_top_ball_height_m", "icm_top_ball_height_m"]);
  assert.deepEqual(curve.rows, [[0, 0.5, NaN], ...points.map((p) => [p.x, p.newton, p.icm])]);
  const setting = curve.comments.slice(0, -1).map((line) => line.slice(2));
  assert.deepEqual(lib.fromToml(setting.join("\n"), []), s, "the comments are the TOML file of the setting");
  const values = mapPoints(core, { scenario: s, axes: ["k", "h"], tolerance: 0.01, points: Float64Array.of(1e6, 0.3) });
  const map = parsed(lib.mapCsv(s, "k", "h", 0.01, [[1e6, 0.3, ...values]]));
  assert.deepEqual(map.head.slice(0, 3), ["stiffness_N_per_m", "height_m", "newton_contacts"]);
  assert.deepEqual(map.rows, [[1e6, 0.3, ...values]]);
  assert.ok(map.comments.some((line) => line.includes("0 yes, 1 by luck, 2 no, 3 undecided")));
  assert.equal(parsed(lib.mapCsv(s, "e", "gap", null, [[0.5, 1e-4, 1, 0.5, 0.5, NaN, NaN]])).head.length, 5);
});

test("the pen of SVG pictures: styles, clips, dashes and places of text", () => {
  const pen = new lib.SvgPen(100, 50, (text) => 10 * text.length);
  pen.font = '650 20px "Noto Sans", serif';
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  pen.fillStyle = "red";
  pen.fillText("a < b & c", 30, 20);
  pen.save();
  pen.beginPath();
  pen.rect(0, 0, 10, 10);
  pen.clip();
  pen.globalAlpha = 0.5;
  pen.setLineDash([3, 4]);
  pen.beginPath();
  pen.moveTo(1, 2);
  pen.lineTo(NaN, 3);
  pen.lineTo(4, 5.12345);
  pen.stroke();
  pen.restore();
  pen.fillRect(1, 2, 3, 4);
  const text = pen.toString("T", "D & E", "#fff");
  assert.match(
    text,
    /^<svg xmlns="http:\/\/www.w3.org\/2000\/svg" width="100" height="50" viewBox="0 0 100 50" role="img">/,
  );
  assert.match(text, /<title>T<\/title><desc>D &amp; E<\/desc>/);
  assert.match(
    text,
    /<text x="30" y="27" text-anchor="end" font-family="&quot;Noto Sans&quot;, serif" font-size="20" font-weight="650" fill="red">a &lt; b &amp; c<\/text>/,
  );
  assert.match(
    text,
    /<path d="M1 2L4 5.123" fill="none" stroke="#000000" stroke-width="1" stroke-linejoin="miter" stroke-dasharray="3 4" opacity="0.5" clip-path="url\(#clip1\)"\/>/,
  );
  assert.match(text, /<rect x="1" y="2" width="3" height="4" fill="red"\/>/);
  assert.equal(pen.measureText("abc").width, 30);
});
