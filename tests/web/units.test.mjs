// Clock, format and drop without a browser.
import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./modules.mjs";

const {
  Clock,
  windowsOf,
  digits,
  withUnit,
  parse,
  niceTicks,
  logTicks,
  lengths,
  core,
  solve,
  dropOf,
  paper,
  fromQuery,
  Model,
  massOf,
} = await load();

test("the clock runs through every instant, slow in the windows, and back", () => {
  const windows = windowsOf(
    [
      { pair: 0, begin: 0, end: 7e-4 },
      { pair: 1, begin: 2e-4, end: 2.2e-4 },
    ],
    1e-3,
  );
  assert.equal(windows.length, 1);
  const clock = new Clock(-0.3, 0.4, windows);
  assert.ok(clock.rate(3e-4) < 1e-3 && clock.rate(-0.3) === 1 && clock.rate(0.4) === 1);
  let last = -Infinity;
  for (let i = 0; i <= 1000; i++) {
    const time = clock.toPhysical((clock.length * i) / 1000);
    assert.ok(time >= last);
    assert.ok(Math.abs(clock.toScreen(time) - (clock.length * i) / 1000) < 1e-9 * clock.length);
    last = time;
  }
  assert.equal(clock.toPhysical(-1), -0.3);
  assert.equal(clock.toPhysical(1e9), 0.4);
  assert.equal(new Clock(0, 2, []).length, 2);
});

test("a contact that never ends lasts to the end of what is known", () => {
  const [window] = windowsOf([{ pair: 0, begin: 0, end: NaN }], 0.02);
  assert.ok(window.begin < 0 && window.end > 0.02);
});

test("numbers with units are read as they are written", () => {
  for (const [x, unit, text] of [
    [1e-4, "m", "100 µm"],
    [0.012, "m", "1.2 cm"],
    [5e7, "N/m", "50 MN/m"],
    [2.9e-3, "kg", "2.9 g"],
    [0, "m", "0 m"],
    [NaN, "m", "–"],
    [0.9999999, "m", "1 m"],
    [-3e-9, "s", "−3 ns"],
  ])
    assert.equal(withUnit(x, unit), text);
  for (const unit of ["m", "kg", "s", "N", "Pa", "N/m", "m/s"])
    for (let k = -26; k <= 26; k++) {
      const x = 1.23 * 10 ** (k / 3);
      assert.ok(Math.abs(parse(withUnit(x, unit, 6), unit) / x - 1) < 1e-5, `${x} ${unit}: ${withUnit(x, unit, 6)}`);
    }
  assert.equal(parse("0,25 mm", "m"), 0.25e-3);
  for (const text of ["", "m", "1 kg", "1..2", "1e"]) assert.ok(Number.isNaN(parse(text, "m")), text);
  assert.equal(digits(1.5e-7), "1.5·10⁻⁷");
  assert.deepEqual(lengths(0.484, 1.99), ["0.484 m", "1.99 m"]);
  assert.deepEqual(lengths(NaN, 0.3), ["–", "30.0 cm"]);
});

test("ticks lie within, evenly, and few", () => {
  for (const [low, high] of [
    [0, 1],
    [-3.7, 12.1],
    [1e-9, 3e-9],
    [0, 2e5],
  ]) {
    const ticks = niceTicks(low, high, 6);
    assert.ok(
      ticks.length >= 2 &&
        ticks.length <= 9 &&
        ticks[0] >= low - 1e-9 * Math.abs(low) &&
        ticks.at(-1) <= high * (1 + 1e-9),
      `${low} … ${high}: ${ticks}`,
    );
  }
  assert.deepEqual(
    logTicks(1e-6, 1e-2).map((x) => Number(x.toPrecision(12))),
    [1e-6, 1e-5, 1e-4, 1e-3, 1e-2],
  );
});

test("a drop: between its samples the film is the motion", () => {
  for (const query of [
    "",
    "r=0.05,0.03,0.02&gap=1e-4,1e-4&k=1e6",
    "law=viscoelastic",
    "setup=cradle&r=0.02,0.02,0.02&u=1,0,0&gap=0.01,0",
  ]) {
    const scenario = paper();
    fromQuery(scenario, new URLSearchParams(query), []);
    const d = dropOf(solve(core, scenario));
    for (const [name, model] of [
      ["newton", Model.newton],
      ["icm", Model.independent],
    ])
      for (let i = 0; i < 500; i++) {
        const time = d.clock.toPhysical((d.clock.length * (i + 0.37)) / 500);
        const [exact] = core.sample(model, [time]);
        const shown = d.motion[name].at(time);
        const size = scenario.balls[0].radius;
        exact.position.forEach((z, k) =>
          assert.ok(Math.abs(shown.position[k] - z) < 1e-5 * size, `${query} ${name} ${time}`),
        );
        exact.gap.forEach((z, k) => assert.ok(Math.abs(shown.gap[k] - z) < 1e-5 * size));
      }
  }
});

test("a film of slow balls has no more pictures than can be kept", () => {
  const scenario = paper();
  fromQuery(scenario, new URLSearchParams("setup=cradle&u=1e-6,0&gap=1"), []);
  const d = solve(core, scenario);
  for (const { samples, known } of [d.newton, d.icm])
    assert.ok(samples.times.length < 25_000 && samples.times.at(-1) >= Math.min(known, d.stop));
});

test("heights after the second bounce are those of the solver", () => {
  const scenario = paper();
  const solved = solve(core, scenario);
  core.set(scenario);
  core.solve(Model.newton, solved.stop);
  core
    .reboundHeights(Model.newton)
    .forEach((z, i) => assert.ok(Math.abs(solved.newton.later[i] / z - 1) < 1e-6, `${solved.newton.later[i]}, ${z}`));
  assert.ok(solved.newton.later[1] > 0.67 && solved.newton.peaks[1] < 0.49);
});

test("a ball's mass is that of the package", () =>
  assert.equal(massOf({ radius: 0.1, density: 840 }), (4 / 3) * Math.PI * (840 * (0.1 * 0.1 * 0.1))));
