"""The loop on a robot's clock, what it measures, and a simulated robot to try it on."""

from .real_time_loop import RealTimeLoop
from .robot_protocol import ClockedRobot, Robot
from .simulated_robot import SimulatedRobot, SimulationProcess
from .streamed_target import StreamedTarget
from .timing import Percentiles, Timing
from .velocity_estimator import VelocityEstimator

__all__ = [
    "ClockedRobot",
    "Percentiles",
    "RealTimeLoop",
    "Robot",
    "SimulatedRobot",
    "SimulationProcess",
    "StreamedTarget",
    "Timing",
    "VelocityEstimator",
]
