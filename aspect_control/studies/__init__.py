"""Many runs: the engine that makes them, and the studies made with it, from the paper's own case to random motions."""

from .cases import Place
from .study import Study
from .study_progress import StudyProgress

__all__ = ["Place", "Study", "StudyProgress"]
