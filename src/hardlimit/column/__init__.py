"""Columns of balls on a vertical line: scenario, solvers, results, comparison of models, files."""
