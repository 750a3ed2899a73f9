"""Tables about the hypothesis in Markdown, made of the plain data of `studies.hypothesis.evidence`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ...studies.hypothesis import EXPLODED_INSIDE, LEFT_AND_CALM, THRESHOLD
from ...studies.proportion import Proportion
from .markdown import markdown_table, share

MEASURE_NAMES = {
    "margin": "smallest normalised minor, negative if the aspect was left",
    "manipulability_min": "smallest manipulability w",
    "self_motion_max": "largest ‖θ̇_H‖",
}
"""What peak torques are correlated with, in words."""

Condition = dict[str, Any]
"""One arm under one setting, as in `evidence`."""


def counts_table(conditions: Sequence[Condition]) -> list[str]:
    """Return the runs of each law by aspect and torque, and the shares that the hypothesis is about."""
    header = ("kept, calm", "kept, exploded", "left, calm", "left, exploded")
    shares = ("P(exploded given kept)", "P(exploded given left)", "P(calm given left)")

    def cells(condition: Condition, law: str) -> tuple[str, ...]:
        table = table_of(condition, law)
        counts = (table[name] for name in ("kept_calm", "kept_exploded", "left_calm", "left_exploded"))
        found = (
            proportion_of(condition, law, name) for name in ("exploded_if_kept", "exploded_if_left", "calm_if_left")
        )
        return (*(f"{count:,}" for count in counts), *map(share, found))

    return _by_law(conditions, (*header, *shares), cells)


def association_table(conditions: Sequence[Condition]) -> list[str]:
    """Return how leaving and exploding go together, and which came first."""

    def cells(condition: Condition, law: str) -> tuple[str, ...]:
        found, inside = condition["association"][law], table_of(condition, law)["exploded_inside"]
        ratio, p, difference = found["odds_ratio"], found["fisher_p"], found["risk_difference"]
        return (
            "" if difference is None else f"{difference:+.2f}",
            "" if ratio is None else f"{_odds(ratio[0])} [{_odds(ratio[1])}, {_odds(ratio[2])}]",
            "" if p is None else f"{p:.2g}",
            f"{inside['count']:,} of {inside['total']:,}",
        )

    return _by_law(conditions, ("risk difference", "odds ratio", "p", "exploded while still inside"), cells)


def threshold_table(conditions: Sequence[Condition], thresholds: Sequence[float]) -> list[str]:
    """Return P(calm given left) / P(exploded given kept) by the ratio from which a run counts as exploded."""

    def cells(condition: Condition, law: str) -> tuple[str, ...]:
        tables = (table_of(condition, law, threshold) for threshold in thresholds)
        pairs = ((table["calm_if_left"]["value"], table["exploded_if_kept"]["value"]) for table in tables)
        return tuple(" / ".join(_two_digits(value) for value in pair) for pair in pairs)

    return _by_law(conditions, tuple(f"{threshold:g}" for threshold in thresholds), cells)


def correlation_table(conditions: Sequence[Condition]) -> list[str]:
    """Return Spearman's correlations of the peak torque over the reference / of the peak torque itself."""

    def cells(condition: Condition, law: str) -> tuple[str, ...]:
        ratio, peak = (condition["correlations"][law][torque] for torque in ("ratio", "peak_torque"))
        return tuple(" / ".join(_signed(each[name]) for each in (ratio, peak)) for name in MEASURE_NAMES)

    return _by_law(conditions, tuple(MEASURE_NAMES.values()), cells)


def share_table(conditions: Sequence[Condition], name: str, first: str) -> list[str]:
    """Return one share, with its interval, of every arm or setting by law.

    Args:
        conditions: The rows.
        name: `"calm_if_left"`, `"exploded_if_kept"` or `"exploded_if_left"`.
        first: Heading of the first column.
    """
    laws = laws_of(conditions)
    rows = [
        (label(each), *(share(proportion_of(each, law, name)) if law in each["laws"] else "" for law in laws))
        for each in conditions
    ]
    return markdown_table((first, *laws), rows)


def arms_table(conditions: Sequence[Condition]) -> list[str]:
    """Return what was drawn on each arm."""
    header = ("arm", "motions", "redundancy", "minors", "length", "duration", "reference", "no law finished", "errors")
    rows = [
        (
            label(each),
            f"{each['samples']:,}",
            str(each["redundancy"]),
            str(each["minors"]),
            spread(each["length"], "m"),
            spread(each["duration"], "s"),
            spread(each["reference"], "N m"),
            str(len(each["undecided"])),
            str(each["failed"]),
        )
        for each in conditions
    ]
    return markdown_table(header, rows)


def cost_table(conditions: Sequence[Condition], motions: float) -> list[str]:
    """Return what a run took, and what a number of motions under all laws would take on one core."""
    rows = [
        (
            label(each),
            str(len(each["laws"])),
            f"{1e3 * each['wall_time']['mean']:.0f} ms",
            f"{each['wall_time']['mean'] * len(each['laws']) * motions / 86_400.0:,.0f} days",
        )
        for each in conditions
        if each["wall_time"]
    ]
    return markdown_table(("arm", "laws", "a run, mean", f"{motions:,.0f} motions under all laws, one core"), rows)


def sources_table(sources: Sequence[dict[str, Any]]) -> list[str]:
    """Return which files the figures come from."""
    rows = [
        (
            each["name"],
            f"{each['rows']:,}" + ("" if each["rows"] == each["runs"] else f" of {each['runs']:,}"),
            each["file"],
            f"`{each['sha256']}`",
            f"`{each['study'][:16]}`",
            f"aspect-control {each['version.aspect-control']}, pin {each['version.pin']}, {each['kernels']}",
        )
        for each in sources
    ]
    return markdown_table(("study", "runs", "file", "SHA-256", "hash of the study", "computed by"), rows)


def counterexample_table(found: Sequence[dict[str, Any]]) -> list[str]:
    """Return the clearest counterexamples, one a row."""
    words = {LEFT_AND_CALM: "left, calm", EXPLODED_INSIDE: "kept, exploded"}
    header = ("kind", "arm", "law", "sample", "torque ratio", "beyond the border", "sign changes", "ratio at dt/4")
    rows = [
        (
            words[each["kind"]],
            each["scenario"],
            each["law"],
            str(each["sample"]),
            f"{each['peak_torque'] / each['reference']:,.2f}"
            + ("" if each["status"] == "finished" else f", {each['status']}"),
            f"{max(0.0, -each['margin']):.2f}",
            str(each["sign_changes"]),
            "" if each["finer_peak_torque"] is None else f"{each['finer_peak_torque'] / each['reference']:,.2f}",
            {None: "", True: "yes", False: "no"}[each["holds"]],
        )
        for each in found
    ]
    return markdown_table((*header, "holds there"), rows)


def table_of(condition: Condition, law: str, threshold: float = THRESHOLD) -> dict[str, Any]:
    """Return the counts and shares of a law at a threshold."""
    found: dict[str, Any] = next(
        each for each in condition["tables"] if (each["law"], each["threshold"]) == (law, threshold)
    )
    return found


def laws_of(conditions: Sequence[Condition]) -> list[str]:
    """Return the labels of all laws, in the order in which they come."""
    return list(dict.fromkeys(law for each in conditions for law in each["laws"]))


def label(condition: Condition) -> str:
    """Return what an arm under a setting is called."""
    return str(condition["setting"] or condition["scenario"])


def proportion_of(condition: Condition, law: str, name: str) -> Proportion:
    """Return a share of the runs of a law, such as `"calm_if_left"`."""
    found = table_of(condition, law)[name]
    return Proportion(*(found[each] for each in ("count", "total", "low", "high")))


def spread(each: dict[str, float] | None, unit: str) -> str:
    """Write the range of a quantity and its median."""
    return "none" if each is None else f"{each['min']:.3g} to {each['max']:.3g} {unit} (median {each['median']:.3g})"


def _by_law(
    conditions: Sequence[Condition], header: tuple[str, ...], cells: Callable[[Condition, str], tuple[str, ...]]
) -> list[str]:
    several = len(conditions) > 1
    rows = [
        (*([label(each)] if several else []), law, *cells(each, law)) for each in conditions for law in each["laws"]
    ]
    return markdown_table((*(["arm"] if several else []), "law", *header), rows)


def _odds(value: float | None) -> str:
    return "∞" if value is None else f"{value:.3g}"


def _two_digits(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f}"


def _signed(value: float | None) -> str:
    return "–" if value is None else f"{value:+.2f}"
