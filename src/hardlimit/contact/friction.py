"""``hl.Friction``: what a contact law says about tangential forces, beside its normal force."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final, NamedTuple

from .. import _core
from ..support import validation

RECORD: Final[dict[str, Any]] = _core.friction_record()
#: Names of the models and of the Coulomb limits, in the order of their numbers.
MODELS: Final = tuple(model["name"] for model in RECORD["models"])
LIMITS: Final = tuple(RECORD["limits"])
PARAMETERS: Final = {parameter["name"]: parameter for parameter in RECORD["parameters"]}
#: Ratio of the stiffnesses of a spring unless it is given, as in LAMMPS.
DEFAULT_RATIO: Final = 2.0 / 7.0
#: Four times p of a linear normal force.
LINEAR: Final = 4
#: The models by default, for a linear and for any other normal force.
SPRING, RESCALED, NONE = "spring", "mindlin_rescale", "none"


class FrictionTerms(NamedTuple):
    """The friction of one contact: k_t = stiffness · ξ^(stiffness_power/4), γ_t = damping · ξ^(damping_power/4)."""

    coefficient: float  #: μ
    stiffness: float = 0.0  #: [N/m^(1 + power/4)]
    stiffness_power: int = 0
    damping: float = 0.0  #: [N s/m^(1 + power/4)]
    damping_power: int = 0
    #: m of the elastic force T, dT/dt = k_t g + m T ȧ/a, a the contact radius, while the compression grows and falls.
    loading: int = 0
    unloading: int = 0
    limit: int = 0  #: number of the limit in :data:`LIMITS`

    @classmethod
    def of_model(cls, model: str, limit: str, **terms: Any) -> FrictionTerms:
        """The terms with the history of one of :data:`MODELS`.

        Parameters
        ----------
        model : str
        limit : str
            One of :data:`LIMITS`.
        **terms : number
            The fields from ``coefficient`` to ``damping_power``.
        """
        history = RECORD["models"][MODELS.index(model)]
        return cls(
            **terms, loading=history["loading"], unloading=history["unloading"], limit=LIMITS.index(limit)
        )


@validation.sealed("write a function that returns a Friction")
@dataclass(frozen=True)
class Friction:
    """Friction of two surfaces: a tangential spring and a damping, limited by Coulomb's law.

    Give it to a law: ``hl.LinearDashpot(stiffness=1e6, restitution=0.9, friction=hl.Friction(0.5))``. The law completes
    it: ``law.friction`` has the model and the ratio of the stiffnesses that this law takes by default.

    Parameters
    ----------
    coefficient : float
        Coefficient of friction μ, 0 to infinity. With an infinite one the surfaces never slip.
    stiffness_ratio : float, optional
        Tangential stiffness k_t over the stiffness dF/dξ of the normal force without damping, > 0; by default 2/7 for
        a spring, and 2(1 − ν)/(2 − ν) for Mindlin's models if the law has a Poisson's ratio ν.
    stiffness : float, optional [N/m]
        k_t itself, > 0, for a spring.
    damping_ratio : float, default 0
        Tangential damping γ_t over the damping dF/d(dξ/dt) of the normal force, ≥ 0.
    damping : float, optional [kg/s]
        γ_t itself, ≥ 0.
    model : str, optional
        "spring": constant k_t (Cundall & Strack 1979); the default of linear laws. "mindlin", "mindlin_force",
        "mindlin_rescale", "mindlin_rescale_force": k_t = 8 G* √(R ξ), for Hertz laws, whose default is
        "mindlin_rescale". "none": no spring. The first two can gain energy; so can the third where the normal force is
        damped: β up to ±1.03 for usual stiffnesses, and beyond ±2 for ``hl.Tsuji`` with γ_t and the limit "total".
    limit : str, default "total"
        What μ F_n limits: "total", the whole tangential force (as in LAMMPS), or "spring", that of the spring (as in
        LIGGGHTS and YADE).

    Raises
    ------
    ValueError
        If a value is outside its range, or two of them exclude each other.

    Notes
    -----
    Conventions: Luding, Granular Matter 10, 235 (2008); models: :doc:`/friction`.

    Examples
    --------
    >>> law = hl.LinearDashpot(
    ...     stiffness=1e6, restitution=0.9, friction=hl.Friction(0.5)
    ... )
    >>> law.friction.model, round(law.friction.stiffness_ratio, 4)
    ('spring', 0.2857)
    """

    coefficient: float
    stiffness_ratio: float | None = None
    stiffness: float | None = None
    damping_ratio: float | None = None
    damping: float | None = None
    model: str | None = None
    limit: str = "total"

    def __post_init__(self) -> None:
        for name in PARAMETERS:
            if (value := getattr(self, name)) is not None:
                object.__setattr__(self, name, _checked(name, value))
        for first, second in (("stiffness_ratio", "stiffness"), ("damping_ratio", "damping")):
            if getattr(self, first) is not None and getattr(self, second) is not None:
                raise ValueError(f"{first} | {second}: got both, must be one of them")
        if self.model is not None:
            validation.one_of("model", self.model, MODELS)
        validation.one_of("limit", self.limit, LIMITS)

    def __repr__(self) -> str:
        others = [f"{name}={value!r}" for name, value in self.to_dict().items() if name != "coefficient"]
        return f"Friction({', '.join([repr(self.coefficient), *others])})"

    def to_dict(self) -> dict[str, float | str]:
        """The values that are given, by name."""
        values = {name: getattr(self, name) for name in (*PARAMETERS, "model", "limit")}
        return {name: value for name, value in values.items() if value is not None}

    def completed(self, elastic: int, poisson_ratio: float | None) -> Friction:
        """The friction with the defaults of a law.

        Parameters
        ----------
        elastic : int
            Four times the power of ξ in the normal force.
        poisson_ratio : float or None
            ν of the law; None if it has none.

        Raises
        ------
        ValueError
            If the law does not take this model or this kind of stiffness.
        """
        model = self.model or (SPRING if elastic == LINEAR else RESCALED)
        if model == NONE:
            return self._without_spring()
        ratio, follows = self.stiffness_ratio, model != SPRING
        if follows and elastic == LINEAR:
            raise ValueError(f"model: got {model} with a linear normal force, must be {SPRING} or {NONE}")
        if follows and self.stiffness is not None:
            raise ValueError(f"stiffness: got it with the model {model}, must be stiffness_ratio")
        if not follows and elastic != LINEAR and self.stiffness is None:
            raise ValueError(f"stiffness: missing, the model {SPRING} of a Hertz law must have it in N/m")
        if ratio is None and self.stiffness is None:
            ratio = DEFAULT_RATIO if not follows else mindlin_ratio(poisson_ratio)
        damping_ratio = 0.0 if self.damping is None and self.damping_ratio is None else self.damping_ratio
        return replace(self, model=model, stiffness_ratio=ratio, damping_ratio=damping_ratio)

    def _without_spring(self) -> Friction:
        for name in ("stiffness_ratio", "stiffness"):
            if getattr(self, name) is not None:
                raise ValueError(f"{name}: got it with the model {NONE}, which has no spring")
        if self.damping is None and self.damping_ratio is None:
            raise ValueError(f"damping_ratio | damping: missing, the model {NONE} must have one of them")
        return self

    @property
    def core(self) -> _core.Friction:
        """The friction for the core.

        :meta private:
        """
        assert self.model is not None  # completed by a law
        numbers = {name: math.nan if (x := getattr(self, name)) is None else x for name in PARAMETERS}
        return _core.Friction(model=MODELS.index(self.model), limit=LIMITS.index(self.limit), **numbers)


def mindlin_ratio(poisson_ratio: float | None) -> float:
    """Tangential over normal stiffness of two equal elastic spheres, 4G*/E* = 2(1 − ν)/(2 − ν) (Mindlin 1949)."""
    if poisson_ratio is None:
        raise ValueError("stiffness_ratio: missing, must be > 0 for a law without poisson_ratio")
    return 2.0 * (1.0 - poisson_ratio) / (2.0 - poisson_ratio)


def _checked(name: str, value: Any) -> float:
    """A value within its range; μ may be infinite."""
    limits: Mapping[str, Any] = {
        key: PARAMETERS[name][key] for key in ("lowest", "highest", "lowest_allowed", "highest_allowed")
    }
    if limits["highest_allowed"] and value == math.inf:
        return math.inf
    return validation.number(name, value, **limits)


def checked_friction(friction: Any) -> Friction | None:
    """The friction of a law as its argument gives it."""
    if friction is None or isinstance(friction, Friction):
        return friction
    raise ValueError(
        f"friction: got {validation.shown(friction)}, must be a Friction, such as hl.Friction(0.5)"
    )
