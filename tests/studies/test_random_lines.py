"""Lines drawn at random: even in direction, and never from a border."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from aspect_control import Arm, StraightLine
from aspect_control.exceptions import ParameterError
from aspect_control.studies.motions import RandomLines

STIFF = '<limit lower="-1e-9" upper="1e-9" effort="1e6" velocity="1e3"/>'


def test_starts_fill_the_whole_turn_and_directions_are_even():
    arm = Arm.from_example("planar3r", frame="tool", task="xy")
    lines = RandomLines.after("planar3r", arm, StraightLine([1.5, 1.0], 2.0), seed=0)
    motions = [lines.draw(index) for index in range(400)]
    angles = np.array([arm.positions(motion.q0) for motion in motions])
    assert np.all(np.abs(angles) <= np.pi)
    # The first angle turns the whole picture, so that it and the direction of the line are uniform.
    directions = np.array([np.arctan2(*motion.trajectory.displacement[::-1]) for motion in motions])
    for values in (angles[:, 0], directions):
        assert abs(np.exp(1j * values).mean()) < 3.0 / math.sqrt(len(motions))


def test_starts_at_rank_loss_are_drawn_again_and_counted(planar_path):
    text = Path(planar_path).read_text()
    for part in re.split(r"(?=<limit )", text)[2:]:
        text = text.replace(part, re.sub(r"<limit [^>]*>", STIFF, part))
    arm = Arm.from_urdf_text(text, frame="tool", task="xy")
    lines = RandomLines.after("stretched", arm, StraightLine([1.5, 1.0], 2.0), seed=0)
    with pytest.raises(ParameterError, match=r"no line was found for stretched .* [1-9][\d,]* started on a border"):
        lines.draw(0)
