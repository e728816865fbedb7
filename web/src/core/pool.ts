// Web workers: a few for maps and curves, one for the drop itself.
import type { Answered } from "./drop";
import type { First, Heard } from "./first";
import { later } from "../support/later";
import { Script } from "../support/script";
import type { Kind, Reply, Request, Tasks } from "./worker";

// A task and its callbacks.
export interface Piece<K extends Kind = Kind> {
  kind: K;
  ask: Tasks[K]["ask"];
  done(answer: Tasks[K]["answer"], ms: number): void;
  begun?(what: string, share: number, known: Answered | null): void;
  failed?(error: string): void;
}

// Returns the next task for a free worker; null: none until Pool.wake().
export type Source = () => Piece | null;

export const piece = <K extends Kind>(p: Piece<K>): Piece => p;

const script = new Script("worker.js");

type Module = WebAssembly.Module;

// One worker with one task at a time. It starts while the core is being compiled. The first worker of the page already
// has its first task.
class Hand {
  lost = false; // the worker could not be loaded (no network or no server)
  private readonly worker: Worker;
  private at: Piece | null = null;
  private id = 0;
  private begun = false; // it has the core
  private waiting: Request | null = null; // for the core
  private early: Heard[] | null = null; // answers of the first worker before the first request

  constructor(
    core: Module | Promise<Module> | First,
    private readonly free: () => void,
  ) {
    if ("worker" in core) {
      this.worker = core.worker;
      this.begun = true;
      this.early = core.early;
      core.hear = (event) => this.hear(event);
      return;
    }
    this.worker = new Worker(script.url, { type: "module" });
    this.worker.onmessage = (event) => this.hear(event);
    this.worker.onerror = (event) => this.hear(event);
    if (core instanceof Promise)
      void core.then(
        (module) => this.begin(module),
        () => undefined,
      ); // the page says so
    else this.begin(core);
  }

  private begin(module: Module): void {
    this.begun = true;
    this.worker.postMessage(module);
    if (this.waiting) this.worker.postMessage(this.waiting);
  }

  get idle(): boolean {
    return this.at === null;
  }
  take(work: Piece): void {
    this.at = work;
    const request: Request = { id: ++this.id, kind: work.kind, ask: work.ask };
    const { early } = this;
    this.early = null;
    if (early)
      early.forEach((event) => this.hear(event)); // the setting of the link is its first request
    else if (this.begun) this.worker.postMessage(request);
    else this.waiting = request;
  }
  end(): void {
    this.worker.terminate();
  }

  private hear(event: Heard): void {
    if ("data" in event) this.receive(event.data);
    else this.fail(event.message);
  }

  // Without a message: the worker could not be loaded.
  private fail(message: string | undefined): void {
    this.lost ||= message === undefined;
    this.receive({
      id: this.id,
      ms: 0,
      error: message ?? "worker.js could not be loaded. Is the server still running?",
    });
  }

  private receive(reply: Reply): void {
    const work = this.at;
    if (!work || reply.id !== this.id) return;
    if (reply.begun) return work.begun?.(reply.begun.what, reply.begun.share, reply.begun.known);
    this.at = null;
    if (reply.error === undefined) work.done(reply.answer as never, reply.ms);
    else if (work.failed) work.failed(reply.error);
    else throw new Error(reply.error);
    this.free();
  }
}

// As many workers as the machine has cores. They are started on demand, because they would delay the first drop.
// Sources take turns.
export class Pool {
  readonly size = Math.min(Math.max(navigator.hardwareConcurrency || 2, 1), 8);
  private readonly hands: Hand[] = [];
  private readonly sources: Source[] = [];
  private readonly urgent: Piece[] = [];
  private turn = 0;

  // Without a module the tasks wait for open().
  constructor(private module: Module | null = null) {}

  open(module: Module): void {
    this.module = module;
    this.wake();
  }

  // A source belongs to a plot and is not asked for tasks while the plot is hidden.
  add(source: Source, shown: () => boolean): void {
    this.sources.push(() => (shown() ? source() : null));
  }

  // Runs before the remaining tasks of the sources.
  ask<K extends Kind>(kind: K, ask: Tasks[K]["ask"]): Promise<Tasks[K]["answer"]> {
    return new Promise((done, refuse) => {
      this.urgent.push(piece<K>({ kind, ask, done, failed: (error) => refuse(new Error(error)) }));
      this.wake();
    });
  }

  wake(): void {
    if (!this.module) return;
    for (let i = 0; i < this.size; i++) {
      const hand: Hand | undefined = this.hands[i];
      if (hand && (!hand.idle || hand.lost)) continue;
      const work = this.next();
      if (!work) return;
      (hand ?? this.hire()).take(work);
    }
  }

  private hire(): Hand {
    const hand = new Hand(this.module!, () => this.wake());
    this.hands.push(hand);
    return hand;
  }

  private next(): Piece | null {
    const first = this.urgent.shift();
    if (first) return first;
    for (let i = 0; i < this.sources.length; i++) {
      const work = this.sources[this.turn++ % this.sources.length]();
      if (work) return work;
    }
    return null;
  }
}

// One worker for the result that the page waits for. Only the newest request counts, and it can be cancelled.
export class Desk {
  private hand: Hand;
  private waiting: Piece | null = null;
  private since = 0;
  // Four times the duration of the last answer [ms], so that a moving slider does not cancel every request.
  private patience = 150;

  // `first`: the worker that opens the page; the module is needed only to replace it.
  constructor(
    private readonly module: () => Module | Promise<Module>,
    first?: First,
  ) {
    this.hand = this.hire(first);
    later(() => script.keep());
  }

  // Replaces the waiting request; a request that has run for long is cancelled.
  put(work: Piece): void {
    this.waiting = work;
    if (this.hand.lost || (!this.hand.idle && performance.now() - this.since > this.patience)) this.replace();
    this.go();
  }

  // Whether a request is unanswered.
  get waits(): boolean {
    return this.waiting !== null || !this.hand.idle;
  }

  giveUp(): void {
    this.waiting = null;
    if (!this.hand.idle) this.replace();
  }

  private go(): void {
    const { waiting } = this;
    if (!this.hand.idle || !waiting) return;
    this.waiting = null;
    this.since = performance.now();
    this.hand.take(waiting);
  }
  private hire(first?: First): Hand {
    return new Hand(first ?? this.module(), () => {
      this.patience = Math.min(Math.max(150, 4 * (performance.now() - this.since)), 1000);
      this.go();
    });
  }
  private replace(): void {
    this.hand.end();
    this.hand = this.hire();
  }
}
