"""What the command line shows: progress and tables."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from ..aspects import SelfMotion, Start, growth
from ..exceptions import ParameterError
from ..studies.paper import AGREES, Claim
from .progress import describe_time

LONG = 1800.0
"""From how long on work is begun only with `--yes`, s."""


def processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def confirm_long_run(what: str, seconds: float, instead: str, yes: bool) -> None:
    """Make sure that long work is meant.

    Args:
        what: What takes the time.
        seconds: How long it takes, s.
        instead: What to give for less of it.
        yes: Whether `--yes` was given.

    Raises:
        ParameterError: If it takes longer than `LONG` and was not confirmed.
    """
    if seconds > LONG and not yes:
        raise ParameterError(f"{what} takes about {describe_time(seconds)}: give --yes to go on, or {instead}")


def quantity(value: float) -> str:
    """Write a number for reading: with a decimal and thousands apart, or in scientific notation if it is huge."""
    return f"{value:,.1f}" if abs(value) < 1e7 else f"{value:.1e}"


def show_laws(summary: dict[str, dict[str, Any]]) -> None:
    """Print one row a law: how it ended, peak torque, aspect, tracking error."""
    table = Table("law", "peak torque", "aspect", "tracking error", "ended", box=None, pad_edge=False)
    for column in table.columns:
        column.overflow = "fold"
    for law, values in summary.items():
        table.add_row(
            law,
            f"{quantity(max(values['peak_torque']))} N m",
            "kept" if values["aspect_preserved"] else f"left, {len(values['minor_zero_crossings'])} sign changes",
            f"{1e3 * values['max_tracking_error']:.2g} mm",
            values["status"],
        )
    Console().print(table)
    for law, values in summary.items():
        if values["status"] != "finished":
            Console().print(escape(f"{law}: {values['message']}"))


def show_claims(claims: Sequence[Claim]) -> None:
    """Print one row a claim: the verdict, what the paper says, what was measured."""
    table = Table("verdict", "the paper says", "measured", box=SIMPLE_HEAD, pad_edge=False)
    for claim in claims:
        colour = "green" if claim.verdict == AGREES else "yellow"
        table.add_row(f"[{colour}]{claim.verdict}[/]", f"{claim.subject}: {claim.says}", escape(claim.measured))
    Console().print(table)


def show_table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print rows of text under a header."""
    table = Table(*header, box=None, pad_edge=False)
    for column in table.columns:
        column.overflow = "fold"
    for row in rows:
        table.add_row(*map(escape, row))
    Console().print(table)


def show_start(chosen: Start) -> None:
    """Print a chosen start beside the posture that it is better than, and the self-motion between them."""
    arm = chosen.arm
    before, after = arm.positions(chosen.reference_q), arm.positions(chosen.q)
    show_table(
        ("joint", "now", "chosen", "change"),
        [
            (name, *(f"{value:.4f} m" if sliding else f"{np.rad2deg(value):.1f}°" for value in values))
            for name, sliding, *values in zip(arm.joint_names, arm.prismatic, before, after, chosen.change, strict=True)
        ],
    )
    borders = [len(arm.minors_on_border(q)) for q in (chosen.reference_q, chosen.q)]
    vanishing = chosen.criterion == "minor-measure"
    Console().print()
    show_table(
        ("", "now", "chosen"),
        [
            # On a border, what is left of zero is rounding.
            (
                chosen.criterion,
                "0" if borders[0] and vanishing else f"{chosen.reference_value:.4g}",
                "0" if borders[1] and vanishing else f"{chosen.value:.4g}",
            ),
            (
                "smallest minor, part of its scale",
                "0" if borders[0] else f"{chosen.reference_smallest_minor:.2g}",
                "0" if borders[1] else f"{chosen.smallest_minor:.2g}",
            ),
            (f"minors on a border, of {len(arm.minor_columns)}", *map(str, borders)),
        ],
    )
    console = Console(soft_wrap=True)
    console.print()
    console.print(escape(f"{chosen.found}, inside the joint limits"), highlight=False)
    if borders[0]:
        named = arm.minors.describe(arm.minors_on_border(chosen.reference_q))
        console.print(escape(f"on a border now: {named}"), highlight=False)
    for curve in chosen.curves[:1]:
        console.print(escape(describe_self_motion(curve)), highlight=False)
        grown = growth(curve)
        console.print(describe_growth(curve.length, curve.closed, grown.factor, grown.largest_factor), highlight=False)
    if chosen.sample is not None:
        console.print(f"the sample passes {len(chosen.sample.signatures)} signatures", highlight=False)
    positions = ", ".join(f"{value:.6f}" for value in after)
    console.print(escape(f"start.positions = [{positions}]"), highlight=False)


def describe_self_motion(curve: SelfMotion) -> str:
    """Say in words how long a self-motion is, how it ends, and what it passes."""
    shape = "closed" if curve.closed else f"open ({curve.ends[0]}, {curve.ends[1]})"
    limits = ", ".join(f"{each.joint} at {each.s:.3f}" for each in curve.limit_crossings if each.leaving)
    return (
        f"self-motion through the present start: {shape}, {curve.length:.2f} rad long, {len(curve.aspects)} stretches "
        f"in {len(curve.signatures)} aspect signatures, {len(curve.crossings)} sign changes of minors; "
        + (f"joints leave their limits: {limits}" if limits else "no joint limit is met")
    )


def show_atlas(record: Mapping[str, Any]) -> None:
    """Print what an atlas holds, and what the paths of the laws do in it."""
    signatures, console = record["signatures"], Console(soft_wrap=True)
    first, second = record["axes"]
    console.print(
        escape(
            f"slice of {first} and {second}: {len(signatures)} aspect signatures, the largest on "
            f"{signatures[0]['share']:.1%} of it, the smallest on {signatures[-1]['share']:.2%}"
        ),
        highlight=False,
    )
    console.print()
    paths = record["paths"]
    show_table(
        ("path", "sign changes of minors", "signs as in the slice"),
        [(law, str(path["sign_changes"]), f"{path['agreement']:.0%} of it") for law, path in paths.items()],
    )
    if "self_motion" in record:
        numbers = ("maciejewski_product_max", "own_product", "c", "self_motion_speed")
        console.print()
        show_table(
            ("path, at its peak of Eq. (12)", "θ̇_H·θ̈_H", "−c ṡ³", "c (1/rad)", "ṡ (rad/s)"),
            [(law, *(f"{path[name]:.3g}" for name in numbers)) for law, path in paths.items()],
        )
        console.print()
        console.print(describe_growth(**record["self_motion"]), highlight=False)


def describe_growth(length: float, closed: bool, growth: float, largest_growth: float) -> str:
    """Say in words what a free self-motion does under minimum torque."""
    way = "once round" if closed else "from end to end"
    return (
        f"free self-motion through the start, {length:.2f} rad long, under minimum torque: its speed is multiplied by "
        f"{growth:.3g} {way}, by up to {largest_growth:.3g} from one place to another"
    )
