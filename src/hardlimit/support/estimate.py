"""A value with its standard error and confidence interval."""

from __future__ import annotations

from typing import Generic, NamedTuple, TypeVar

T = TypeVar("T")  #: float, or array of floats


class Estimate(NamedTuple, Generic[T]):
    """A value with its standard error and confidence interval.

    Returned by :func:`hardlimit.fit` and :meth:`hardlimit.Fidelity.difference`.

    Examples
    --------
    >>> impacts = hl.Impacts.of_restitution(
    ...     [0.05, 0.5, 5.0], [0.965, 0.944, 0.912], 0.003
    ... )
    >>> epsilon = hl.fit(impacts, "linear", compare=False).parameters["restitution"]
    >>> print(epsilon, f"in [{epsilon.lower:.4f}, {epsilon.upper:.4f}]")
    0.940333 ± 0.0017 in [0.9386, 0.9421]
    """

    value: T  #: most likely value, or mean
    error: T  #: standard error; NaN if unknown
    lower: T  #: lower end of the confidence interval
    upper: T  #: its upper end

    def __str__(self) -> str:
        return f"{self.value:.6g} ± {self.error:.2g}" if isinstance(self.value, float) else repr(self)
