"""How many processors this process may use."""

import os


def usable() -> int:
    """At least 1; where the system says which processors are ours, those only."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
