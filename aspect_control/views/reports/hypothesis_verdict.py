"""What the counts say about the hypothesis, in sentences that follow from them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ...studies.hypothesis import THRESHOLD, THRESHOLDS
from ...studies.proportion import Proportion
from ..style import law_name
from .hypothesis_tables import MEASURE_NAMES, Condition, label, laws_of, proportion_of, table_of
from .markdown import share

NEARLY = 0.05
"""Upper end of an interval below which a share counts as close to none."""

SIGNIFICANT = 0.05
"""Probability of no difference below which one is said to be there."""

Cell = tuple[Condition, str]
"""A law on an arm under a setting."""


def hypothesis_verdict(conditions: Sequence[Condition]) -> list[str]:
    """Return what the runs of arms as their scenarios have them say about the hypothesis, as lines of Markdown.

    Counts added up over laws are counts, not a sample of that size: the laws run on the same motions. What is said with
    confidence is said of the interval of one law on one arm.

    Args:
        conditions: The arms, as in `studies.hypothesis.evidence`.
    """
    lines = [_necessary(conditions), _sufficient(conditions), _first(conditions)]
    lines += [_what_goes_with_the_torque(conditions), _minor_measure(conditions)]
    return [f"- {line}" for line in lines if line]


def verdict_on_settings(conditions: Sequence[Condition]) -> list[str]:
    """Return whether the answers are the same under all settings, as lines of Markdown.

    Args:
        conditions: An arm under the settings, as in `studies.hypothesis.evidence`.
    """
    lines = []
    for name, words in (("calm_if_left", "P(calm given left)"), ("exploded_if_kept", "P(exploded given kept)")):
        for law in laws_of(conditions):
            cells = [cell for cell in _cells(conditions) if cell[1] == law and _share(cell, name).total]
            if cells:
                low, high = (pick(cells, key=lambda cell: _share(cell, name).value or 0.0) for pick in (min, max))
                lines.append(
                    f"- {words} of {law}: {_interval(low, name)} ({label(low[0])}) to {_interval(high, name)} "
                    f"({label(high[0])})."
                )
    return [_agreement(conditions), "", *lines]


def _agreement(conditions: Sequence[Condition]) -> str:
    """Say under how many settings the answers are those of all runs together."""
    contradicted = [each for each in conditions if _total([each], "left_calm")]
    kept = [each for each in conditions if _total([each], "kept_calm", "kept_exploded")]
    burst = [each for each in kept if _total([each], "kept_exploded")]
    return (
        f"Runs that left their aspect stayed calm under {len(contradicted)} of {len(conditions)} settings; runs that "
        f"kept it exploded under {len(burst)} of {len(kept)}."
    )


def _necessary(conditions: Sequence[Condition]) -> str:
    left, calm = _total(conditions, "left_calm", "left_exploded"), _total(conditions, "left_calm")
    if not left:
        return "Necessary for a calm torque? No run left its aspect, so that nothing can be said."
    if not calm:
        return f"Necessary for a calm torque? Nothing here contradicts it: all {left:,} runs that left exploded."
    strict = sum(table_of(each, law, THRESHOLDS[0])["left_calm"] for each, law in _cells(conditions))
    below = sum(each["left_and_calm"]["below_bound"] for each in conditions)
    where = [cell for cell in _cells(conditions) if table_of(*cell)["left_calm"]]
    return (
        f"Necessary for a calm torque? No: {calm:,} of {left:,} runs that left their aspect stayed calm, {strict:,} of "
        f"them within {THRESHOLDS[0]:g} times the reference and {below:,} below {THRESHOLD:g} times the median "
        f"reference of the arm. P(calm given left) is {_extremes(where, 'calm_if_left')}."
    )


def _sufficient(conditions: Sequence[Condition]) -> str:
    kept, burst = _total(conditions, "kept_calm", "kept_exploded"), _total(conditions, "kept_exploded")
    if not kept:
        return "Sufficient? No run kept its aspect, so that nothing can be said."
    cells = [cell for cell in _cells(conditions) if _share(cell, "exploded_if_kept").total]
    widest = max(cells, key=lambda cell: _share(cell, "exploded_if_kept").high)
    bound = f"the highest upper end of an interval is {_share(widest, 'exploded_if_kept').high:.2g} ({_named(widest)})"
    if not burst:
        return f"Sufficient? Nothing here contradicts it: none of the {kept:,} runs that kept it exploded; {bound}."
    where = [cell for cell in cells if table_of(*cell)["kept_exploded"]]
    nearly = all(_share(cell, "exploded_if_kept").high < NEARLY for cell in cells)
    return (
        f"Sufficient? {'Nearly' if nearly else 'No'}: {burst:,} of {kept:,} runs that kept their aspect exploded "
        f"({_listed(map(_named, where))}); {bound}."
    )


def _first(conditions: Sequence[Condition]) -> str:
    shares = [_share(cell, "exploded_inside") for cell in _cells(conditions)]
    burst, inside = sum(each.total for each in shares), sum(each.count for each in shares)
    if not burst:
        return ""
    later = inside - _total(conditions, "kept_exploded")
    rest = f"; {later:,} of those left their aspect afterwards and count among the runs that left" if later else ""
    return (
        f"Which comes first? In {inside:,} of {burst:,} runs that exploded the torque passed the threshold before any "
        f"minor had changed sign{rest}."
    )


def _what_goes_with_the_torque(conditions: Sequence[Condition]) -> str:
    law = "null-space-vector"
    found = [each["correlations"][law]["peak_torque"] for each in conditions if law in each["laws"]]
    found = [each for each in found if None not in each.values()]
    if not found:
        return ""
    closest = [max(each, key=lambda name: abs(each[name])) for each in found]
    most = max(MEASURE_NAMES, key=closest.count)
    others = [name for name in MEASURE_NAMES if name != most]
    rest = "; ".join(f"{MEASURE_NAMES[name]}: {_range(each[name] for each in found)}" for name in others)
    return (
        f"What explodes? Under the {law_name(law)} law the peak torque goes most closely with the "
        f"{MEASURE_NAMES[most]} on {closest.count(most)} of {_arms(len(found))} (rank correlation "
        f"{_range(each[most] for each in found)}; {rest})."
    )


def _minor_measure(conditions: Sequence[Condition]) -> str:
    found = [(label(each), each["minor_measure"]) for each in conditions if each["minor_measure"]]
    if not found:
        return ""
    parts = []
    for name, words in (("kept", "keeps the aspect"), ("exploded", "explodes")):
        for more, kind in ((True, "more often"), (False, "less often")):
            where = [
                f"{arm}: {each[name]['one']:,} motions with it, {each[name]['other']:,} without"
                for arm, each in found
                if each[name]["p"] is not None
                and each[name]["p"] < SIGNIFICANT
                and (each[name]["one"] > each[name]["other"]) == more
            ]
            if where:
                parts.append(f"{words} {kind} on {len(where)} of {_arms(len(found))} ({'; '.join(where)})")
    said = _listed(parts) if parts else "makes no difference that shows in either"
    return f"What does JMDC's minor measure do? On the same motions JMDC with it {said} (McNemar, p < {SIGNIFICANT:g})."


def _cells(conditions: Sequence[Condition]) -> list[Cell]:
    return [(each, law) for each in conditions for law in each["laws"]]


def _share(cell: Cell, name: str) -> Proportion:
    return proportion_of(*cell, name)


def _total(conditions: Sequence[Condition], *names: str) -> int:
    return sum(table_of(each, law)[name] for each, law in _cells(conditions) for name in names)


def _extremes(cells: Sequence[Cell], name: str) -> str:
    low, high = (pick(cells, key=lambda cell: _share(cell, name).value or 0.0) for pick in (min, max))
    if low is high:
        return f"{_interval(low, name)} ({_named(low)})"
    return f"{_interval(low, name)} ({_named(low)}) to {_interval(high, name)} ({_named(high)})"


def _interval(cell: Cell, name: str) -> str:
    return share(_share(cell, name))


def _named(cell: Cell) -> str:
    return f"{cell[1]}, {label(cell[0])}"


def _arms(number: int) -> str:
    return f"{number} {'arm' if number == 1 else 'arms'}"


def _range(values: Iterable[float]) -> str:
    found = sorted(values)
    return f"{found[0]:+.2f}" if len(found) == 1 else f"{found[0]:+.2f} to {found[-1]:+.2f}"


def _listed(words: Iterable[str]) -> str:
    found = list(words)
    return found[0] if len(found) == 1 else f"{'; '.join(found[:-1])} and {found[-1]}"
