// Reads one of several options from a link; an invalid value is reported in `notes`.
export function choiceOf<T extends string>(
  q: URLSearchParams,
  notes: string[],
  key: string,
  options: readonly T[],
  fallback: T,
): T {
  const text = q.get(key);
  if (text === null) return fallback;
  if ((options as readonly string[]).includes(text)) return text as T;
  notes.push(`${key} = “${text.slice(0, 20)}” is none of ${options.join(", ")}: ${fallback} used`);
  return fallback;
}
