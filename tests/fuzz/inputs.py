"""Writes reproducible random inputs for a fuzz target: inputs.py NUMBER FOLDER."""

import random
import sys
from pathlib import Path

number, folder = int(sys.argv[1]), Path(sys.argv[2])
bytes_of = random.Random(1)
for k in range(number):
    (folder / f"{k:06}").write_bytes(bytes_of.randbytes(256))
