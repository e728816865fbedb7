"""Engine "lammps": input, run and output of LAMMPS for a box of grains under Newton's equations.

LAMMPS runs as a separate program; it is never imported or linked.
"""
