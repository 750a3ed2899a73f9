"""Scenarios: a robot, a task, a start, a trajectory and the laws to run on it, from a TOML file."""

from .reading import load_scenario
from .scenario import Scenario

__all__ = ["Scenario", "load_scenario"]
