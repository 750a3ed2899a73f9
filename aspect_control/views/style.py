"""How every figure looks: colours that colour-blind readers tell apart, and sizes that survive a README."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
"""The palette of Okabe and Ito, one colour a line."""

DASHES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (1.5, 1)), (0, (5, 1, 1, 1)), (0, (3, 1, 1, 1, 1, 1)), "-", "-")
"""Line styles that go with the colours, for readers without any."""

LAW_NAMES = {
    "pseudoinverse": "pseudoinverse",
    "null-space-vector": "null space vector",
    "modified-null-space-vector": "modified null space vector",
    "modified-null-space-vector-dead-beat": "modified, dead-beat",
    "jmdc": "JMDC",
    "jmdc-without-minor-measure": "JMDC, κ = 0",
}
"""How the laws are called in figures; other laws go by their registry names."""

_SETTINGS: dict[Any, Any] = {
    "font.size": 11.0,
    "axes.titlesize": 11.0,
    "axes.titlelocation": "left",
    "axes.grid": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.alpha": 0.3,
    "lines.linewidth": 1.6,
    "legend.frameon": True,
    "legend.framealpha": 0.85,
    "legend.edgecolor": "none",
    "legend.fontsize": 10.0,
    "savefig.dpi": 120,
    "svg.hashsalt": "aspect-control",
    "svg.fonttype": "none",
}


@contextmanager
def style() -> Iterator[None]:
    """Draw the figures made inside the block in the style of the package."""
    with mpl.rc_context(_SETTINGS):
        yield


def law_name(name: str) -> str:
    """Return how a law is called in figures."""
    return LAW_NAMES.get(name, plain_text(name))


def plain_text(text: str) -> str:
    """Return text from outside so that a figure shows it letter by letter, without reading mathematics into it."""
    return text.replace("$", r"\$")
