"""The hypothesis on random motions in Markdown: a report of studies, and a page whose figures are filled in."""

from __future__ import annotations

from collections.abc import Sequence
from string import Template
from typing import Any

from ...exceptions import StudyError
from ...studies.hypothesis import THRESHOLD
from .hypothesis_tables import (
    Condition,
    arms_table,
    association_table,
    correlation_table,
    cost_table,
    counterexample_table,
    counts_table,
    label,
    share_table,
    sources_table,
    table_of,
    threshold_table,
)
from .hypothesis_verdict import hypothesis_verdict, verdict_on_settings

MANY_MOTIONS = 1e7
"""Number of motions that the cost is told of."""


def hypothesis_fields(found: dict[str, Any]) -> dict[str, str]:
    """Return the parts of a page about the hypothesis that follow from what was measured, as Markdown by name.

    Args:
        found: What `studies.hypothesis.evidence` returns, or what was read of its JSON.

    Returns:
        `verdict`, `arms`, `counts`, `calm_if_left`, `exploded_if_kept`, `association`, `thresholds`, `correlations`,
        `counterexamples`, `settings` (verdict and tables), `endings`, `cost` and `sources`; `motions` and `runs`, the
        numbers of both in all sources together, and `threshold`.
    """
    arms = [each for each in found["conditions"] if not each["setting"]]
    settings = [each for each in found["conditions"] if each["setting"]]
    blocks = {
        "verdict": hypothesis_verdict(arms),
        "arms": arms_table(arms),
        "counts": counts_table(arms),
        "calm_if_left": share_table(arms, "calm_if_left", "arm"),
        "exploded_if_kept": share_table(arms, "exploded_if_kept", "arm"),
        "association": association_table(arms),
        "thresholds": threshold_table(arms, found["thresholds"]),
        "correlations": correlation_table(arms),
        "counterexamples": counterexample_table(found["counterexamples"]) if found["counterexamples"] else ["None."],
        "settings": _settings(settings),
        "endings": _endings(arms),
        "cost": cost_table(arms or settings, MANY_MOTIONS),
        "sources": sources_table(found["sources"]),
    }
    return {
        **{name: "\n".join(lines) for name, lines in blocks.items()},
        "motions": f"{sum(each['samples'] for each in found['conditions']):,}",
        "runs": f"{sum(each['rows'] for each in found['sources']):,}",
        "threshold": f"{found['threshold']:g}",
    }


def filled_page(template: str, fields: dict[str, str], source: str = "the template") -> str:
    """Return a page with its fields, such as `${verdict}`, filled in; `$$` stands for a dollar sign.

    Args:
        template: The text.
        fields: What is filled in, such as what `hypothesis_fields` returns.
        source: What the text is called in errors.

    Raises:
        StudyError: If it asks for a field that there is not.
    """
    try:
        return Template(template).substitute(fields)
    except KeyError as error:
        raise StudyError(f"{source} asks for the field {error}; there are {', '.join(sorted(fields))}") from None
    except ValueError as error:
        raise StudyError(f"{source}: {error}; a dollar sign is written $$") from None


def hypothesis_report(found: dict[str, Any], figures: Sequence[str] = ()) -> str:
    """Return what random motions say about the hypothesis, with tables, as Markdown.

    Args:
        found: What `studies.hypothesis.evidence` returns.
        figures: Names of the figures to show, without `.png`; they stand beside the report.
    """
    fields = hypothesis_fields(found)
    arms, settings = (any(bool(each["setting"]) == kind for each in found["conditions"]) for kind in (False, True))
    parts: list[tuple[str, str]] = []
    if arms:
        parts += [
            ("Verdict", fields["verdict"]),
            ("What was drawn", f"{_drawn_again(found)}\n\n{fields['arms']}"),
            ("Aspect and torque", f"{_EXPLODED}\n\n{fields['counts']}\n\n{_ASSOCIATION}\n\n{fields['association']}"),
            ("Other thresholds", f"{_THRESHOLDS}\n\n{fields['thresholds']}"),
            ("How runs ended", fields["endings"]),
            ("What the torque goes with", f"{_CORRELATIONS}\n\n{fields['correlations']}"),
            ("Counterexamples", f"{_COUNTEREXAMPLES}\n\n{fields['counterexamples']}"),
        ]
    if settings:
        parts.append(("Settings", fields["settings"]))
    parts += [("Cost", fields["cost"]), ("Sources", fields["sources"])]
    if figures:
        parts.append(("Figures", "\n\n".join(f"![{name}]({name}.png)" for name in figures)))
    text = [line for title, body in parts for line in (f"## {title}", "", body, "")]
    title = ", ".join(dict.fromkeys(each["scenario"] for each in found["conditions"]))
    return "\n".join([f"# Random motions: {title}", "", *text])


_EXPLODED = (
    f"Exploded: ended early, or a peak torque of more than {THRESHOLD:g} times the reference, the least peak torque of "
    "the laws that finish the motion. In brackets 95 % confidence intervals (Wilson)."
)
_ASSOCIATION = (
    "Association of leaving and exploding; the odds ratio is the conditional one with its exact 95 % interval, p is "
    "Fisher's, two-sided. The last column counts the exploded runs whose torque passed the threshold before any minor "
    "had changed sign."
)
_THRESHOLDS = (
    "P(calm given left) / P(exploded given kept), by the peak torque over the reference from which a run counts as "
    "exploded:"
)
_CORRELATIONS = (
    "Spearman's rank correlation across the motions of the peak torque over the reference / of the peak torque itself "
    "with:"
)
_COUNTEREXAMPLES = (
    "The clearest of each law and kind: of the calm runs those that went farthest beyond the border, in parts of the "
    "minor's scale; of the exploded ones those with the largest torque. The last two columns are the same run at a "
    "quarter of the sampling time, held against the same reference. `Study.record(scenario, sample, law)` makes each "
    "again."
)
_SETTINGS = "One thing is changed at a time. P(exploded given left) is 1 less P(calm given left)."


def hypothesis_rows(condition: Condition) -> list[tuple[str, ...]]:
    """Return the table of aspect and torque for the screen: law, four counts, share of calm runs that left."""
    rows = []
    for law in condition["laws"]:
        table = table_of(condition, law)
        calm = table["calm_if_left"]["value"]
        counts = (table[name] for name in ("kept_calm", "kept_exploded", "left_calm", "left_exploded"))
        rows.append((law, *map(str, counts), "–" if calm is None else f"{100.0 * calm:.0f} %"))
    return rows


def _settings(settings: list[Condition]) -> list[str]:
    if not settings:
        return ["None."]
    lines = [_SETTINGS, ""]
    for scenario in dict.fromkeys(each["scenario"] for each in settings):
        mine = [each for each in settings if each["scenario"] == scenario]
        sizes = sorted({each["samples"] for each in mine})
        motions = f"{sizes[0]:,}" if len(sizes) == 1 else f"{sizes[0]:,} to {sizes[-1]:,}"
        lines += [f"{scenario}, {motions} motions a setting. {verdict_on_settings(mine)[0]}", ""]
        lines += verdict_on_settings(mine)[2:]
        for name, words in (("calm_if_left", "P(calm given left)"), ("exploded_if_kept", "P(exploded given kept)")):
            lines += ["", f"{words}:", "", *share_table(mine, name, "setting")]
    return lines


def _endings(arms: list[Condition]) -> list[str]:
    return [
        f"- {label(each)}, {law}: " + ", ".join(f"{n:,} {status}" for status, n in each["endings"][law].items())
        for each in arms
        for law in each["laws"]
    ]


def _drawn_again(found: dict[str, Any]) -> str:
    arms = [each for each in found["conditions"] if not each["setting"]]
    border, length = (sum(each[f"drawn_again_{name}"] for each in arms) for name in ("on_border", "for_length"))
    demanding = sum(len(each["demanding"]) for each in arms)
    seeds = ", ".join(dict.fromkeys(str(each["seed"]) for each in arms))
    times = ", ".join(dict.fromkeys(f"{each['dt']:g}" for each in arms))
    missing = sum(each["runs"] - each["rows"] for each in found["sources"])
    interrupted = f" Interrupted: {missing:,} runs are not there yet." if missing else ""
    return (
        f"Seed {seeds}, dt = {times} s. Drawn again: {border:,} starts on a border, {length:,} sets of postures too "
        f"near to each other or too far apart. On {demanding:,} of them even the least peak torque is more than "
        f"{THRESHOLD:g} times the median of the arm, so that no law is calm there but in comparison.{interrupted}"
    )
