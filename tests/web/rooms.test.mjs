// Rooms of web/src from the lowest to the highest. A file imports, also types, only from its own room and lower ones.
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { join, normalize } from "node:path";
import { test } from "node:test";

const rooms = ["style", "support", "scenario", "core", "report", "state", "views", "map", "story", "app"];
const belowGas = ["style", "support"]; // the page of the gas imports only these

const src = new URL("../../web/src/", import.meta.url).pathname;
const files = readdirSync(src, { recursive: true })
  .map(String)
  .filter((path) => path.endsWith(".ts"));
const imports = (path) =>
  [...readFileSync(join(src, path), "utf8").matchAll(/(?:\bfrom|\bimport)[\s(]*"(\.[^"]*)"/g)].map((match) =>
    normalize(join(path, "..", match[1])),
  );
const roomOf = (path) => path.split("/")[0];

test("imports lead down", () => {
  const allowed = new Map(rooms.map((room, i) => [room, rooms.slice(0, i + 1)])).set("gas", [...belowGas, "gas"]);
  const wrong = [];
  let seen = 0;
  for (const path of files)
    for (const other of imports(path)) {
      seen++;
      if (!allowed.get(roomOf(path))?.includes(roomOf(other))) wrong.push(`${path} → ${other}`);
    }
  assert.ok(seen > 300, `only ${seen} imports were read`);
  assert.deepEqual(wrong, []);
  assert.deepEqual([...new Set(files.map(roomOf))].sort(), [...allowed.keys()].sort());
});
