"""The adapters for real arms, held against what the libraries' own stubs and binaries say."""

import ast
import importlib.util
import inspect
import subprocess
import sys
import types
from functools import partial
from itertools import count
from pathlib import Path

import numpy as np
import pytest

from aspect_control import controllers
from aspect_control.exceptions import RobotError
from aspect_control.realtime import ClockedRobot, RealTimeLoop, Robot
from example_arms import example_arm

ROBOTS = Path(__file__).parents[2] / "examples" / "robots"
READY = np.array([0.0, -np.pi / 4, 0.0, -3.0 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4])


class Stub:
    """What a class of a library has, by the library's own .pyi: signatures of methods, and what can be set.

    Attributes:
        methods: Every signature of each method.
        readable: What can be read.
        settable: What can be set.
    """

    def __init__(self, name, classes):
        self.name, self.methods, self.readable, self.settable = name, {}, set(), set()
        for base in classes[name].bases:
            if ast.unparse(base) in classes:
                inherited = Stub(ast.unparse(base), classes)
                self.methods |= inherited.methods
                self.readable |= inherited.readable
                self.settable |= inherited.settable
        own = {}
        for node in classes[name].body:
            if isinstance(node, ast.AnnAssign):
                self.readable.add(node.target.id)
            elif isinstance(node, ast.FunctionDef):
                kinds = {ast.unparse(each) for each in node.decorator_list}
                if "property" in kinds:
                    self.readable.add(node.name)
                elif f"{node.name}.setter" in kinds:
                    self.settable.add(node.name)
                else:
                    own.setdefault(node.name, []).append(signature_of(node))
        self.methods |= own

    def check(self, method, args, kwargs):
        """Fail if no signature of a method takes the arguments."""
        assert method in self.methods or method == "__init__", f"{self.name} has no {method}"
        for signature in self.methods.get(method, [inspect.signature(lambda self: None)]):
            try:
                signature.bind(None, *args, **kwargs)
            except TypeError:
                continue
            return
        raise AssertionError(f"{self.name}.{method} does not take {args} {kwargs}")


def signature_of(node):
    """The signature of a function of a stub, without what it says of types."""
    for argument in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs):
        argument.annotation = None
    names = {}
    exec(f"def function({ast.unparse(node.args)}): ...", names)  # noqa: S102
    return inspect.signature(names["function"])


def stubs_of(library):
    """The stubs of a library's classes by their names."""
    found = importlib.util.find_spec(library)
    if found is None:
        pytest.skip(f"{library} is not installed: it has wheels for Linux on x86_64 only")
    text = (Path(found.submodule_search_locations[0]) / f"_{library}.pyi").read_text(encoding="utf-8")
    classes = {node.name: node for node in ast.parse(text).body if isinstance(node, ast.ClassDef)}
    return {name: Stub(name, classes) for name in classes}


class Checked:
    """An object that takes every call that the stub of its class allows, notes it, and answers what it is told to."""

    def __init__(self, stub, calls, answers):
        vars(self).update(stub=stub, calls=calls, answers=answers)

    def __getattr__(self, name):
        if name in self.stub.readable:
            return self.answers[name]

        def call(*args, **kwargs):
            self.stub.check(name, args, kwargs)
            self.calls.append((name, args, kwargs))
            answer = self.answers.get(name)
            return answer() if callable(answer) else answer

        return call

    def __setattr__(self, name, value):
        assert name in self.stub.settable, f"{self.stub.name}.{name} cannot be set"
        vars(self)[name] = value


def stand_in(stubs, name, calls, answers):
    """A module of that name whose classes make `Checked` objects, if the stubs allow it."""

    def make(stub, *args, **kwargs):
        stub.check("__init__", args, kwargs)
        calls.append((stub.name, args, kwargs))
        return Checked(stub, calls, answers)

    module = types.ModuleType(name)
    vars(module).update({each: partial(make, stub) for each, stub in stubs.items()})
    return module


def adapter(library, module, monkeypatch):
    monkeypatch.setitem(sys.modules, library, module)
    path = ROBOTS / f"{library}_robot.py"
    spec = importlib.util.spec_from_file_location(path.stem, path)
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


@pytest.fixture(scope="module")
def panda():
    return example_arm("panda")


def law_of(panda):
    return controllers.create("damped-null-space", panda)


@pytest.fixture
def pylibfranka(monkeypatch):
    stubs, calls, answers, ticks = stubs_of("pylibfranka"), [], {}, count()

    def state():
        time = Checked(stubs["Duration"], [], {"to_sec": next(ticks) * 1e-3})
        return Checked(stubs["RobotState"], [], {"q": READY.tolist(), "dq": [0.0] * 7, "time": time})

    module = stand_in(stubs, "pylibfranka", calls, answers)
    module.RealtimeConfig = Checked(stubs["RealtimeConfig"], [], {"kEnforce": "enforce", "kIgnore": "ignore"})
    answers |= {
        "read_once": state,
        "readOnce": lambda: (state(), None),
        "start_torque_control": lambda: Checked(stubs["ActiveControlBase"], calls, answers),
    }
    return adapter("pylibfranka", module, monkeypatch), calls


def test_pylibfranka_is_driven_by_its_own_signatures(panda, pylibfranka):
    module, calls = pylibfranka
    robot = module.PylibfrankaRobot(panda, "172.16.0.2")
    assert isinstance(robot, ClockedRobot)
    run = RealTimeLoop(robot, law_of(panda)).hold(0.02)
    assert run.status == "finished", run.message
    names = [name for name, *_ in calls]
    assert names[0] == "Robot"
    assert names.index("start_torque_control") < names.index("writeOnce")
    assert names[-1] == "writeOnce"
    last = calls[-1][1][0]
    assert last.motion_finished is True
    assert sum(name == "start_torque_control" for name in names) == 1
    # Every command comes after a reading of its own.
    control = [name for name in names if name in {"readOnce", "writeOnce"}]
    assert control[:4] == ["readOnce", "writeOnce", "readOnce", "writeOnce"]
    # A law that holds an arm at rest asks for its gravity, which the robot adds by itself.
    sent = [args[0] for name, args, _ in calls if name == "Torques"]
    assert np.abs(sent).max() < 1e-9
    assert np.abs(run.tau).max() > 1.0


def test_pylibfranka_asks_for_a_real_time_kernel_unless_told_not_to(panda, pylibfranka):
    module, calls = pylibfranka
    module.PylibfrankaRobot(panda, "172.16.0.2")
    module.PylibfrankaRobot(panda, "172.16.0.2", enforce_realtime=False)
    assert [args for name, args, _ in calls if name == "Robot"] == [
        ("172.16.0.2", "enforce"),
        ("172.16.0.2", "ignore"),
    ]


@pytest.fixture
def franky(monkeypatch):
    stubs, calls, answers = stubs_of("franky"), [], {"is_in_control": True}
    module = stand_in(stubs, "franky", calls, answers)
    module.Robot = module._RobotInternal  # its base, which has all but the web interface
    answers["state"] = Checked(stubs["RobotState"], [], {"q": READY, "dq": np.zeros(7)})
    return adapter("franky", module, monkeypatch), calls, answers


def test_franky_is_driven_by_its_own_signatures(panda, franky):
    module, calls, _ = franky
    robot = module.FrankyRobot(panda, "172.16.0.2")
    assert isinstance(robot, Robot)
    assert not isinstance(robot, ClockedRobot)
    run = RealTimeLoop(robot, law_of(panda), dt=5e-3).hold(0.05)
    assert run.status == "finished", run.message
    names = [name for name, *_ in calls]
    assert names[:4] == ["_RobotInternal", "SimpleTorqueMotion", "move", "set_torque"]
    assert names[-3:] == ["TorqueStopMotion", "move", "join_motion"]
    assert set(names[4:-3]) == {"set_torque"}
    assert np.abs([args[0] for name, args, _ in calls if name == "set_torque"]).max() < 1e-9


def test_a_motion_that_franky_has_ended_ends_the_loop(panda, franky):
    module, _, answers = franky

    def watch(sample):
        answers["is_in_control"] = sample.t < 0.02

    run = RealTimeLoop(module.FrankyRobot(panda, "172.16.0.2"), law_of(panda), dt=5e-3, watch=watch).hold(1.0)
    assert isinstance(run.error, RobotError)
    assert "franky has ended the motion" in run.message


@pytest.mark.parametrize("file", sorted(ROBOTS.glob("*.py")), ids=lambda path: path.stem)
def test_every_adapter_says_first_that_it_has_not_run_on_a_robot(file):
    assert file.read_text(encoding="utf-8").splitlines()[0].startswith('"""This adapter has not run on a robot:')


# The two libraries register the same types and cannot be loaded by one process.
REAL = {
    "pylibfranka": """
import pylibfranka as library
torques = library.Torques([0.0] * 7)
torques.motion_finished = True
assert torques.motion_finished and torques.tau_J == [0.0] * 7
for cls, names in {library.Robot: ["read_once", "start_torque_control"], library.RobotState: ["q", "dq", "time"],
                   library.ActiveControlBase: ["readOnce", "writeOnce"], library.Duration: ["to_sec"]}.items():
    assert all(hasattr(cls, name) for name in names)
from pylibfranka_robot import PylibfrankaRobot as Adapter
connect = lambda arm: Adapter(arm, "127.0.0.1", enforce_realtime=False)
error = library.NetworkException
""",
    "franky": """
import franky as library
motion = library.SimpleTorqueMotion([1.0] * 7, signal_timeout=0.02)
motion.set_torque([2.0] * 7)
assert list(motion.get_torque()) == [2.0] * 7
library.TorqueStopMotion()
assert all(hasattr(library.RobotState, name) for name in ("q", "dq"))
assert all(hasattr(library.Robot, name) for name in ("state", "is_in_control", "move", "join_motion"))
from franky_robot import FrankyRobot as Adapter
connect = lambda arm: Adapter(arm, "127.0.0.1")
error = library.NetworkException
""",
}


@pytest.mark.parametrize("library", REAL)
def test_the_library_itself_has_what_the_adapter_uses_and_says_that_no_robot_is_there(library):
    stubs_of(library)
    code = f"""
import sys
sys.path.insert(0, {str(ROBOTS)!r})
{REAL[library]}
import aspect_control as ac
arm = ac.Arm.from_example("panda", frame="panda_hand_tcp", task="xyz")
try:
    connect(arm)
except error:
    print("no robot")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout == "no robot\n", done.stderr
