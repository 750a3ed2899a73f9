"""Recorded runs shown in a browser in real time."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping

from ...simulation import Run
from ..frames import FRAME_RATE, frame_times, labelled_runs
from .scene.page import build_page
from .scene.readings import CALMEST, reading_message, run_data, torque_marks
from .scene.replay_scene import Motion
from .scene.robot_scene import RobotScene
from .scene.server import LOOPBACK, PORT, LiveServer, sleep_until

PAUSE = 1.0
"""How long the last picture stands before a replay begins again, s."""


class LiveReplay(LiveServer):
    """Recorded runs, side by side and in step, played in a browser in real time again and again.

    Attributes:
        notes: What cannot be drawn as it should, one sentence each.
    """

    def __init__(
        self,
        runs: Run | Iterable[Run] | Mapping[str, Run],
        *,
        speed: float = 1.0,
        host: str = LOOPBACK,
        port: int = PORT,
    ) -> None:
        """Draw the runs and serve them.

        Args:
            runs: A run, several, or runs by their labels.
            speed: Seconds of motion shown in a second.
            host: Address to listen on; anything but loopback shows the page to the network.
            port: Port to listen on; if it is taken, the next one that is not. 0 for any.

        Raises:
            ParameterError: If there is no run, something is no run, a run has no samples, `speed` is not above zero,
                or `host` or `port` is none.
            NonFiniteError: If the first sample of a run is not finite.
            OutputError: If the address cannot be listened on.
        """
        shown = labelled_runs(runs)
        self._speed, self._times = speed, frame_times(list(shown.values()), FRAME_RATE, speed)
        self._motions = [Motion(label, run, self._times) for label, run in shown.items()]
        scene = RobotScene([motion.scene_robot for motion in self._motions])
        marks = torque_marks([motion.run for motion in self._motions])
        data = {
            "live": True,
            "speed": speed,
            "end": float(self._times[-1]),
            "compared": CALMEST,
            **scene.data,
            "runs": [
                {
                    **run_data(scene.nodes[i], motion.label, motion.run.arm, marks[i], motion.desired),
                    "changes": motion.changes(),
                }
                for i, motion in enumerate(self._motions)
            ],
        }
        self.notes = tuple(scene.notes)
        super().__init__(build_page(" and ".join(shown), scene.recorder.commands, data), host=host, port=port)

    def play(self) -> None:
        """Play the runs once, in real time, from the start, and let the last picture stand for a moment."""
        self.restart()
        readings = [motion.readings() for motion in self._motions]
        start = time.perf_counter()
        for frame, t in enumerate(self._times):
            sleep_until(start + (t - self._times[0]) / self._speed)
            for i, motion in enumerate(self._motions):
                q = motion.run.q[motion.samples[frame]]
                self.send(reading_message(i, motion.run.arm, q, readings[i][frame]))
                if motion.end is not None and motion.samples[frame] == len(motion.run.t) - 1:
                    self.send({"run": i, "end": motion.end})
        time.sleep(PAUSE)
