// The page's interface to the worker: one request at a time; a new start may replace the worker.
import { Script } from "../support/script";
import type { Answer, Ask } from "./worker";

const script = new Script("gas_worker.js");
script.keep();
const patience = 1500; // time after which a new start replaces a busy worker [ms]

export class Client {
  private worker: Worker | null = null;
  private id = 0;
  private starts = 0;
  private readonly waiting = new Map<number, (answer: Answer) => void>();

  constructor(private readonly module: Promise<WebAssembly.Module>) {}

  private async ready(): Promise<Worker> {
    const module = await this.module;
    if (this.worker) return this.worker;
    const worker = new Worker(script.url, { type: "module" });
    worker.postMessage(module);
    worker.onmessage = ({ data: { id, answer } }: MessageEvent<{ id: number; answer: Answer }>): void => {
      this.waiting.get(id)?.(answer);
      this.waiting.delete(id);
    };
    return (this.worker = worker);
  }

  async ask<K extends Ask["kind"]>(
    ask: Extract<Ask, { kind: K }>,
  ): Promise<Extract<Answer, { kind: K }> | Extract<Answer, { kind: "error" }>> {
    const worker = await this.ready();
    const id = ++this.id;
    const answer = new Promise<Answer>((done) => this.waiting.set(id, done));
    worker.postMessage({ id, ask });
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
