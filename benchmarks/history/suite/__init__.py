"""Our own speed from commit to commit, with airspeed velocity (asv); other programs stay in benchmarks/.

cd benchmarks/history && asv continuous HEAD~1 HEAD
"""
