"""Newton's equations of a box of grains by LAMMPS: its input, its run in a child process, its output.

LAMMPS is a program that is called. Nothing here imports it or links to it.
"""
