// What can wait until the first picture of the balls is drawn. It is then done bit by bit between the frames of the film.
let waiting: (() => void)[] | null = null;

export const hold = (): void => void (waiting = []);
export const later = (act: () => void): void => void (waiting ? waiting.push(act) : act());

// For at most so many milliseconds, but one thing at least.
export function catchUp(most: number): void {
  const end = performance.now() + most;
  do waiting?.shift()?.();
  while (waiting?.length && performance.now() < end);
  if (!waiting?.length) waiting = null;
}
