"""Row groups 2 and 3: whole control ticks, literal and this project's, beside the floor; many minors beside theirs."""

from __future__ import annotations

from .. import controllers
from ..arm import Arm
from ..redundancy.gradients import expanded_gradient, laplace_expansion
from . import arms, literal
from .arms import Sample
from .floor import floor
from .timing import Call, Row, around, in_turn


def tick(name: str, arm: Arm, samples: list[Sample]) -> Call:
    """Return one control tick of a law at one state after the other."""
    law = controllers.create(name, arm)
    law.reset(samples[0].q, samples[0].v, literal.DT)
    return around(lambda sample: law.torque(sample.q, sample.v, sample.target), samples)


def ticks(name: str, arm: Arm, rounds: int) -> list[Row]:
    """Time one tick of every closed-form law on one arm, literal and this project's."""
    samples = arms.samples(arm)
    calls = {"floor": around(floor(arm), samples)}
    notes = {"floor": "M, N, J, J̇θ̇, x by Pinocchio"}
    for law, (equations, as_printed, here) in literal.LAWS.items():

        def as_in_the_paper(sample: Sample, equations=equations) -> object:  # type: ignore[no-untyped-def]
            return equations(arm, arm.state(sample.q, sample.v), sample.target)

        calls[law] = tick(law, arm, samples)
        calls[f"{law}, literal"] = around(as_in_the_paper, samples)
        notes[law], notes[f"{law}, literal"] = _pseudoinverses(here), _pseudoinverses(as_printed)
    calls["resolved-motion"] = tick("resolved-motion", arm, samples)
    seconds = in_turn(calls, rounds)
    return [Row(f"{name}: tick", each, seconds[each], seconds["floor"], "floor", notes.get(each, "")) for each in calls]


def many_minors(rounds: int) -> list[Row]:
    """Time the gradient of 1,140 minors, with the kinematic Hessian, beside the floor of that arm."""
    arm = arms.chain(20)
    samples = arms.samples(arm)
    terms, count = laplace_expansion(arm.minor_columns), len(arm.minor_columns)

    def gradient(sample: Sample) -> object:
        return expanded_gradient(sample.state.J, arm.jacobian_derivative(sample.q), terms)

    calls = {"floor": around(floor(arm), samples), f"{count:,} minors and ∇H": around(gradient, samples)}
    seconds = in_turn(calls, rounds)
    return [Row("chain of 20, xyz", each, seconds[each], seconds["floor"], "floor") for each in calls]


def _pseudoinverses(count: int) -> str:
    return f"{count} pseudoinverse" + ("s" if count > 1 else "")
