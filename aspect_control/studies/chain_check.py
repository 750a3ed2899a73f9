"""Every chain of every example robot against the full, unreduced Pinocchio model."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from ..arm import Arm
from ..arm.chain import joints_to_lock, require_frame
from ..arm.sources.examples import end_frames, example_names, load_example_model
from ..exceptions import AspectControlError
from ..redundancy import Array

STATES = 3
"""Random states at which a chain is compared."""


@dataclass(frozen=True)
class ChainCheck:
    """How far an arm is from the full model, or why there is none.

    Attributes:
        robot: Name of the example robot.
        frame: The end frame; empty if the robot cannot be loaded.
        joints: Number of joints of the chain.
        deviation: Largest relative deviation of M, N, J, J̇θ̇ and x over the states; None if there is no arm.
        problem: Why there is no arm; empty if there is one.
    """

    robot: str
    frame: str
    joints: int
    deviation: float | None
    problem: str

    def to_dict(self) -> dict[str, Any]:
        """Return the row as plain numbers and strings, for JSON."""
        return asdict(self)


def check_chains(progress: Callable[[str, float], None]) -> list[ChainCheck]:
    """Check every chain of every example robot.

    Args:
        progress: Called with the robot and the part of all work that is done, 0 to 1.
    """
    names = example_names()
    rows = []
    for i, name in enumerate(names):
        progress(name, i / len(names))
        rows += list(_check_robot(name))
    return rows


def _check_robot(name: str) -> Iterator[ChainCheck]:
    try:
        model = load_example_model(name)
    except AspectControlError as error:
        yield ChainCheck(name, "", 0, None, str(error))
        return
    frames = end_frames(model)
    if not frames:
        yield ChainCheck(name, "", 0, None, "no joint moves anything: the robot has no arm")
    yield from (_check_chain(name, frame, model) for frame in frames)


def _check_chain(name: str, frame: str, model: Any) -> ChainCheck:
    try:
        arm = Arm.from_example(name, frame=frame, task="pose")
    except AspectControlError as error:
        return ChainCheck(name, frame, 0, None, str(error))
    return ChainCheck(name, frame, arm.nv, chain_deviation(arm, model), "")


def chain_deviation(arm: Arm, model: Any) -> float:
    """Return the largest relative deviation of an arm from the full model over random states.

    Compared are M, N, J, J̇θ̇ and x, each relative to its largest entry; the full model has all other joints at the
    neutral position and at rest.

    Args:
        arm: The arm, with the task `pose` and no `locked` joints.
        model: The whole robot, a `pin.Model`.
    """
    rng = np.random.default_rng(1)
    _, reference = joints_to_lock(model, arm.frame)
    kept = [model.getJointId(name) for name in arm.joint_names]
    velocity_rows = [model.joints[joint].idx_v for joint in kept]
    deviations = []
    for _ in range(STATES):
        positions, v = rng.uniform(-1.0, 1.0, arm.nv), rng.uniform(-1.0, 1.0, arm.nv)
        q = arm.configuration(positions)
        full_q, full_v = reference.copy(), np.zeros(model.nv)
        full_v[velocity_rows] = v
        for index, joint in enumerate(kept):
            mine, whole = arm.model.joints[index + 1], model.joints[joint]
            full_q[whole.idx_q : whole.idx_q + whole.nq] = q[mine.idx_q : mine.idx_q + mine.nq]
        deviations.append(_deviation(arm, q, v, model, full_q, full_v, velocity_rows))
    return max(deviations)


def _deviation(
    arm: Arm, q: Array, v: Array, model: Any, full_q: Array, full_v: Array, velocity_rows: list[int]
) -> float:
    data, frame_id, aligned = (
        model.createData(),
        require_frame(model, arm.frame),
        pin.ReferenceFrame.LOCAL_WORLD_ALIGNED,
    )
    state, rest = arm.state(q, v), np.zeros(model.nv)
    M = pin.crba(model, data, full_q).reshape(model.nv, model.nv)[np.ix_(velocity_rows, velocity_rows)]
    nle = pin.rnea(model, data, full_q, full_v, rest)[velocity_rows]
    J = pin.computeFrameJacobian(model, data, full_q, frame_id, aligned).reshape(6, model.nv)[:, velocity_rows]
    pin.forwardKinematics(model, data, full_q, full_v, rest)
    placement = pin.updateFramePlacement(model, data, frame_id)
    drift = pin.getFrameClassicalAcceleration(model, data, frame_id, aligned).vector
    pairs = (
        (state.M, M),
        (state.nle, nle),
        (state.J, J),
        (state.drift, drift),
        (state.x.homogeneous, placement.homogeneous),
    )
    return max(float(np.abs(mine - full).max() / max(np.abs(full).max(), 1e-12)) for mine, full in pairs)
