"""The test of the paper's hypothesis on random motions, as Markdown."""

from __future__ import annotations

from typing import Any

from ...studies.hypothesis import (
    EXPLODED_INSIDE,
    LEFT_AND_CALM,
    THRESHOLD,
    THRESHOLDS,
    Counterexample,
    HypothesisResult,
    Proportion,
)
from .markdown import markdown_table

MEASURE_NAMES = {
    "margin": "smallest normalised minor, negative if the aspect was left",
    "manipulability": "smallest manipulability w",
    "self_motion": "largest ‖θ̇_H‖",
}


def hypothesis_report(result: HypothesisResult) -> str:
    """Return what the random motions say, with tables, as Markdown."""
    experiment, found = result.experiment, result.to_dict()
    interrupted = "" if len(result.samples) == result.requested else f" of {result.requested} that were asked for"
    lines = [
        f"# Random motions: {experiment.name}",
        "",
        f"{len(result.samples)} samples{interrupted}, seed {experiment.seed}, dt = {experiment.dt:g} s. Lines of "
        f"{_range(found['length'], 'm')}, in {_range(found['duration'], 's')}. Drawn again: "
        f"{found['drawn_again_on_border']} starts on a border, {found['drawn_again_for_length']} pairs of postures too "
        f"near or too far apart. Left out, since no law finished: {len(result.undecided)}. Reference, the least peak "
        f"torque on a sample: {_range(found['reference'], 'N m')}; on {len(result.demanding)} samples it is more than "
        f"{THRESHOLD:g} times its median, so that no law is calm there but in comparison.",
        "",
        "## Aspect and torque",
        "",
        f"Exploded: ended early, or a peak torque of more than {THRESHOLD:g} times the reference. In brackets 95 % "
        "confidence intervals (Wilson).",
        "",
        *markdown_table(
            (
                "law",
                "kept, calm",
                "kept, exploded",
                "left, calm",
                "left, exploded",
                "P(exploded given kept)",
                "P(exploded given left)",
                "P(calm given left)",
            ),
            [_counts(result, law) for law in experiment.laws],
        ),
        "",
        "Association of leaving and exploding; the odds ratio is the conditional one with its exact 95 % interval, p "
        "is Fisher's, two-sided. The last column counts the exploded runs whose torque passed the threshold before any "
        "minor had changed sign.",
        "",
        *markdown_table(
            ("law", "risk difference", "odds ratio", "p", "exploded while still inside"),
            [_association(result, law) for law in experiment.laws],
        ),
        "",
        f"![aspect and torque on random motions of {experiment.name}](hypothesis.png)",
        "",
        "## Verdict",
        "",
        *hypothesis_verdict(result),
        "",
        "## Other thresholds",
        "",
        "P(calm given left) / P(exploded given kept), by the peak torque over the reference from which a run counts as "
        "exploded:",
        "",
        *markdown_table(
            ("law", *(f"{threshold:g}" for threshold in THRESHOLDS)),
            [(law, *(_sensitivity(result, law, threshold) for threshold in THRESHOLDS)) for law in experiment.laws],
        ),
        "",
        "## How runs ended",
        "",
        *[
            f"- {law}: " + ", ".join(f"{n} {status}" for status, n in found["endings"][law].items())
            for law in experiment.laws
        ],
        "",
        "## What the torque goes with",
        "",
        "Spearman's rank correlation across the samples of the peak torque over the reference / of the peak torque "
        "itself with:",
        "",
        *markdown_table(
            ("law", *MEASURE_NAMES.values()),
            [(law, *_correlations(result, law)) for law in experiment.laws],
        ),
        "",
        "## Counterexamples",
        "",
        *_counterexamples(result),
        "",
    ]
    return "\n".join(lines)


def hypothesis_verdict(result: HypothesisResult) -> list[str]:
    """Return what the counts say about either direction of the hypothesis, as lines of Markdown."""
    tables = [result.table(law) for law in result.experiment.laws]
    left, left_calm = sum(table.left for table in tables), sum(table.left_calm for table in tables)
    kept, burst = sum(table.kept for table in tables), sum(table.kept_exploded for table in tables)
    laws = [table.law for table in tables if table.left_calm]
    strict = sum(result.table(law, THRESHOLDS[0]).left_calm for law in result.experiment.laws)
    below = sum(each.peak_torque <= result.bound for each in result.left_and_calm())
    lines = []
    if left_calm:
        lines.append(
            f"- Necessary for a calm torque? No: {left_calm} of {left} runs that left their aspect stayed calm "
            f"({', '.join(laws)}), {strict} of them within {THRESHOLDS[0]:g} times the reference and {below} below "
            f"{THRESHOLD:g} times the median reference of all samples."
        )
    elif left:
        lines.append(f"- Necessary for a calm torque? Nothing here contradicts it: all {left} runs that left exploded.")
    else:
        lines.append("- Necessary for a calm torque? No run left its aspect, so that nothing can be said.")
    if burst:
        lines.append(
            f"- Sufficient? No: {burst} of {kept} runs that kept their aspect exploded "
            f"({', '.join(table.law for table in tables if table.kept_exploded)})."
        )
    elif kept:
        lines.append(f"- Sufficient? Nothing here contradicts it: none of the {kept} runs that kept it exploded.")
    else:
        lines.append("- Sufficient? No run kept its aspect, so that nothing can be said.")
    exploded = sum(table.exploded_inside.total for table in tables)
    if exploded:
        inside = sum(table.exploded_inside.count for table in tables)
        lines.append(
            f"- Which comes first? In {inside} of {exploded} runs that exploded the torque passed the threshold before "
            "any minor had changed sign."
        )
    return lines


def _counts(result: HypothesisResult, law: str) -> tuple[str, ...]:
    table = result.table(law)
    return (
        law,
        *(str(n) for n in (table.kept_calm, table.kept_exploded, table.left_calm, table.left_exploded)),
        *(share(each) for each in (table.exploded_if_kept, table.exploded_if_left, table.calm_if_left)),
    )


def _association(result: HypothesisResult, law: str) -> tuple[str, ...]:
    table = result.table(law)
    ratio, p, difference = table.odds_ratio, table.fisher_p, table.risk_difference
    return (
        law,
        "" if difference is None else f"{difference:+.2f}",
        "" if ratio is None else f"{_number(ratio[0])} [{_number(ratio[1])}, {_number(ratio[2])}]",
        "" if p is None else f"{p:.2g}",
        f"{table.exploded_inside.count} of {table.exploded_inside.total}",
    )


def _sensitivity(result: HypothesisResult, law: str, threshold: float) -> str:
    table = result.table(law, threshold)
    return " / ".join(
        "–" if each.value is None else f"{each.value:.2f}" for each in (table.calm_if_left, table.exploded_if_kept)
    )


def _correlations(result: HypothesisResult, law: str) -> list[str]:
    found = result.correlations(law)
    return [
        " / ".join(
            "–" if value is None else f"{value:+.2f}"
            for value in (found["peak_ratio"][name], found["peak_torque"][name])
        )
        for name in MEASURE_NAMES
    ]


def _counterexamples(result: HypothesisResult) -> list[str]:
    if not result.counterexamples:
        found = result.clearest()
        return ["Interrupted before they were run again and saved." if found else "None."]
    words = {LEFT_AND_CALM: "left, calm", EXPLODED_INSIDE: "kept, exploded"}
    experiment = result.experiment
    return [
        "The clearest of each law and kind: of the calm runs those that went farthest beyond the border, as a part of "
        "the minor's scale; of the exploded ones those with the largest torque. The last two columns are the same run "
        "at a quarter of the sampling time. Each is a file in `counterexamples/`, for `aspect-control replay`, and is "
        "made again by",
        "",
        "```python",
        "from aspect_control.studies.hypothesis import Experiment",
        "from aspect_control.scenario import load_scenario",
        "",
        f'experiment = Experiment.of("{experiment.name}", load_scenario("{experiment.name}"), '
        f"seed={experiment.seed}, dt={experiment.dt:g})",
        f'run = experiment.run({result.counterexamples[0].index}, "{result.counterexamples[0].outcome.law}")',
        "```",
        "",
        *markdown_table(
            (
                "kind",
                "law",
                "index",
                "torque ratio",
                "beyond the border",
                "sign changes",
                "ratio at dt/4",
                "holds there",
            ),
            [_counterexample(each, words[each.kind]) for each in result.counterexamples],
        ),
    ]


def _counterexample(each: Counterexample, kind: str) -> tuple[str, ...]:
    found, finer = each.outcome, each.finer
    return (
        kind,
        found.law,
        str(each.index),
        _ratio(found),
        f"{max(0.0, -found.margin):.2f}",
        str(found.sign_changes),
        "" if finer is None else _ratio(finer),
        "" if each.holds is None else "yes" if each.holds else "no",
    )


def _ratio(outcome: Any) -> str:
    return f"{outcome.peak_ratio:,.2f}" + ("" if outcome.status == "finished" else f", {outcome.status}")


def share(each: Proportion) -> str:
    """Write a proportion with its interval, such as `0.25 [0.18, 0.33]`; a dash for that of no runs."""
    return "–" if each.value is None else f"{each.value:.2f} [{each.low:.2f}, {each.high:.2f}]"


def _range(spread: dict[str, float] | None, unit: str) -> str:
    if spread is None:
        return "none"
    return f"{spread['min']:.3g} to {spread['max']:.3g} {unit} (median {spread['median']:.3g})"


def _number(value: float) -> str:
    return "∞" if value == float("inf") else f"{value:.3g}"


def hypothesis_rows(result: HypothesisResult) -> list[tuple[str, ...]]:
    """Return the table of aspect and torque for the screen: law, four counts, share of calm runs that left."""
    tables = [result.table(law) for law in result.experiment.laws]
    return [
        (
            table.law,
            *(str(n) for n in (table.kept_calm, table.kept_exploded, table.left_calm, table.left_exploded)),
            "–" if table.calm_if_left.value is None else f"{100.0 * table.calm_if_left.value:.0f} %",
        )
        for table in tables
    ]
