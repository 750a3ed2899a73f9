"""How often the commands build an arm: once a scenario, whatever they do with it."""

import pytest

from aspect_control import Arm
from aspect_control.cli.commands import app
from aspect_control.studies.paper import trajectory_a
from aspect_control.views.replays.live import LiveView

QUICK = ["--set", "simulation.dt=0.02"]
SHORT = ["--set", "trajectory.duration=0.1", "--set", "trajectory.displacement=[0.002, 0.001]"]


@pytest.fixture
def built(monkeypatch):
    """The names of the arms that were built."""
    names = []
    construct = Arm.__init__

    def counted(self, *arguments, **options):
        construct(self, *arguments, **options)
        names.append(self.name)

    monkeypatch.setattr(Arm, "__init__", counted)
    return names


@pytest.mark.filterwarnings("ignore::aspect_control.exceptions.AspectBorderWarning")
@pytest.mark.parametrize(
    "command",
    [
        ["run", "planar3r", *QUICK],
        ["run", "planar3r", *QUICK, *SHORT, "--live", "--port", "0"],
        ["atlas", "planar3r", *QUICK, "--resolution", "10"],
        ["start", "planar3r"],
    ],
    ids=["run", "run --live", "atlas", "start"],
)
def test_a_command_builds_the_arm_of_its_scenario_once(tmp_path, monkeypatch, built, command):
    monkeypatch.setattr(LiveView, "wait_for_viewer", lambda self: None)
    app([*command, "--out", str(tmp_path / "out")], standalone_mode=False)
    assert built == ["planar3r"]


def test_the_papers_case_is_run_on_one_arm(monkeypatch, built):
    monkeypatch.setattr(trajectory_a, "SAMPLING_TIMES", (0.04, 0.02))
    trajectory_a.reproduce(0.04, keep=lambda law, run: None, progress=lambda label, part: None)
    assert built == ["planar3r"]
