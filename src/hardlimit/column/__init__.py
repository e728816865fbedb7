"""Balls on a vertical line: the scenario, its solvers, what came out, and the models side by side."""
