"""Plants: what an arm does under a torque."""

from .base import Plant
from .rigid_body import RigidBodyPlant

__all__ = ["Plant", "RigidBodyPlant"]
