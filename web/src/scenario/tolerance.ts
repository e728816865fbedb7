// The tolerance of all statements that two results agree; Python's (src/hardlimit/column/comparison.py) unless changed.
export const usualTolerance = 0.01;
export const tolerances = [0.001, 0.01, 0.02, 0.05, 0.1];

// 0.01 → "1 %"
export const inPercent = (x: number): string => `${Number((100 * x).toPrecision(3))} %`;
