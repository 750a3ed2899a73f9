"""The loop on a robot's clock, what it measures, and a simulated robot to try it on."""

from .motions import Motion
from .real_time_loop import RealTimeLoop
from .robot import ClockedRobot, Robot
from .simulated_robot import SimulatedRobot, SimulationProcess
from .streamed_target import StreamedTarget
from .timing import Percentiles, Timing

__all__ = [
    "ClockedRobot",
    "Percentiles",
    "RealTimeLoop",
    "Robot",
    "SimulatedRobot",
    "SimulationProcess",
    "StreamedTarget",
    "Timing",
]
