"""Result of a fit: parameters with intervals, χ² and its probability, and a verdict on the law."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from ..contact.contact import RESTITUTION, Contact, Law
from ..support import html
from ..support.estimate import Estimate
from ..support.formatting import listed
from .candidates import IMPACT_SPEED, Candidate
from .likelihood import SCATTER, Minimum, chi_square_probability
from .measurements import Impacts, Measured, Rebounds

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

#: A law does not describe the data if the probability of χ² is smaller than this.
UNLIKELY: Final = 0.01
#: A law has little support if its AIC exceeds that of the best law by this (Burnham & Anderson 2002).
WORSE: Final = 10.0


@dataclass(frozen=True, eq=False)
class Trial:
    """One law fitted to the data; made by :func:`hardlimit.fit`.

    Notes
    -----
    Akaike's criterion: IEEE Trans. Autom. Control 19, 716 (1974).
    """

    candidate: Candidate  #: the law with its free and held parameters
    minimum: Minimum  #: maximum of its likelihood

    def __repr__(self) -> str:
        return f"<Trial of {self.name}: χ² {self.chi_square:.4g}, AIC {self.aic:.4g}>"

    @property
    def name(self) -> str:
        """Name of the law."""
        return self.candidate.name

    @property
    def n_parameters(self) -> int:
        """Number of free parameters, including the scatter."""
        return len(self.minimum.estimates)

    @property
    def law(self) -> Law:
        """The law with the most likely parameters; parameters without effect on the data are held."""
        free = self.candidate.free
        return self.candidate.made([self.minimum.estimates[p.name].value for p in free])

    @property
    def contact(self) -> Contact:
        """The contact of the ball under this law."""
        return self.law.between(self.candidate.ball, self.candidate.other)

    @property
    def chi_square(self) -> float:
        """χ² of the deviations; with a fitted scatter it is about the number of values for any law."""
        return self.minimum.chi_square

    @property
    def degrees(self) -> int:
        """Degrees of freedom: values minus free parameters."""
        return self.minimum.deviations.size - self.n_parameters

    @property
    def probability(self) -> float:
        """Probability of a χ² this large if the law is right; NaN where the scatter is fitted."""
        if SCATTER in self.minimum.estimates:
            return math.nan
        return chi_square_probability(self.chi_square, self.degrees)

    @property
    def aic(self) -> float:
        """Akaike's criterion, −2 ln L + 2 × free parameters; only differences have a meaning."""
        return self.minimum.minus_two_log_likelihood + 2.0 * self.n_parameters


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Trial):
    """A law fitted to data, with the other laws for comparison; made by :func:`hardlimit.fit`.

    Notes
    -----
    χ² and the covariance are those of normal errors; Akaike's criterion: IEEE Trans. Autom. Control 19, 716 (1974).

    Examples
    --------
    >>> impacts = hl.Impacts.of_restitution(
    ...     [0.05, 0.5, 5.0], [0.965, 0.944, 0.912], 0.003
    ... )
    >>> found = hl.fit(impacts, "viscoelastic")
    >>> for trial in found.trials:  # the best first
    ...     print(f"{trial.name}: χ² {trial.chi_square:.1f}, AIC {trial.aic:.1f}")
    viscoelastic: χ² 0.2, AIC -27.2
    one ε (linear, tsuji): χ² 158.3, AIC 131.0
    >>> found.contact.restitution([0.01, 50.0]).round(3)
    array([0.974, 0.866])
    """

    data: Measured  #: the measurements
    others: tuple[Trial, ...]  #: the other laws, for comparison
    confidence: float  #: confidence level of the intervals

    @property
    def parameters(self) -> Mapping[str, Estimate[float]]:
        """Fitted parameters by name, with standard errors and intervals."""
        return {k: v for k, v in self.minimum.estimates.items() if k != SCATTER}

    @property
    def scatter(self) -> Estimate[float] | None:
        """Standard deviation of the measured quantity between impacts, beyond its errors; None unless fitted."""
        return self.minimum.estimates.get(SCATTER)

    @property
    def covariance(self) -> Floats:
        """Covariance of the fitted parameters in their order, the scatter last."""
        return self.minimum.covariance

    @property
    def notes(self) -> tuple[str, ...]:
        """Parameters that the data do not determine, and the values at which they are held."""
        return self.candidate.notes

    @property
    def deviations(self) -> Floats:
        """Data minus law, decorrelated and in standard errors."""
        return self.minimum.deviations

    @property
    def trials(self) -> tuple[Trial, ...]:
        """All fitted laws, the smallest Akaike criterion first."""
        return tuple(sorted((self, *self.others), key=lambda trial: trial.aic))

    @property
    def dissipation(self) -> Estimate[float] | None:
        """A (ρ/m_eff)^(2/5) [(s/m)^(1/5)] of viscoelastic spheres, which determines ε(v); None for other laws.

        x = (3/2) A (ρ/m_eff)^(2/5) v^(1/5) is the argument of ε(x) (Müller & Pöschel 2011, Eq. B3).
        """
        fitted = self.parameters.get(RESTITUTION)
        if fitted is None or IMPACT_SPEED not in self.law.parameters or isinstance(self.data, Rebounds):
            return None

        def of(restitution: float) -> float:
            law = self.candidate.made([restitution])
            contact = law.between(self.candidate.ball, self.candidate.other)
            prefactor = contact.elastic_prefactor / contact.effective_mass
            return contact.dissipative_time * math.pow(prefactor, 0.4)

        step = 0.01 * min(fitted.value, 1.0 - fitted.value) or 1e-6
        slope = (of(fitted.value - step) - of(fitted.value)) / step
        return Estimate(of(fitted.value), slope * fitted.error, of(fitted.upper), of(fitted.lower))

    @property
    def verdict(self) -> str:
        """Whether the law describes the data, in one sentence."""
        return verdict(self, self.others, self.data.n)

    def plot(self) -> Figure:
        """Plot data and laws, and the deviations in standard errors."""
        from .. import plots

        return plots.fit(self)

    def __repr__(self) -> str:
        parameters = ", ".join(f"{name} {value}" for name, value in self.minimum.estimates.items())
        return f"<Fit of {self.name}: {parameters}; {self.verdict}>"

    def _repr_html_(self) -> str:
        estimates = self.minimum.estimates.items()
        rows = [[name, f"{e}", f"{e.lower:.6g} … {e.upper:.6g}"] for name, e in estimates]
        head = ["", "value", f"{100.0 * self.confidence:g} % interval"]
        return html.table(f"{self.name} fitted to {self.data.n} values", head, rows, self.verdict)


def verdict(chosen: Trial, others: Sequence[Trial], n: int) -> str:
    """One sentence: whether the law describes the data, and how the others compare."""
    said = _alone(chosen, n)
    if not others:
        return said
    best = min(others, key=lambda t: t.aic)
    if best.aic < chosen.aic - WORSE:
        p = "" if math.isnan(best.probability) else f" (p = {best.probability:.2g})"
        return f"{said}; {best.name} does better by {chosen.aic - best.aic:.3g} in AIC{p}"
    if best.aic > chosen.aic + WORSE:
        names, verb = listed([t.name for t in others]), "does" if len(others) == 1 else "do"
        return f"{said}; {names} {verb} worse by {best.aic - chosen.aic:.3g} or more in AIC"
    near = listed([t.name for t in others if t.aic <= chosen.aic + WORSE])
    return f"{said}; {near} cannot be distinguished from it (AIC within {WORSE:g})"


def _alone(trial: Trial, n: int) -> str:
    if SCATTER in trial.minimum.estimates:
        scatter = trial.minimum.estimates[SCATTER].value
        return f"{trial.name} leaves a scatter of {scatter:.2g} of {n} values about their mean"
    if trial.degrees < 1:
        return f"{trial.name} has as many parameters as there are values, so that it cannot be tested"
    verb = "cannot describe" if trial.probability < UNLIKELY else "describes"
    test = f"χ² = {trial.chi_square:.4g} for {trial.degrees} degrees of freedom, p = {trial.probability:.2g}"
    return f"{trial.name} {verb} the data: {test}"


def as_mapping(fit: Fit) -> dict[str, Any]:
    """Everything as plain values in SI units."""

    def plain(e: Estimate[float] | None) -> dict[str, float] | None:
        return None if e is None else e._asdict()

    points: dict[str, Any] = {"deviation": fit.deviations}
    if isinstance(fit.data, Impacts):
        points |= {"speed": fit.data.speed, "restitution": fit.data.restitution}
    return {
        "law": {"name": fit.law.record["name"], **fit.law.parameters},
        "parameters": {name: plain(e) for name, e in fit.parameters.items()},
        "scatter": plain(fit.scatter),
        "dissipation": plain(fit.dissipation),
        "confidence": fit.confidence,
        "covariance": fit.covariance,
        "n": fit.data.n,
        "chi_square": fit.chi_square,
        "degrees_of_freedom": fit.degrees,
        "probability": fit.probability,
        "verdict": fit.verdict,
        "notes": list(fit.notes),
        "laws": [
            {
                "name": t.name,
                "parameters": {k: plain(v) for k, v in t.minimum.estimates.items()},
                "chi_square": t.chi_square,
                "probability": t.probability,
                "aic": t.aic,
            }
            for t in fit.trials
        ],
        "data": points,
    }
