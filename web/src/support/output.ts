// What leaves the page: files and the clipboard.

export function save(name: string, content: Blob): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

const types = { csv: "text/csv", svg: "image/svg+xml", toml: "application/toml" };
export const saveText = (name: string, text: string): void =>
  save(name, new Blob([text], { type: types[name.split(".").pop() as keyof typeof types] }));

// Whether the browser allowed it.
export const copyText = (text: string): Promise<boolean> =>
  (navigator.clipboard?.writeText(text) ?? Promise.reject(new Error("no clipboard"))).then(
    () => true,
    () => false,
  );

// Shows for a moment in a button what was done.
export function tell(button: HTMLElement, text: string): void {
  const label = (button.dataset.label ??= button.textContent);
  button.textContent = text;
  setTimeout(() => (button.textContent = label), 1500);
}
