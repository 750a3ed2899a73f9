"""Least torque as a quadratic program, with limits."""

from .law import QPStatus, QPTorque

__all__ = ["QPStatus", "QPTorque"]
