// Scripts of workers, and WebAssembly modules.

// The script of a worker. It is kept in memory, so that later workers need no network.
export class Script {
  url: string;

  constructor(file: string) {
    this.url = new URL(file, import.meta.url).href;
  }

  keep(): void {
    // If this fails, workers load the file and report an error if they cannot.
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
