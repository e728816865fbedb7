// CSV files: comments with the setting, a line with the names of the columns, numbers in full precision.

export const csvText = (comments: string[], columns: string[], rows: Iterable<ArrayLike<number>>): string => {
  const lines = [...comments.map((text) => `# ${text}`), columns.join()];
  for (const row of rows) lines.push(Array.from(row, (x) => (Number.isFinite(x) ? String(x) : "nan")).join());
  return lines.join("\n") + "\n";
};
