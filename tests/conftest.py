"""The arms that the tests share."""

import pytest
from hypothesis import settings

from aspect_control import Arm
from aspect_control.redundancy import kernels
from aspect_control.resources import model_path
from aspect_control.studies.warm import warm_up

settings.register_profile("suite", deadline=None, derandomize=True, max_examples=60)
settings.load_profile("suite")

# Origin and axis of each joint: no two neighbouring axes are parallel or meet in a point of symmetry.
JOINTS = (
    ("0.00 0.00 0.30", "0 0 0.2", "0 0 1"),
    ("0.05 0.02 0.20", "0.3 0 0", "0 1 0"),
    ("0.10 -0.04 0.30", "0 0.4 0", "1 0 0"),
    ("0.30 0.05 0.10", "0.2 0 0.5", "0 1 0"),
    ("0.25 0.00 0.08", "0 -0.3 0.1", "0.6 0 0.8"),
    ("0.20 -0.06 0.00", "0.5 0.1 0", "0 0.8 -0.6"),
    ("0.12 0.03 0.05", "0 0.2 -0.7", "0 0 1"),
)
LINK = """
  <link name="link{i}">
    <inertial>
      <origin xyz="0.1 -0.02 0.05" rpy="0.3 -0.2 0.6"/>
      <mass value="{mass}"/>
      <inertia ixx="0.02" ixy="0.001" ixz="-0.002" iyy="0.05" iyz="0.003" izz="0.06"/>
    </inertial>
  </link>
  <joint name="joint{i}" type="revolute">
    <parent link="{parent}"/><child link="link{i}"/>
    <origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>
    <limit lower="-3" upper="3" effort="100" velocity="10"/>
  </joint>"""
TOOL = """
  <link name="tool"/>
  <joint name="tool_joint" type="fixed">
    <parent link="link7"/><child link="tool"/><origin xyz="0.15 0.10 0.20" rpy="0.4 0.5 0.6"/>
  </joint>"""


def seven_joint_urdf():
    links = [
        LINK.format(i=i, parent=f"link{i - 1}" if i > 1 else "base", mass=6.5 - 0.75 * i, xyz=xyz, rpy=rpy, axis=axis)
        for i, (xyz, rpy, axis) in enumerate(JOINTS, start=1)
    ]
    return f'<robot name="seven">\n  <link name="base"/>{"".join(links)}{TOOL}\n</robot>\n'


@pytest.fixture(scope="module", autouse=True)
def plain_numpy_again():
    """What a study compiles in this process is plain NumPy again for the tests of the next file."""
    yield
    for each in kernels._KERNELS:
        each._call, each.is_compiled = each.text, False
    warm_up.cache_clear()


@pytest.fixture(scope="session")
def planar_path():
    return model_path("planar3r.urdf")


@pytest.fixture(scope="session")
def planar(planar_path):
    """The paper's arm in its horizontal plane: n = 3, m = 2."""
    return Arm.from_urdf(planar_path, frame="tool", task="xy", gravity=(0.0, 0.0, 0.0))


@pytest.fixture(scope="session")
def seven():
    """A spatial arm under gravity: n = 7, m = 3."""
    return Arm.from_urdf_text(seven_joint_urdf(), frame="tool", task="xyz")


@pytest.fixture(scope="session", params=["planar", "seven"])
def arm(request):
    return request.getfixturevalue(request.param)
