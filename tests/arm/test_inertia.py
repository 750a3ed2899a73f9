"""Masses and inertias that no body can have are named when an arm is made, however it is made."""

import dataclasses
import re

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aspect_control import Arm
from aspect_control.arm.inertia import require_possible
from aspect_control.exceptions import ModelError
from conftest import seven_joint_urdf
from example_arms import serial_chain

URDF = seven_joint_urdf()
BOX = 'ixx="0.02" ixy="0.001" ixz="-0.002" iyy="0.05" iyz="0.003" izz="0.06"'


def in_link(number, old, new):
    """The seven-joint arm with one thing of one link replaced."""
    head, link, tail = re.split(rf'(<link name="link{number}">.*?</link>)', URDF, maxsplit=1, flags=re.DOTALL)
    assert old in link
    return head + link.replace(old, new) + tail


def spatial(text):
    return Arm.from_urdf_text(text, frame="tool", task="xyz")


def test_a_negative_mass_of_a_link_is_named_with_its_number():
    with pytest.raises(ModelError, match=r"^link 'link3' of the given text has a negative mass of -4\.25 kg$"):
        spatial(in_link(3, 'mass value="4.25"', 'mass value="-4.25"'))


def test_a_negative_mass_is_not_hidden_by_what_it_is_fixed_to():
    light = URDF.replace('<link name="tool"/>', '<link name="tool"><inertial><mass value="-0.5"/></inertial></link>')
    light = light.replace('<mass value="-0.5"/>', f'<mass value="-0.5"/><inertia {BOX}/>')
    with pytest.raises(ModelError, match=r"link 'tool' of the given text has a negative mass of -0\.5 kg"):
        spatial(light)


def test_the_triangle_inequality_is_named_with_joint_and_moments():
    text = in_link(5, BOX, 'ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.05"')
    words = r"what joint 'joint5' of 'seven' moves .* triangle inequality.*: 0\.01, 0\.02, 0\.05 kg m²$"
    with pytest.raises(ModelError, match=words):
        spatial(text)


def test_a_flat_body_has_a_moment_that_is_just_the_sum_of_the_others():
    spatial(in_link(5, BOX, 'ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.03"'))


def test_a_body_on_the_base_may_have_any_inertia_for_it_never_moves():
    inertia = '<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.05"/>'
    base = f'<link name="base"><inertial><mass value="1"/>{inertia}</inertial></link>'
    spatial(URDF.replace('<link name="base"/>', base))


def of_model(mass, moments):
    model = serial_chain(4)
    model.inertias[3] = pin.Inertia(mass, np.array([0.1, 0.0, 0.0]), np.diag(moments))
    return Arm.from_pinocchio(model, frame="tip", task="xyz")


@pytest.mark.parametrize(
    ("mass", "moments", "words"),
    [
        (-1.0, (1.0, 1.0, 1.0), r"a negative mass of -1 kg"),
        (1.0, (1.0, 1.0, 5.0), r"triangle inequality, .*: 1, 1, 5 kg m²"),
        (np.nan, (1.0, 1.0, 1.0), r"a mass or an inertia that is not finite: nan kg"),
    ],
)
def test_an_impossible_inertia_of_a_pinocchio_model_is_named(mass, moments, words):
    with pytest.raises(ModelError, match=f"what joint 'joint3' of 'chain of 4' moves has .*{words}"):
        of_model(mass, moments)


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ({0: -1.0}, "a negative mass of -1 kg"),
        ({12: 5.0}, "triangle inequality"),
        ({4: -1.0}, "a negative principal moment of inertia: -1, "),
        ({5: 0.5}, "an inertia that is not symmetric"),
    ],
)
def test_an_impossible_inertia_of_a_recorded_chain_is_named(numbers, words):
    description = Arm.from_pinocchio(serial_chain(4), frame="tip", task="xyz").description
    joint = description.chain.joints[1]
    inertia = [numbers.get(i, number) for i, number in enumerate(joint.inertia)]
    joints = [*description.chain.joints]
    joints[1] = dataclasses.replace(joint, inertia=inertia)
    falsified = dataclasses.replace(description, chain=dataclasses.replace(description.chain, joints=joints))
    with pytest.raises(ModelError, match=f"what joint 'joint2' moves has {words}|what joint 'joint2' moves .*{words}"):
        Arm.from_description(falsified)


@given(
    masses=st.lists(st.floats(0.01, 10.0), min_size=1, max_size=5),
    seed=st.integers(0, 2**32 - 1),
    unit=st.sampled_from([1e-3, 1.0, 1e3]),
)
def test_the_inertia_of_any_point_masses_is_possible(masses, seed, unit):
    points = np.random.default_rng(seed).normal(size=(len(masses), 3)) * unit
    points -= np.average(points, axis=0, weights=masses)
    inertia = sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, points, strict=True))
    require_possible("these points", sum(masses), inertia)


@given(seed=st.integers(0, 2**32 - 1), excess=st.floats(1e-6, 10.0))
def test_the_triangle_inequality_does_not_depend_on_the_axes(seed, excess):
    rng = np.random.default_rng(seed)
    turned = pin.exp3(rng.normal(size=3))
    a, b = rng.uniform(0.1, 1.0, 2)
    with pytest.raises(ModelError, match="triangle inequality"):
        require_possible("a body", 1.0, turned @ np.diag([a, b, a + b + excess]) @ turned.T)
