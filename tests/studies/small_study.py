"""A study of a second, and what the tests of studies share."""

import subprocess
import sys
from pathlib import Path

from aspect_control.studies.rows import UNREPEATABLE

COMMAND = str(Path(sys.executable).with_name("aspect-control"))

SMALL = """
scenarios = ["planar3r"]
endings = ["diverged", "workspace-left", "tracking-lost"]
saturation = false

[motions]
random = 6
seed = 3

[[laws]]
name = "null-space-vector"

[[laws]]
name = "jmdc"

[[grid]]
controller.kp = [50, 100]
simulation.dt = [0.01]
"""
"""24 runs of a hundredth of a second or two."""


def study_file(folder, text=SMALL, name="small"):
    path = Path(folder) / f"{name}.toml"
    path.write_text(text)
    return path


def repeatable(table):
    """The table without the columns that tell of the machine and the time."""
    return table.drop(list(UNREPEATABLE))


def run_command(*arguments, **options):
    settings = {"capture_output": True, "text": True, "check": False} | options
    return subprocess.run([COMMAND, *map(str, arguments)], **settings)


def start_command(*arguments, **options):
    """A command in a session of its own, so that a signal to its group reaches no one else."""
    return subprocess.Popen([COMMAND, *map(str, arguments)], start_new_session=True, text=True, **options)


def processes_of(session):
    """The processes of a session that are alive."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                state, _, _, owner = (entry / "stat").read_text().rpartition(")")[2].split()[:4]
            except OSError:
                continue
            if int(owner) == session and state != "Z":
                found.append(int(entry.name))
    return found
