"""Laws shown in a browser while they are simulated."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from ...arm import Arm
from ...checks import known_name, positive
from ...redundancy import Array, aspect_signature, pseudoinverse_torque
from ...simulation import Sample
from ...trajectories import Trajectory
from ..figures.panels import world_positions
from ..frames import FRAME_RATE, torque_limits
from ..style import law_name
from .scene.page import build_page
from .scene.readings import Reading, change_data, reading_message, run_data
from .scene.robot_scene import RobotScene, SceneRobot
from .scene.server import LOOPBACK, PORT, LiveServer, sleep_until

PATH_POINTS = 200
"""Points that the desired path is drawn with."""

AT_START = "the pseudoinverse law's largest at the start"
"""What torques without a limit are compared with while nothing else is known."""


class LiveView(LiveServer):
    """Laws on one arm, side by side in a browser, while `simulate` runs them one after the other in real time.

    ```python
    with LiveView(arm, ["jmdc"], q0, trajectory) as view:
        print(view.url)
        view.wait_for_viewer()
        simulate(controller, trajectory, q0=q0, watch=view.watch("jmdc"))
    ```

    Attributes:
        notes: What cannot be drawn as it should, one sentence each.
    """

    def __init__(
        self,
        arm: Arm,
        labels: Sequence[str],
        q0: ArrayLike,
        trajectory: Trajectory,
        *,
        speed: float = 1.0,
        host: str = LOOPBACK,
        port: int = PORT,
    ) -> None:
        """Draw the arms at the start and serve them.

        Args:
            arm: The arm.
            labels: The laws, one arm each.
            q0: Joint configuration at the start, shape (nq,), rad.
            trajectory: What the task is to do.
            speed: Seconds of motion shown in a second.
            host: Address to listen on; anything but loopback shows the page to the network.
            port: Port to listen on; if it is taken, the next one that is not. 0 for any.

        Raises:
            ParameterError: If `speed` is not above zero, or `host` or `port` is none.
            ShapeError: If q0 has the wrong shape.
            NonFiniteError: If q0 is not finite.
            OutputError: If the address cannot be listened on.
        """
        self._speed = positive("speed", speed)
        q = arm.joints.checked_configuration(q0)
        desired = _desired_path(arm, trajectory, q)
        points = np.concatenate([arm.skeleton(q), desired])
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        scene = RobotScene([SceneRobot(arm, q, middle + 1.3 * (points - middle)) for _ in labels])
        marks = torque_limits(arm, _torque_at_start(arm, trajectory, q))
        data = {
            "live": True,
            "speed": speed,
            "end": trajectory.duration,
            "compared": AT_START,
            **scene.data,
            "runs": [run_data(scene.nodes[i], law_name(label), arm, marks, desired) for i, label in enumerate(labels)],
        }
        self.notes = tuple(scene.notes)
        self._labels, self._duration = list(labels), trajectory.duration
        super().__init__(build_page(", ".join(labels), scene.recorder.commands, data), host=host, port=port)
        for i in range(len(labels)):
            self.send(reading_message(i, arm, q, Reading(0.0, np.zeros(arm.nv), arm.skeleton(q)[-1])))

    def watch(self, label: str) -> Callable[[Sample], None]:
        """Return what `simulate` is to call with every sample of a law: it shows the law's arm in real time.

        Args:
            label: One of the labels.

        Raises:
            UnknownNameError: If there is no such label.
        """
        known_name(label, self._labels, "label")
        return _Watch(self, self._labels.index(label), self._speed, self._duration)


class _Watch:
    """Shows one law's samples, `FRAME_RATE` a second, and holds the simulation back to real time."""

    def __init__(self, server: LiveServer, index: int, speed: float, duration: float) -> None:
        self._server, self._index, self._speed, self._duration = server, index, speed, duration
        self._start: float | None = None
        self._due = 0.0
        self._signs: Array | None = None

    def __call__(self, sample: Sample) -> None:
        if self._start is None:
            self._start = time.perf_counter()
        last = sample.t >= self._duration * (1.0 - 1e-9)
        if sample.t < self._due and not last:
            return
        self._due += self._speed / FRAME_RATE
        sleep_until(self._start + sample.t / self._speed)
        reading = Reading(sample.t, sample.tau, sample.arm.skeleton(sample.q)[-1])
        self._server.send(reading_message(self._index, sample.arm, sample.q, reading))
        for minor in self._changed(sample):
            self._server.send({"run": self._index, "change": change_data(sample.arm, minor, sample.t, sample.q)})

    def _changed(self, sample: Sample) -> list[int]:
        """Return the minors, counted from 0, that have changed sign since the sample shown before."""
        signs = aspect_signature(sample.arm.jacobian(sample.q), sample.arm.minor_columns).astype(np.float64)
        if self._signs is None:
            self._signs = signs
            self._signs[sample.arm.minors_on_border(sample.q)] = 0.0
        changed = np.flatnonzero(signs * self._signs < 0.0)
        self._signs = np.where((signs != 0.0) & (self._signs != 0.0), signs, self._signs)
        return [int(minor) for minor in changed]


def _desired_path(arm: Arm, trajectory: Trajectory, q: Array) -> Array:
    start = arm.task_position(q)
    targets = [trajectory.target(t, start, arm.coordinates) for t in np.linspace(0.0, trajectory.duration, PATH_POINTS)]
    path = world_positions(arm, np.array([arm.coordinates.encode(target.x) for target in targets]))
    return np.where(np.isnan(path), arm.skeleton(q)[-1], path)


def _torque_at_start(arm: Arm, trajectory: Trajectory, q: Array) -> Array:
    state = arm.state(q, np.zeros(arm.nv))
    target = trajectory.target(0.0, arm.task_position(q), arm.coordinates)
    tau = pseudoinverse_torque(state.M, state.nle, state.J, target.ddx)
    return np.full(arm.nv, float(np.abs(tau).max()) or 1.0)
