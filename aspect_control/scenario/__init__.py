"""Scenarios: a robot, a task, a start, a trajectory and the laws to run on it, from a TOML file, built once and run."""

from .reading import changed, load_scenario
from .scenario import Scenario
from .setup import Setup

__all__ = ["Scenario", "Setup", "changed", "load_scenario"]
