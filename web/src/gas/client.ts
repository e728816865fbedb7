// The page's interface to its workers: that of the film, one request at a time, which a new start may replace, and
// that of further starts.
import { compiled, Script } from "../support/script";
import type { OneStart } from "./starts";
import type { Answer, Ask, Request } from "./worker";

const script = new Script("gas_worker.js");
script.keep();
const patience = 1500; // time after which a new start replaces a busy worker [ms]

// The modules: that of disks with friction is loaded when they are chosen.
const smooth = compiled("gas.wasm");
let rubbing: Promise<WebAssembly.Module> | null = null;
const moduleFor = ({ friction }: { friction: number }): Promise<WebAssembly.Module> =>
  friction > 0 ? (rubbing ??= compiled("gas_friction.wasm")) : smooth;

type Receive = (answer: Answer) => void;

function newWorker(receive: (id: number, answer: Answer) => void): Worker {
  const worker = new Worker(script.url, { type: "module" });
  worker.onmessage = ({ data: { id, answer } }: MessageEvent<{ id: number; answer: Answer }>): void =>
    receive(id, answer);
  return worker;
}

export class Client {
  private worker: Worker | null = null;
  private id = 0;
  private starts = 0;
  private readonly waiting = new Map<number, Receive>();

  async ask<K extends Ask["kind"]>(
    ask: Extract<Ask, { kind: K }>,
  ): Promise<Extract<Answer, { kind: K }> | Extract<Answer, { kind: "error" }>> {
    const { setting } = ask as Partial<Extract<Ask, { kind: "start" }>>;
    const module = setting && (await moduleFor(setting));
    this.worker ??= newWorker((id, answer) => {
      this.waiting.get(id)?.(answer);
      this.waiting.delete(id);
    });
    const id = ++this.id;
    const answer = new Promise<Answer>((done) => this.waiting.set(id, done));
    this.worker.postMessage({ id, ask, module } satisfies Request);
    return answer as Promise<never>;
  }

  async start(ask: Extract<Ask, { kind: "start" }>): Promise<Extract<Answer, { kind: "start" | "error" }>> {
    const mine = ++this.starts;
    const answer = this.ask(ask);
    const timer = setTimeout(() => {
      if (mine !== this.starts) return; // the newest start replaces the worker
      this.worker?.terminate();
      this.worker = null;
      const [, resolve] = [...this.waiting].at(-1) ?? [];
      this.waiting.clear();
      if (resolve) void this.ask(ask).then(resolve);
    }, patience);
    const result = await answer;
    clearTimeout(timer);
    return result;
  }
}

// Runs further starts of a gas. A new request replaces the last one, whose answers are dropped.
export class StartsClient {
  private worker: Worker | null = null;
  private id = 0;

  async run(ask: Extract<Ask, { kind: "starts" }>, take: (start: OneStart) => void): Promise<void> {
    const id = ++this.id;
    this.receive = (answered, answer) => {
      if (answered === this.id && answer.kind === "starts") take(answer.start);
    };
    const module = await moduleFor(ask.setting);
    if (id !== this.id) return;
    this.worker ??= newWorker((answered, answer) => this.receive(answered, answer));
    this.worker.postMessage({ id, ask, module } satisfies Request);
  }
  private receive: (id: number, answer: Answer) => void = () => {};
}
