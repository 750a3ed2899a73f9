"""Whole control ticks, literal and this project's, beside the floor; many minors beside theirs.

What is timed is what runs at the time of the call: plain NumPy or, after `compile_kernels`, compiled.
"""

from __future__ import annotations

from aspect_control import controllers
from aspect_control.arm import Arm
from aspect_control.controllers import Controller
from aspect_control.redundancy.gradients import expanded_gradient
from aspect_control.redundancy.laplace import laplace_expansion
from oracles import literal

from . import arms
from .arms import Sample
from .floor import floor
from .timing import Call, EveryTick, Motion, Row, around, every_tick, interleaved


def tick(name: str, arm: Arm, samples: list[Sample]) -> Call:
    """Return one control tick of a law at one state after the other."""
    law = controllers.create(name, arm)
    law.reset(samples[0].q, samples[0].v, literal.DT)
    return around(lambda sample: law.torque(sample.q, sample.v, sample.target), samples)


def ticks(name: str, arm: Arm, rounds: int, *, with_literal: bool) -> list[Row]:
    """Time one tick of every closed-form law on one arm.

    Args:
        name: Name of the arm.
        arm: The arm.
        rounds: Number of rounds.
        with_literal: Whether to time the equations as printed, too, which are never compiled.
    """
    samples = arms.samples(arm)
    calls = {"floor": around(floor(arm), samples)}
    notes = {"floor": "M, N, J, J̇θ̇, x by Pinocchio"}
    for law, (equations, as_printed, here) in literal.LAWS.items():
        calls[law], notes[law] = tick(law, arm, samples), _pseudoinverses(here)
        if with_literal:

            def as_in_the_paper(sample: Sample, equations=equations) -> object:  # type: ignore[no-untyped-def]
                return equations(arm, arm.state(sample.q, sample.v), sample.target)

            calls[f"{law}, literal"] = around(as_in_the_paper, samples)
            notes[f"{law}, literal"] = _pseudoinverses(as_printed)
    calls["resolved-motion"] = tick("resolved-motion", arm, samples)
    seconds = interleaved(calls, rounds)
    return [Row(f"{name}: tick", each, seconds[each], seconds["floor"], "floor", notes.get(each, "")) for each in calls]


def every_tick_of_a_motion(arm: Arm, least: int) -> list[EveryTick]:
    """Time every tick of a motion of Panda under every registered law.

    Args:
        arm: Panda with the position of its tool as the task.
        least: The least number of ticks of each law.
    """
    samples = arms.motion(arm)
    calls = {"floor": Motion(floor(arm))}
    calls |= {name: _in_order(controllers.create(name, arm), samples[0]) for name in controllers.available()}
    return every_tick("Panda, xyz: every tick of a motion", calls, samples, least)


def _in_order(law: Controller, first: Sample) -> Motion:
    return Motion(
        lambda sample: law.torque(sample.q, sample.v, sample.target), lambda: law.reset(first.q, first.v, literal.DT)
    )


def many_minors(rounds: int) -> list[Row]:
    """Time the gradient of 1,140 minors, with the kinematic Hessian, beside the floor of that arm."""
    arm = arms.chain(20)
    samples = arms.samples(arm)
    terms, count = laplace_expansion(arm.minor_columns), len(arm.minor_columns)

    def gradient(sample: Sample) -> object:
        return expanded_gradient(sample.state.J, arm.jacobian_derivative(sample.q), terms)

    calls = {"floor": around(floor(arm), samples), f"{count:,} minors and ∇H": around(gradient, samples)}
    seconds = interleaved(calls, rounds)
    return [Row("chain of 20, xyz", each, seconds[each], seconds["floor"], "floor") for each in calls]


def _pseudoinverses(count: int) -> str:
    return f"{count} pseudoinverse" + ("s" if count > 1 else "")
