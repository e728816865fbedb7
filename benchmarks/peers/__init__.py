"""The two-ball problem solved with other tools, each written as well as that tool allows.

All peers count contacts and take v'_r, the separation velocity and t_f with the definitions of hardlimit:
forces clipped at zero, a force that switches on again without the gap opening is a new contact, and the
sequence ends with the second floor contact. They share the scaled problem (`scaled.py`) and nothing else.
"""
