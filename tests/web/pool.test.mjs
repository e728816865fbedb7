// The order of requests in the pool, with workers that answer on command.
import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./modules.mjs";

const workers = [];
globalThis.Worker = class {
  constructor() {
    workers.push(this);
  }
  requests = [];
  terminate() {}
  postMessage(message) {
    if (message?.kind) this.requests.push(message);
  }
  answer(answer) {
    this.onmessage({ data: { id: this.requests.at(-1).id, ms: 1, answer } });
  }
};
Object.defineProperty(globalThis, "navigator", { value: { hardwareConcurrency: 2 }, configurable: true });
const { Desk, Pool } = await load("pool");

test("nothing is computed for a picture that is not shown, until it is", () => {
  workers.length = 0;
  const pool = new Pool({});
  const left = { seen: 2, hidden: 2 };
  const done = [];
  let visible = false;
  for (const [name, shown] of [
    ["hidden", () => visible],
    ["seen", () => true],
  ])
    pool.add(() => (left[name]-- > 0 ? { kind: "points", ask: name, done: () => done.push(name) } : null), shown);
  pool.wake();
  assert.deepEqual(
    workers.map((w) => w.requests.map((m) => m.ask)),
    [["seen"], ["seen"]],
  );
  for (const w of workers) w.answer([]);
  assert.deepEqual(done, ["seen", "seen"]);
  assert.equal(left.hidden, 2);
  visible = true;
  pool.wake();
  for (const w of workers) w.answer([]);
  assert.deepEqual(done, ["seen", "seen", "hidden", "hidden"]);
});

test("what somebody waits for comes first", async () => {
  workers.length = 0;
  const pool = new Pool({});
  pool.add(
    () => ({ kind: "points", ask: "picture", done() {} }),
    () => true,
  );
  pool.wake();
  const waiting = pool.ask("csv", "file");
  for (const w of workers) w.answer("text");
  assert.deepEqual(
    workers[0].requests.map((m) => m.ask),
    ["picture", "file"],
  );
  workers[0].answer("text");
  assert.equal(await waiting, "text");
});

test("a worker that cannot be loaded is told of, and hired anew for the next question", () => {
  workers.length = 0;
  const desk = new Desk(() => ({}));
  const told = [];
  const work = (ask) => ({
    kind: "solve",
    ask,
    done: (answer) => told.push(answer),
    failed: (error) => told.push(error),
  });
  desk.put(work("first"));
  desk.giveUp();
  workers[1].onerror({}); // before the first request
  desk.put(work("second"));
  assert.deepEqual(
    workers[2].requests.map((m) => m.ask),
    ["second"],
  );
  workers[2].onerror({});
  assert.match(told[0], /worker\.js could not be loaded/);
  assert.equal(desk.waits, false);
  desk.put(work("third"));
  workers[3].answer("solved");
  assert.equal(told[1], "solved");
});

for (const early of [true, false])
  test(`the first worker is not asked again, and its answer is used if it comes ${early ? "before" : "after"} the page`, () => {
    workers.length = 0;
    const first = { worker: new Worker(), early: [], hear: (event) => void first.early.push(event) };
    const reply = { data: { id: 1, ms: 1, answer: "of the link" } };
    if (early) first.hear(reply);
    const told = [];
    const desk = new Desk(() => assert.fail("no other worker is needed"), first);
    for (const ask of ["link", "next"]) desk.put({ kind: "solve", ask, done: (answer) => told.push(answer) });
    if (!early) {
      assert.deepEqual([told, workers[0].requests], [[], []]);
      first.hear(reply);
    }
    assert.deepEqual(told, ["of the link"]);
    assert.deepEqual(
      workers[0].requests.map((m) => m.ask),
      ["next"],
    );
    first.hear({ data: { id: 2, ms: 1, answer: "of the next" } });
    assert.deepEqual(told, ["of the link", "of the next"]);
    assert.equal(workers.length, 1);
  });
