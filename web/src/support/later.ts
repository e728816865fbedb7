// Tasks that are postponed until the first picture is drawn. They are then done one by one between frames of the film.
let waiting: (() => void)[] | null = null;

export const hold = (): void => void (waiting = []);
export const later = (act: () => void): void => void (waiting ? waiting.push(act) : act());

// Does postponed tasks for at most `most` milliseconds, but at least one. Returns whether none is left.
export function catchUp(most: number): boolean {
  const end = performance.now() + most;
  do waiting?.shift()?.();
  while (waiting?.length && performance.now() < end);
  if (!waiting?.length) waiting = null;
  return waiting === null;
}
