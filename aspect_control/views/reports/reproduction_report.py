"""Results as Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ...analysis import ContinuousLimit
from ...simulation import Run
from ...studies.paper import Claim
from ...studies.paper.trajectory_a import Reproduction
from .markdown import markdown_table


def reproduction_report(reproduction: Reproduction, claims: Sequence[Claim]) -> str:
    """Return the report on the paper's Section 4 as Markdown.

    Args:
        reproduction: The runs.
        claims: What came of holding them against the paper.
    """
    run = reproduction.runs["null-space-vector"]
    counts = ", ".join(f"{verdict} {sum(c.verdict == verdict for c in claims)}" for verdict in _verdicts(claims))
    settings = ", ".join(f"{name} {number}" for name, number in run.info.versions.items())
    return "\n".join(
        [
            "# The paper's Section 4, run again",
            "",
            "W. J. Chung, W. K. Chung and Y. Youm, *Analysis of Dynamic Performance of Redundant Manipulators Using "
            "the Concept of Aspects*.",
            "",
            f"Trajectory A: `{run.info.trajectory}` from θ = (−50°, 140°, −140°), no gravity, sampling time "
            f"{reproduction.dt:g} s, torque held between samples, plant integrated by {run.info.integrator}. "
            f"Computed with {settings}.",
            "",
            f"Of {len(claims)} claims: {counts}.",
            "",
            *markdown_table(
                ("about", "the paper says", "measured", "verdict", "why"),
                ((c.subject, c.says, c.measured, c.verdict, c.why if c.verdict != "agrees" else "") for c in claims),
            ),
            "",
            "![null space vector](fig2.png)",
            "",
            "![modified null space vector](fig3.png)",
            "",
            "![JMDC](fig4.png)",
            "",
            "![the laws together](comparison.png)",
            "",
            "## The null space vector method as the sampling time goes to zero",
            "",
            "The second peak is so sharp that its height depends on the sampling time. The continuous-time closed "
            "loop is integrated by an eighth-order Runge-Kutta method (DOP853, relative and absolute tolerance 1e-10) "
            f"with {reproduction.limit.evaluations:,} evaluations of the law; the paper gives 6.5·10⁵ for the peak of "
            "θ̇_H·θ̈_H.",
            "",
            *_convergence_table(reproduction.refined, reproduction.limit),
            "",
        ]
    )


def _convergence_table(refined: Iterable[Run], limit: ContinuousLimit) -> list[str]:
    """Return a Markdown table of the peaks of ever finer sampled runs beside their limit."""
    rows = []
    for run in refined:
        if run.status != "finished":
            rows.append((f"{run.info.dt:g}", run.message, "", "", ""))
            continue
        largest, product = np.abs(run.tau).max(axis=1), run.maciejewski_product
        rows.append(
            (
                f"{run.info.dt:g}",
                f"{largest.max():,.0f}",
                f"{run.t[largest.argmax()]:.4f}",
                _scientific(product.max()),
                f"{run.t[product.argmax()]:.4f}",
            )
        )
    joint = int(limit.peak_torque.argmax())
    rows.append(
        (
            "→ 0",
            f"{limit.peak_torque[joint]:,.0f}",
            f"{limit.peak_torque_time[joint]:.4f}",
            _scientific(limit.maciejewski_product_max),
            f"{limit.maciejewski_product_max_time:.4f}",
        )
    )
    return markdown_table(("dt (s)", "peak torque (N m)", "at (s)", "peak of θ̇_H·θ̈_H (rad²/s³)", "at (s)"), rows)


def _verdicts(claims: Sequence[Claim]) -> list[str]:
    return list(dict.fromkeys(claim.verdict for claim in claims))


def _scientific(value: float) -> str:
    mantissa, exponent = f"{value:.2e}".split("e")
    return f"{mantissa}·10^{int(exponent)}"
