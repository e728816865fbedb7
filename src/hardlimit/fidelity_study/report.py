"""What a comparison says in words: numbers with their errors, one sentence, a table."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from .replica import NEWTON, QUANTITIES
from .statistics import Estimate

if TYPE_CHECKING:
    from .result import Departure, Fidelity

#: Rows of tables: names as people say them.
NAMES: Final = {
    "granular_temperature": "temperature",
    "cooling": "cooling",
    "dissipation_rate": "dissipation",
    "collision_rate": "collision rate",
    "pressure": "pressure",
    "pair_correlation": "pairs near contact",
    "density_variance": "density variance",
}
#: What the sentence judges by, the first that there is: more of it in words, less of it in words.
MEASURES: Final = {
    "cooling": ("cools", "too fast", "too slowly"),
    "collision_rate": ("collides", "too often", "too rarely"),
}


#: Per cent that are told from nothing in words.
LEAST: Final = 0.001


def percent(difference: Estimate) -> str:
    """``4.1 ± 0.3 %``: the error with one digit, two if it begins with 1, and the value with as many decimals, of both
    three digits at most."""
    value, error = 100.0 * float(difference.mean), 100.0 * float(difference.error)
    if math.isnan(value):
        return "–"
    if max(abs(value), 0.0 if math.isnan(error) else error) < LEAST:
        return f"less than {LEAST} %"
    if math.isnan(error):
        return plain_percent(0.01 * value)
    decimals = min(_decimals(error), 2 - _exponent(value) if value else 3, 3)
    unit = 10.0**-decimals
    bar = _fixed(error, decimals) if error >= 0.5 * unit else f"<{_fixed(unit, decimals)}"
    return f"{_fixed(value, decimals)} ± {bar} %"


def plain_percent(share: float) -> str:
    """Two digits, three from 100 % on, never an exponent; a dash where there is none."""
    value = 100.0 * float(share)
    if math.isnan(value):
        return "–"
    if 0.0 < abs(value) < LEAST:
        return f"less than {LEAST} %"
    text = _fixed(value, (2 if abs(value) >= 99.5 else 1) - _exponent(value))
    return f"{text.rstrip('0').rstrip('.') if '.' in text else text} %"


def _exponent(value: float) -> int:
    """Of ten, of the first digit."""
    return int(f"{value:e}".split("e")[1])


def _fixed(value: float, decimals: int) -> str:
    """Rounded to so many digits after the point, or to tens and hundreds if they are negative."""
    return _signed(f"{round(value, decimals):.{max(decimals, 0)}f}")


def _decimals(error: float) -> int:
    """Digits after the point that an error deserves."""
    if error == 0.0:
        return 3
    digits = 1 if f"{error:.1e}"[0] == "1" else 0
    return digits - int(f"{error:.{digits}e}".split("e")[1])


def _signed(text: str) -> str:
    """With a minus sign that is one, and no minus before zeros."""
    if not text.startswith("-"):
        return text
    return f"−{text[1:]}" if any(c in "123456789" for c in text) else text[1:]


# --- the sentence -------------------------------------------------------------------------------------------


def sentence(f: Fidelity) -> str:
    """How far each rule is from Newton's equations, or why that cannot be said."""
    rules = [model for model in f.models if model != NEWTON]
    reason = _no_verdict(f, rules)
    if reason is not None:
        return reason
    measure = next((name for name in MEASURES if _known(f, name, rules)), None)
    if measure is None:
        missing = "there is no time to compare in" if f.last_common(0) == 0 else "no rule reached a sample"
        return f"No verdict: {missing}.{_early(f)}"
    verb, more, less = MEASURES[measure]
    apart: list[str] = []
    same: list[str] = []
    open_: list[str] = []
    for rule in _known(f, measure, rules):
        found = f.final_difference(measure, rule)
        if f.told_apart(measure, rule):
            size = percent(Estimate(abs(found.mean), found.error))
            who = rule if apart else f"the rule {rule} {verb}"
            apart.append(f"{who} {size} {more if found.mean > 0.0 else less}")
        elif f.resolved(measure, rule):
            same.append(f"{rule} ({percent(found)})")
        else:
            open_.append(rule)
    parts = [", ".join(apart)] if apart else []
    if same:
        parts.append(f"{_subject(same)} not told apart from Newton’s equations by {NAMES[measure]}")
    if parts:
        parts[-1] += f" (± standard error of {f.n_replicas} replicas)"
    if open_:
        parts.append(_not_resolved(f, measure, open_))
    return f"At t_c ν = {f.tc_nu:.2g} {'; '.join(parts)}.{_early(f)}"


def _subject(rules: list[str]) -> str:
    return f"the rule {rules[0]} is" if len(rules) == 1 else f"the rules {_listed(rules)} are"


def _not_resolved(f: Fidelity, measure: str, rules: list[str]) -> str:
    """How long the bars are, and what it would take."""
    bars = [f.bar(measure, rule) for rule in rules]
    needed = max(f.replicas_needed(measure, rule) for rule in rules)
    sizes = " to ".join(dict.fromkeys(f"± {plain_percent(x)}" for x in (min(bars), max(bars))))
    sizes = f"{sizes} with {f.n_replicas} replicas"
    return (
        f"{_subject(rules)} not resolved by {NAMES[measure]}: {sizes} (99 % confidence); for "
        f"± {plain_percent(f.resolution)} {_count(needed)} replicas would be needed"
    )


def _count(needed: float) -> str:
    """Two digits, rounded up."""
    if math.isinf(needed):
        return "more than a million"
    unit = 10 ** max(_exponent(needed) - 1, 0)
    return f"about {math.ceil(needed / unit) * unit:d}"


def _no_verdict(f: Fidelity, rules: list[str]) -> str | None:
    contacts = sum(float(found["n_contacts"].sum()) for found in f.arrays)
    if contacts == 0.0:
        return "No verdict: there was no contact in this time."
    if not rules:
        return "No verdict: only Newton’s equations were asked for, and no rule to compare with them."
    if f.n_replicas < 2:
        return f"No verdict: one replica has no error bars{_at(f)}; ask for some, such as replicas=8."
    return None


def _at(f: Fidelity) -> str:
    return "" if math.isnan(f.tc_nu) else f" (t_c ν = {f.tc_nu:.2g})"


def _known(f: Fidelity, name: str, rules: list[str]) -> list[str]:
    """The rules with a relative difference of this quantity: it is not zero under Newton's equations, and there is a
    sample after the start that both reached."""
    return [rule for rule in rules if np.isfinite(f.final_difference(name, rule).mean)]


#: How models ended early, in words.
EARLY: Final = {"collapse": "inelastic collapse", "too_deep": "a contact too deep for its law"}


def _early(f: Fidelity) -> str:
    """Models that did not come to the end, in sentences of their own; one for all that ended alike."""
    alike: dict[tuple[str, float], list[str]] = {}
    for model in f.models:
        outcomes = f.outcomes(model)
        bad = [name for name in outcomes if name != "ok"]
        if bad:
            what = next((text for name, text in EARLY.items() if name in bad), "an early end")
            last = float(f.plan.times[f.last_common(f.models.index(model))])
            how = f"met {what} in {len(bad)} of {len(outcomes)} replicas"
            alike.setdefault((f"{how}; {'all' if model == NEWTON else '…'}", last), []).append(model)
    return "".join(_ended_early(how, last, models) for (how, last), models in alike.items())


def _ended_early(how: str, last: float, models: list[str]) -> str:
    many = len(models) > 1
    who = "Newton’s equations" if models == [NEWTON] else f"the rule{'s' if many else ''} {_listed(models)}"
    how = how.replace("…", "they" if many else "it")
    verb = "are" if how.endswith("they") else "is"
    judged = f"{verb} judged at {last:.3g} s" if last > 0.0 else "ended before the first sample"
    return f" {who[0].upper()}{who[1:]} {how} {judged}."


def _listed(parts: list[str]) -> str:
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"


# --- the table ----------------------------------------------------------------------------------------------


def table(f: Fidelity) -> tuple[list[str], list[list[str]]]:
    """Head and rows: the difference of each rule at the end, in per cent without the sign."""
    rules = [model for model in f.models if model != NEWTON]
    rows = []
    for name in QUANTITIES:
        differences = [f.final_difference(name, rule) for rule in rules]
        marked = [
            _bare(percent(found)) + ("" if math.isnan(found.error) else _mark(f, name, rule))
            for found, rule in zip(differences, rules, strict=True)
        ]
        rows.append([NAMES[name], *marked])
    return ["", *rules], rows


def _bare(text: str) -> str:
    """Short, and without the sign of per cent, which stands above the table: four rules fit into 60 characters."""
    return text.removesuffix(" %").replace("less than ", "<").replace(" ± ", "±")


def _mark(f: Fidelity, name: str, rule: str) -> str:
    return "*" if f.told_apart(name, rule) else "" if f.resolved(name, rule) else "?"


def legend(f: Fidelity) -> str:
    """What the marks of the table mean."""
    long = plain_percent(f.resolution)
    return (
        f"± standard error. Bars: {f.bars}. * told apart: outside its bars. ? not resolved: bars over {long}."
    )


def departures(f: Fidelity) -> list[list[str]]:
    """Rows: time [t_c] and size at which each rule is first told apart; none where no rule is."""
    rules = [model for model in f.models if model != NEWTON]
    rows = []
    for name in QUANTITIES:
        left = [f.departure(name, rule) for rule in rules]
        if any(left):
            rows.append([NAMES[name], *("–" if at is None else _where(f, at) for at in left)])
    return rows


def _where(f: Fidelity, at: Departure) -> str:
    return f"{_rounded(at.time / f.contact_duration)}: {_bare(plain_percent(at.size))}"


def _rounded(value: float) -> str:
    """Two digits, without an exponent where that is short."""
    return f"{value:.0f}" if 10.0 <= value < 1e5 else f"{value:.2g}"


def contacts(f: Fidelity) -> tuple[list[str], list[list[str]]]:
    """Head and rows: what single contacts were like under each model, means over replicas."""
    ds = f.dataset
    rows = [
        [
            "share that overlap another in time",
            *(plain_percent(x) for x in ds["overlapped_share"].values[:, 0]),
        ],
        ["median restitution", *(_number(x) for x in ds["median_restitution"].values[:, 0])],
        ["largest compression [radii]", *(_number(x) for x in ds["largest_compression"].values[:, 0])],
        ["contacts of a replica", *(f"{x:.0f}" for x in ds["n_contacts"].values[:, 0])],
        ["distance of paths at the end [radii]", *(_number(x) for x in ds["divergence"].values[:, -1, 0])],
    ]
    return ["", *f.models], rows


def _number(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.3g}"
