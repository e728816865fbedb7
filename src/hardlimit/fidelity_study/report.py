"""Text of a comparison of rules with Newton's equations: a summary sentence and tables."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from ..boxes.contacts import rubs
from ..support.estimate import Estimate
from ..support.formatting import at_least_two_digits, digits, listed, percent, percent_with_error
from . import prediction
from .replica import NEWTON
from .starts import is_redrawn

if TYPE_CHECKING:
    from .result import Departure, Fidelity

#: Names of the rows of tables.
NAMES: Final = {
    "granular_temperature": "temperature",
    "rotational_temperature": "temperature of rotation",
    "cooling": "cooling",
    "dissipation_rate": "dissipation",
    "collision_rate": "collision rate",
    "pressure": "pressure",
    "pair_correlation": "pairs near contact",
    "density_variance": "density variance",
    "shear_stress": "shear stress",
    "first_normal_stress_difference": "normal stress difference",
}
#: Share of the fluctuations of v_x in a flow that is not linear above which shear is not homogeneous.
BANDED: Final = 0.2
#: The verdict is about the first of these quantities that is defined; each has a verb, and words for more and for less.
MEASURES: Final = {
    "cooling": ("cools", "too fast", "too slowly"),
    "collision_rate": ("collides", "too often", "too rarely"),
}
#: Rows of the table of contacts.
CONTACTS: Final = {
    "fraction that overlap another contact in time": "overlapped_share",
    "median restitution": "median_restitution",
    "largest compression [radii]": "largest_compression",
    "contacts of a replica": "n_contacts",
    "final distance of trajectories [radii]": "divergence",
}
#: Outcomes of a run in words.
EARLY: Final = {"collapse": "inelastic collapse", "too_deep": "a contact too deep for its law"}


def half_width(estimate: Estimate[float]) -> float:
    """Half the width of the confidence interval."""
    return 0.5 * (estimate.upper - estimate.lower)


def when(f: Fidelity) -> str:
    """Of which time the differences are."""
    return "in the steady state" if f.driven else "at the end"


# --- the sentence -------------------------------------------------------------------------------------------


def sentence(f: Fidelity) -> str:
    """The difference of each rule from Newton's equations, or the reason why it is unknown."""
    rules = [model for model in f.models if model != NEWTON]
    reason = _no_verdict(f, rules)
    if reason is not None:
        return f"No verdict: {reason}"
    if f.driven:
        return _steady_sentence(f, rules)
    measure = next((name for name in MEASURES if _defined(f, name, rules)), None)
    if measure is None:
        missing = "no time has passed" if f.last_common(NEWTON) == 0 else "no rule reached a sample"
        return f"No verdict: {missing}.{_early_ends(f)}"
    verb, more, less = MEASURES[measure]
    differing, agreeing, unresolved = list[str](), list[str](), list[str]()
    for rule in _defined(f, measure, rules):
        difference = f.final_difference(measure, rule)
        if f.is_significant(measure, rule):
            size = percent_with_error(abs(difference.value), difference.error)
            subject = rule if differing else f"the rule {rule} {verb}"
            differing.append(f"{subject} {size} {more if difference.value > 0.0 else less}")
        elif half_width(difference) <= f.resolution:
            agreeing.append(f"{rule} ({percent_with_error(difference.value, difference.error)})")
        else:
            unresolved.append(rule)
    parts = [", ".join(differing)] if differing else []
    if agreeing:
        parts.append(
            f"{_subject(agreeing)} not significantly different from Newton’s equations in {NAMES[measure]}"
        )
    if parts:
        parts[-1] += f" (± standard error of {f.n_replicas} replicas)"
    if unresolved:
        parts.append(_not_resolved(f, measure, unresolved))
    return f"At {numbers(f)} {'; '.join(parts)}.{_early_ends(f)}{law_of_error(f)}"


def _steady_sentence(f: Fidelity, rules: list[str]) -> str:
    """The differences of each rule in the steady state."""
    if f.steady.reason:
        end = f"{f.plan.until:.3g} s"
        return (
            f"No verdict: not steady by {end}, {f.steady.reason}; take a longer run.{_not_compared(f, rules)}"
        )
    banded = {model: f.nonlinear_flow(model) for model in f.models if f.nonlinear_flow(model) > BANDED}
    if banded:
        who = listed(["Newton’s equations" if model == NEWTON else f"the rule {model}" for model in banded])
        return (
            f"No verdict: shear bands under {who}, {percent(max(banded.values()))} of the fluctuations of v_x is a "
            f"flow that is not linear; averages over the box are not those of a sheared gas.{_not_compared(f, rules)}"
        )
    compared = _defined(f, f.examined[0], rules)
    errors = "; ".join(f"{rule} {_errors(f, rule)}" for rule in compared) or "no rule reached the end"
    if f.n_replicas > 1:
        bars = f"standard error of {f.n_replicas} replicas"
    else:
        bars = "standard error of correlated samples, one replica"
    return (
        f"Steady from {f.steady.start:.3g} s on. At {numbers(f)}, relative to Newton’s equations: {errors} "
        f"(± {bars}; ? not resolved to {percent(f.resolution)}).{_not_compared(f, rules)}{law_of_error(f)}"
    )


def _errors(f: Fidelity, rule: str) -> str:
    """The differences of the examined quantities."""
    errors = {name: f.final_difference(name, rule) for name in f.examined}
    parts = [
        f"{NAMES[name]} {percent_with_error(error.value, error.error)}{'?' * (half_width(error) > f.resolution)}"
        for name, error in errors.items()
        if math.isfinite(error.value)
    ]
    return ", ".join(parts)


def _not_compared(f: Fidelity, rules: list[str]) -> str:
    """Sentences about models that did not reach the end in every replica."""
    said = ""
    for model in (NEWTON, *rules):
        bad = [outcome for outcome in f.outcomes(model) if outcome != "ok"]
        if bad:
            what = next((text for name, text in EARLY.items() if name in bad), "another outcome")
            who = "Newton’s equations" if model == NEWTON else f"The rule {model}"
            said += (
                f" {who} ended with {what} in {len(bad)} of {f.n_replicas} replicas and cannot be averaged."
            )
    return said


def numbers(f: Fidelity) -> str:
    """t_c ν and δ/d of a comparison."""
    depth = "" if math.isnan(f.delta_over_d) else f" (δ/d = {f.delta_over_d:.2g})"
    return f"t_c ν = {f.tc_nu:.2g}{depth}"


def law_of_error(f: Fidelity) -> str:
    """The predictions of the law of the error as sentences, with a warning where they contradict the measurement."""
    measure = "granular_temperature" if f.driven else "cooling"
    predictions = {
        rule: f.predicted(rule) for rule in _defined(f, measure, [m for m in f.models if m != NEWTON])
    }
    said = [
        f"{percent_with_error(predicted.value, predicted.error)} for {rule}"
        for rule, predicted in predictions.items()
        if math.isfinite(predicted.value)
    ]
    wrong = [rule for rule in predictions if prediction.contradicted(f, rule)]
    of = ", in temperature," if f.driven else ""
    beyond = {predicted.extrapolated: None for predicted in predictions.values() if predicted.extrapolated}
    text = f" The law of the error predicts{of} {listed(said)}" if said else ""
    text += f", extrapolated: {'; '.join(beyond)}." if text and beyond else "." if text else ""
    if wrong:
        text += f" Warning: this contradicts the measured {NAMES[measure]} of {listed(wrong)}."
    if not said and rubs(f.plan.law):
        text += " The law of the error is not known with this friction."
    return text


def _subject(rules: list[str]) -> str:
    return f"the rule {rules[0]} is" if len(rules) == 1 else f"the rules {listed(rules)} are"


def _not_resolved(f: Fidelity, measure: str, rules: list[str]) -> str:
    """The intervals, and the number of replicas that would be needed."""
    bars = [half_width(f.final_difference(measure, rule)) for rule in rules]
    needed = max(f.replicas_needed(measure, rule) for rule in rules)
    number = "more than a million" if math.isinf(needed) else f"about {at_least_two_digits(needed)}"
    sizes = " to ".join(dict.fromkeys(f"± {percent(x)}" for x in (min(bars), max(bars))))
    return (
        f"{_subject(rules)} not resolved by {NAMES[measure]}: {sizes} with {f.n_replicas} replicas (99 % confidence); "
        f"for ± {percent(f.resolution)} {number} replicas would be needed"
    )


def _no_verdict(f: Fidelity, rules: list[str]) -> str | None:
    if not any(arrays["n_contacts"].any() for arrays in f.arrays):
        return "there was no contact in this time."
    if not rules:
        return "models has no rule to compare with Newton’s equations."
    if f.n_replicas < 2 and not f.driven:
        at = "" if math.isnan(f.tc_nu) else f" (t_c ν = {f.tc_nu:.2g})"
        return f"one replica has no error bars{at}; {_more(f)}."
    return None


def _more(f: Fidelity) -> str:
    """How to have more replicas; a start that is no gas cannot be drawn again."""
    if is_redrawn(f.start):
        return "ask for more, such as replicas=8"
    return "more need a gas without gravity and moving walls, or a start that is drawn from a seed"


def _defined(f: Fidelity, name: str, rules: list[str]) -> list[str]:
    """The rules whose relative difference in this quantity is defined: not zero under Newton's equations, and with a
    common sample after the start."""
    return [rule for rule in rules if np.isfinite(f.final_difference(name, rule).value)]


def _early_ends(f: Fidelity) -> str:
    """Sentences about models that ended early; models with the same end share a sentence."""
    alike: dict[tuple[str, float], list[str]] = {}
    for model in f.models:
        outcomes = f.outcomes(model)
        bad = [name for name in outcomes if name != "ok"]
        if bad:
            what = next((text for name, text in EARLY.items() if name in bad), "another outcome")
            last = float(f.plan.times[f.last_common(model)])
            count = "all" if model == NEWTON else "…"
            how = f"ended with {what} in {len(bad)} of {len(outcomes)} replicas; {count}"
            alike.setdefault((how, last), []).append(model)
    return "".join(_early_end(how, last, models) for (how, last), models in alike.items())


def _early_end(how: str, last: float, models: list[str]) -> str:
    many = len(models) > 1
    subject = (
        "Newton’s equations" if models == [NEWTON] else f"The rule{'s' if many else ''} {listed(models)}"
    )
    how = how.replace("…", "they" if many else "it")
    verb = "are" if how.endswith("they") else "is"
    compared = f"{verb} compared at {last:.3g} s" if last > 0.0 else "ended before the first sample"
    return f" {subject} {how} {compared}."


# --- tables -------------------------------------------------------------------------------------------------


def table(f: Fidelity) -> tuple[list[str], list[list[str]]]:
    """Head and rows: the final difference of each rule in per cent."""
    rules = [model for model in f.models if model != NEWTON]
    rows = [[NAMES[name], *(_cell(f, name, rule) for rule in rules)] for name in f.quantities]
    law = [f.predicted(rule) for rule in rules]
    if any(math.isfinite(predicted.value) for predicted in law):
        known = [
            "–" if predicted.reason else _bare(percent_with_error(predicted.value, predicted.error))
            for predicted in law
        ]
        measure = "granular_temperature" if f.driven else "cooling"
        rows.insert(1 + list(f.quantities).index(measure), [f"{NAMES[measure]}, law of the error", *known])
    return ["", *rules], rows


def _cell(f: Fidelity, name: str, rule: str) -> str:
    difference = f.final_difference(name, rule)
    mark = "*" if f.is_significant(name, rule) else "?" if half_width(difference) > f.resolution else ""
    return _bare(percent_with_error(difference.value, difference.error)) + mark


def _bare(text: str) -> str:
    """A percentage without its sign, which is in the title, so that four rules fit into 60 characters."""
    return text.removesuffix(" %").replace("less than ", "<").replace(" ± ", "±")


def legend(f: Fidelity) -> str:
    """Meaning of the marks in the table."""
    return (
        f"± standard error. Bars: {f.bars}. * significant: outside its bars, by chance one in a hundred. "
        f"? not resolved: bars over {percent(f.resolution)}."
    )


def departures(f: Fidelity) -> list[list[str]]:
    """Rows: time [t_c] and size of the first significant difference of each rule. Quantities without one are absent."""
    rules = [model for model in f.models if model != NEWTON]
    rows = []
    for name in f.quantities:
        times = [f.departure(name, rule) for rule in rules]
        if any(times):
            rows.append([NAMES[name], *("–" if at is None else _time_and_size(f, at) for at in times)])
    return rows


def _time_and_size(f: Fidelity, at: Departure) -> str:
    time = at.time / f.contact_duration
    return f"{f'{time:.0f}' if 10.0 <= time < 1e5 else f'{time:.2g}'}: {_bare(percent(at.size))}"


def contacts(f: Fidelity) -> tuple[list[str], list[list[str]]]:
    """Head and rows: statistics of the contacts under each model, means over replicas."""
    means = {name: f.dataset[name].sel(statistic="mean").values for name in CONTACTS.values()}
    means["divergence"] = means["divergence"][:, -1]
    rows = [[label, *(_value(name, float(x)) for x in means[name])] for label, name in CONTACTS.items()]
    return ["", *f.models], rows


def _value(name: str, value: float) -> str:
    if name == "overlapped_share":
        return percent(value)
    return f"{value:.0f}" if name == "n_contacts" else digits(value, 3)
