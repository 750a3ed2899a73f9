"""What users write, as the strict type checker sees it: checked by mypy, never run."""

from __future__ import annotations

from typing import assert_type

import numpy as np
from numpy.typing import NDArray

import aspect_control as ac


class OwnLaw(ac.controllers.TaskSpaceController):
    """A law of a user's own."""

    name = "own-law"

    def command(self, state: ac.ArmState, target: ac.Target) -> NDArray[np.float64]:
        """Return a torque."""
        b = self.commanded_acceleration(state, target)
        return ac.redundancy.pseudoinverse_torque(state.M, state.nle, state.J, b)


class Bench:
    """A robot of a user's own."""

    def read(self) -> tuple[list[float], list[float]]:
        """Return q and v."""
        return [0.1, 0.2, 0.3], [0.0, 0.0, 0.0]

    def write(self, tau: NDArray[np.float64]) -> None:
        """Take a torque."""


def use() -> None:
    """Call the public face."""
    arm = ac.Arm.from_urdf("models/planar3r.urdf", frame="tool", task="xy", gravity=(0, 0, 0))
    assert_type(arm.nq, int)
    assert_type(arm.redundancy, int)
    assert_type(arm.torque_limit, NDArray[np.float64])
    state = arm.state([0.1, 0.2, 0.3], [0.0, 0.0, 0.0])
    assert_type(state, ac.ArmState)
    assert_type(state.M, NDArray[np.float64])
    law = ac.controllers.create("modified-null-space-vector", arm, kp=100.0, kv=20.0)
    assert_type(law, ac.controllers.Controller)
    law.reset([0.1, 0.2, 0.3], np.zeros(3), 1e-3)
    guard = ac.Guard(law, torque="urdf", speed="urdf", position="urdf", torque_rate=None)
    assert_type(guard.status.state, str)
    assert_type(guard.status.reason, str)
    target = ac.Target(x=arm.task_position([0.1, 0.2, 0.3]), dx=np.zeros(2), ddx=np.zeros(2))
    assert_type(law.torque([0.1, 0.2, 0.3], np.zeros(3), target), NDArray[np.float64])
    line = ac.StraightLine(displacement=[1.5, 1.0], duration=2.0, profile="bang-bang")
    circle = ac.trajectories.create("circle", radius=0.1, duration=1.0)
    assert_type(circle, ac.Trajectory)
    reach = ac.check_reach(arm, line, [0.1, 0.2, 0.3])
    assert_type(reach.reachable, bool)
    assert_type(reach.message, str)
    blend = ac.Blend(law, ac.controllers.create("jmdc", arm), duration=0.2, switch_at=1.0)
    blend.switch()
    assert_type(blend.share, float)
    plant = ac.plants.RigidBodyPlant(arm)
    run = ac.simulate(OwnLaw(arm), line, q0=np.deg2rad([-50, 140, -140]), dt=1e-3, plant=plant)
    assert_type(run, ac.Run)
    assert_type(run.status, str)
    assert_type(run.tracking_error, NDArray[np.float64])
    loop = ac.RealTimeLoop(Bench(), law, dt=1e-3)
    assert_type(loop.follow(line), ac.Run)
    assert_type(loop.timing.tick.p99_9, float)
    run.save("run.npz")
    assert_type(ac.Run.load("run.npz"), ac.Run)
    study = ac.Study.load("examples/studies/planar3r-study.toml")
    assert_type(study.hash, str)
    assert_type(study.record("planar3r", 0, "jmdc"), ac.Run)
    assert_type(run.metrics(), dict[str, float | int | bool | str | None])
