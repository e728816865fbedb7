"""A value with its standard error and confidence interval."""

from __future__ import annotations

from typing import Generic, NamedTuple, TypeVar

T = TypeVar("T")  #: float, or array of floats


class Estimate(NamedTuple, Generic[T]):
    """A value with its standard error and confidence interval.

    Returned by :func:`hardlimit.fit`, :meth:`hardlimit.Fidelity.difference` and :func:`hardlimit.measure.diffusion`.
    """

    value: T  #: most likely value, or mean
    error: T  #: standard error; NaN if unknown
    lower: T  #: lower end of the confidence interval
    upper: T  #: its upper end

    def __str__(self) -> str:
        return f"{self.value:.6g} ± {self.error:.2g}" if isinstance(self.value, float) else repr(self)
