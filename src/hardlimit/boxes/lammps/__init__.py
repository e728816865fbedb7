"""Newton's equations of a box of grains by LAMMPS: its input, its run in a child process, its output.

LAMMPS is called as a program, never imported or linked.
"""
