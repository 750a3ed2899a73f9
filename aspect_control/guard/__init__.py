"""What stands between a law and a robot: whether a path can be reached, and going over from one law to another."""

from .blend import Blend, BlendMemory
from .reach import Reach, check_reach, out_of_reach

__all__ = ["Blend", "BlendMemory", "Reach", "check_reach", "out_of_reach"]
