// What the page loads besides itself.

// The script of a worker, kept in memory once it is loaded: later workers need no network.
export class Script {
  url: string;

  constructor(file: string) {
    this.url = new URL(file, import.meta.url).href;
  }

  keep(): void {
    // Without it, workers go on loading the file, and say so if they cannot.
    fetch(this.url)
      .then(async (answer) => answer.ok && (this.url = URL.createObjectURL(await answer.blob())))
      .catch(() => undefined);
  }
}

export async function compiled(file: string): Promise<WebAssembly.Module> {
  const url = new URL(file, import.meta.url);
  return WebAssembly.compileStreaming(fetch(url)).catch(async () =>
    WebAssembly.compile(await (await fetch(url)).arrayBuffer()),
  );
}
