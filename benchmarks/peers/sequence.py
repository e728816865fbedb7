"""Bookkeeping of a sequence for peers whose switches are callbacks or return values."""

from __future__ import annotations

import math


class Sequence:
    """Active contacts and counts. Each method returns whether the sequence is over."""

    __slots__ = ("counted", "floor", "g", "met_again", "n", "pair", "sep", "t_end", "vr")

    def __init__(self, g: float) -> None:
        self.g, self.n = g, 0
        self.vr = self.sep = self.t_end = math.nan
        self.floor, self.pair, self.met_again, self.counted = True, False, False, False

    def floor_switches(self, u: float, p: float, q: float) -> bool:
        if not self.floor and p < 0.0:  # the gap had opened: second floor contact
            self.met_again = True
            if not (self.pair and self.counted):
                return True
        self.floor = not self.floor
        return self._free(u, p, q)

    def pair_switches(self, t: float, u: float, p: float, q: float) -> bool:
        self.pair = not self.pair
        if self.pair:
            self.counted = not self.met_again
            if self.counted:
                self.n += 1
                self.vr = self.sep = self.t_end = math.nan
        elif self.counted:
            self.vr, self.t_end = q, t
            if self.met_again:
                return True
        return self._free(u, p, q)

    def _free(self, u: float, p: float, q: float) -> bool:
        if self.floor or self.pair or q < 0.0:
            return False
        if self.n > 0 and self.sep != self.sep:
            self.sep = q
        # The floor force cannot resume before the gap has opened.
        return u + 0.5 * p * max(p, 0.0) / self.g >= 0.0

    def row(self) -> tuple[float, float, float, float]:
        return self.n, self.vr, self.sep, self.t_end
