// Names, units and ranges on the page are those of the core's tables.
import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./modules.mjs";

const lib = await load("compare", "tables");
const { constants, constantsOf, labelOf, laws, models, parameterOfColumn, paper, ranges, symbolOf, unitOf } = lib;

test("labels, symbols and units are those of the core", () => {
  const told = ["gap", "radius", "mass", "density", "height", "velocity"].map((name) => [
    labelOf(parameterOfColumn(name)),
    ranges[name].unit,
  ]);
  assert.deepEqual(told, [
    ["Gap between neighbouring balls Δh", "m"],
    ["Radius R", "m"],
    ["Mass m", "kg"],
    ["Density", "kg/m³"],
    ["Height of the lowest centre", "m"],
    ["Velocity", "m/s"],
  ]);
  assert.equal(symbolOf(parameterOfColumn("gap")), "Δh");
  for (const law of laws)
    assert.equal(labelOf(lib.restitutionOf({ ...paper(), law: law.name })), "Coefficient of restitution ε");
  for (const law of laws)
    for (const p of law.parameters.filter((p) => p.name !== "restitution")) {
      const { label, range, symbol } = constants[p.name];
      assert.equal(label, labelOf(p));
      assert.equal(range.unit, unitOf(p));
      assert.ok(/^\p{Lu}.*[^ ,;]$/u.test(label) && symbol.length <= 3, `${law.name}: ${label}, ${symbol}`);
    }
  assert.throws(() => parameterOfColumn("colour"), /the core knows no colour/);
});

test("sliders stay within what the core takes", () => {
  const within = ({ low, high, zero }, { name, lowest, highest }) => {
    assert.ok(
      (zero ? 0 : low) >= (lowest ?? -Infinity) && high <= (highest ?? Infinity),
      `${name}: ${low} … ${high}, the core ${lowest} … ${highest}`,
    );
  };
  for (const [name, range] of Object.entries(ranges))
    if (name !== "restitution") within(range, parameterOfColumn(name));
  for (const law of laws)
    for (const p of law.parameters) within(p.name === "restitution" ? ranges.restitution : constants[p.name].range, p);
});

test("models are numbered and named as in the core", () => {
  assert.deepEqual(
    models.map((m) => lib.Model[m.name]),
    [0, 1, 2],
  );
  assert.deepEqual(
    [lib.newton.label, lib.newton.short, lib.independent.label, lib.independent.short],
    ["Newton’s equations", "Newton", "independent collisions", "ICM"],
  );
});

test("a change of any parameter is told by its name", () => {
  for (const law of laws.map((l) => l.name))
    for (const name of constantsOf({ ...paper(), law })) {
      const [a, b] = [
        { ...paper(), law },
        { ...paper(), law },
      ];
      b.constants = { ...b.constants, [name]: 1.5 * b.constants[name] };
      assert.deepEqual(
        lib.differences(a, b).map(([told]) => told),
        [constants[name].label],
      );
    }
});
