"""The two-ball problem solved with other tools, each program as fast as the tool allows.

All peers count contacts and take v'_r, the separation velocity and t_f with the definitions of hardlimit: forces are
clipped at zero, a force that resumes without an open gap in between is a new contact, and the sequence ends with the
second floor contact. They share the scaled problem (`scaled.py`).
"""
