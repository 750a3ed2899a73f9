"""The benchmark: how it times, what it times, what it says of it, and what it is not to do."""

import gc
import json
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from aspect_control import controllers
from aspect_control.redundancy import kernels_compiled
from benchmark import EveryTick, arms, machine, verdicts
from benchmark.closed_loop import closed_loop
from benchmark.figure import benchmark_figure
from benchmark.report import benchmark_report
from benchmark.rivals import rivals
from benchmark.ticks import every_tick_of_a_motion, ticks
from benchmark.timing import COMPILED, NUMPY, Motion, Row, every_tick, interleaved
from oracles import literal

PROGRAM = Path(__file__).parents[2] / "benchmarks" / "pseudoinverse_cost.py"


class Clock:
    """A clock that only the calls move: 0.1 ms each, but ten times that for the first two after another call's turn."""

    def __init__(self, monkeypatch):
        self.now, self.last, self.cold = 0.0, "", 0
        monkeypatch.setattr("benchmark.timing.time.perf_counter", lambda: self.now)

    def call(self, name):
        self.cold = 2 if name != self.last else max(self.cold - 1, 0)
        self.now, self.last = self.now + (1e-3 if self.cold else 1e-4), name


@pytest.fixture
def clock(monkeypatch):
    return Clock(monkeypatch)


# How it times


def test_a_call_is_timed_when_it_has_been_called_before(clock):
    calls = {"one": 0, "other": 0}

    def call(name):
        clock.call(name)
        calls[name] += 1

    seconds = interleaved({name: lambda name=name: call(name) for name in calls}, 7)
    for name, times in seconds.items():
        np.testing.assert_allclose(times, np.full(7, 1e-4), rtol=1e-6)
        # Ten timed and three before in every round, besides those that tell how many.
        assert 7 * 13 <= calls[name] <= 7 * 13 + 40
    # A call that returns seconds is taken at its word.
    np.testing.assert_array_equal(interleaved({"measured": lambda: 2.0}, 4)["measured"], np.full(4, 2.0))


def test_every_tick_of_a_motion_is_timed_in_order(clock):
    seen, samples = [], list(range(20))
    slow_at = {("law", 7): 5e-3, ("law", 19): 2e-3}

    def tick(name, sample):
        clock.call(name)
        clock.now += slow_at.get((name, sample), 0.0)
        seen.append((name, sample))
        if len(seen) == 1:
            assert not gc.isenabled()

    calls = {
        name: Motion(lambda sample, name=name: tick(name, sample), lambda name=name: seen.append((name, "begin")))
        for name in ("floor", "law")
    }
    floor, law = every_tick("a motion", calls, samples, least=90)
    assert gc.isenabled()
    assert (floor.name, law.name, law.group, len(law.seconds)) == ("floor", "law", "a motion", 100)
    # Begun, a quarter gone through untimed, begun again, and then all of it; the other call's turn in between.
    once = ["begin", *range(5), "begin", *samples]
    assert seen == [(name, each) for _ in range(5) for name in calls for each in once]
    np.testing.assert_allclose(floor.seconds, 1e-4, rtol=1e-6)
    np.testing.assert_allclose(floor.base, 1e-4, rtol=1e-6)
    assert law.ratio == pytest.approx(1.0)
    # Of 100 ticks 5 take 51 floors and 5 take 21.
    assert list(law.percentiles.values()) == pytest.approx([51.0, 51.0, 51.0])
    assert law.to_dict()["ticks"] == 100
    assert law.to_dict()["maximum"] == pytest.approx(51.0)


def test_the_unit_of_every_tick_is_the_median_floor_of_its_pass(clock):
    slower = iter([1.0] * 13 + [3.0] * 13)

    def floor(sample):
        clock.now += next(slower) * (9e-4 if sample == 5 else 1e-4)

    def law(sample):
        clock.now += 2e-4

    rows = every_tick("a motion", {"floor": Motion(floor), "law": Motion(law)}, list(range(10)), least=20)
    np.testing.assert_allclose(rows[1].base, np.repeat([1e-4, 3e-4], 10), rtol=1e-6)
    assert rows[0].percentiles["maximum"] == pytest.approx(9.0)


def test_an_interrupted_timing_leaves_the_garbage_collector_as_it_was():
    def tick(sample):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        every_tick("a motion", {"floor": Motion(tick)}, [1], least=1)
    assert gc.isenabled()
    assert gc.get_freeze_count() == 0


# What it times


def test_a_row_a_law():
    rows = ticks("Panda, xyz", arms.panda(), 3, with_literal=True)
    names = {"floor", "resolved-motion", *literal.LAWS}
    assert {row.name for row in rows} == names | {f"{law}, literal" for law in literal.LAWS}
    assert all(np.isfinite(row.seconds).all() and (row.seconds > 0.0).all() for row in rows)
    assert {row.name for row in ticks("Panda, xyz", arms.panda(), 3, with_literal=False)} == names


def test_every_tick_of_every_law():
    rows = every_tick_of_a_motion(arms.panda(), 300)
    assert [row.name for row in rows] == ["floor", *controllers.available()]
    assert {len(row.seconds) for row in rows} == {2 * 251}
    assert all(row.ratio <= row.percentiles["99th percentile"] <= row.percentiles["maximum"] for row in rows)


def test_the_motion_is_a_line_at_1_khz():
    arm = arms.panda()
    samples = arms.motion(arm)
    assert len(samples) == 251
    x = np.array([arm.task_position(each.q) for each in samples])
    np.testing.assert_allclose(x[-1] - x[0], [0.1, 0.1, 0.1], rtol=0, atol=1e-3)
    np.testing.assert_allclose(samples[7].state.J @ samples[7].v, samples[7].state.dx, rtol=0, atol=1e-15)


def test_a_sample_of_a_run_is_held_against_its_parts():
    rows = {(row.group, row.name): row for row in closed_loop(arms.panda(), 3)}
    names = {name for _, name in rows}
    assert names >= {"a sample of the run", "tick", "four ABA calls", "target", "floor"}
    tick, aba = (rows["Panda, xyz: closed loop, jmdc", each] for each in ("tick", "four ABA calls"))
    np.testing.assert_allclose(tick.base, tick.seconds + aba.seconds)


def test_rivals_time_the_laws_that_are_asked_for():
    if find_spec("placo") is not None:
        pytest.skip("PlaCo is installed")
    rows = rivals(arms.panda(), 3, None, laws=("pseudoinverse",), with_pink=False)
    assert [(row.name, row.of) for row in rows] == [("floor", "floor"), ("pseudoinverse", "floor")]


# What it says


def row(group, name, ratio, kind=Row, of="floor"):
    return kind(group, name, ratio * np.ones(5), np.ones(5), of)


def test_verdicts_hold_rows_against_the_targets_of_their_mode():
    rows = [
        *(row(f"Panda, xyz: tick, {mode}", "floor", 1.0) for mode in (NUMPY, COMPILED)),
        *(row(f"Panda, xyz: tick, {mode}", law, 3.0) for mode in (NUMPY, COMPILED) for law in literal.LAWS),
        row(f"Panda, xyz: qp, held, {NUMPY}", "osqp", 9.0, EveryTick),
        row(f"Panda, xyz: qp, held, {NUMPY}", "daqp", 9.0, EveryTick),
        row(f"Panda, xyz: closed loop, jmdc, {COMPILED}", "a sample of the run", 1.7),
    ]
    met = {each.target: each.met for each in verdicts(rows) if each.met is not None}
    assert met == {
        **{f"tick of {law}, NumPy ≤ 9 × floor": True for law in literal.LAWS if law != "jmdc"},
        "tick of jmdc, NumPy ≤ 20 × floor": True,
        **{f"tick of {law}, compiled ≤ 2.5 × floor": False for law in literal.LAWS if law != "jmdc"},
        "tick of jmdc, compiled ≤ 3.5 × floor": True,
        "qp, held, NumPy: osqp, median ≤ 10 × floor": True,
        "qp, held, NumPy: osqp, 99.9th percentile ≤ 40 × floor": True,
        "qp, held, NumPy: daqp, median ≤ 6 × floor": False,
        "qp, held, NumPy: daqp, 99.9th percentile ≤ 15 × floor": True,
        "sample of a run of jmdc, compiled ≤ 1.6 × (tick + four ABA)": False,
    }


def test_nothing_measured_is_neither_met_nor_missed():
    assert all(each.met is None for each in verdicts([]))


def test_the_figure_shows_what_was_measured():
    numpys = [row(f"Panda, xyz: tick, {NUMPY}", name, 2.0) for name in ("floor", "jmdc", "jmdc, literal")]
    (ticks_alone,) = benchmark_figure(numpys).axes
    assert len(ticks_alone.patches) == 2
    compiled = [row(each.group.replace(NUMPY, COMPILED), each.name, 1.0) for each in numpys[:2]]
    grown = [row(f"{arm}: J⁺, {COMPILED}", "numpy pinv", 1.0) for arm in ("Panda, xyz", "chain of 30, xyz")]
    both, growth = benchmark_figure([*numpys, *compiled, *grown]).axes
    assert len(both.patches) == 3
    assert [len(line.get_xdata()) for line in growth.lines][:2] == [2, 0]


def test_the_report_has_a_table_of_every_tick():
    rows = [row("tick, NumPy", "floor", 1.0), row("every tick of a motion, NumPy", "jmdc", 4.0, EveryTick)]
    text = benchmark_report(rows, verdicts(rows), ["placo"], machine())
    assert "Not installed: placo." in text
    assert (
        "| every tick | | median | 99th percentile | 99.9th percentile | maximum | ticks |".replace("| |", "|  |")
        in text
    )
    assert "| every tick of a motion, NumPy | jmdc | 4.00 | 4.00 | 4.00 | 4.00 | 5 |" in text
    assert text.count("jmdc | 4.00") == 1


def test_versions_are_those_of_what_is_installed():
    versions = machine()["versions"]
    assert ("numba" in versions) == (find_spec("numba") is not None)
    assert {"aspect-control", "numpy", "pin"} <= set(versions)


def test_the_program_tells_at_once_that_a_python_has_no_placo(tmp_path):
    for python in ("/nowhere/python", *([] if find_spec("placo") else [sys.executable])):
        arguments = ["--out", str(tmp_path), "--rounds", "3", "--placo-python", python]
        result = subprocess.run([sys.executable, PROGRAM, *arguments], capture_output=True, text=True)
        assert result.returncode == 2
        assert "must be a Python that has PlaCo, got" in result.stderr
        assert "Traceback" not in result.stderr


def test_this_process_is_not_compiled():
    # What is timed above is plain NumPy; only the program compiles, in its own process.
    assert not kernels_compiled()


@pytest.mark.parametrize("has_numba", [False, True], ids=["without Numba", "with Numba"])
def test_the_program_measures_what_is_installed(tmp_path, has_numba):
    if has_numba and find_spec("numba") is None:
        pytest.skip("needs Numba, the extra fast")
    hidden = "" if has_numba else "numba"
    # Few parts: the whole takes minutes.
    code = f"""
import importlib.util, sys
sys.path.insert(0, {str(PROGRAM.parent)!r})
import pseudoinverse_cost
import benchmark
find = importlib.util.find_spec
benchmark.find_spec = lambda name: None if name == {hidden!r} else find(name)
for name in ("programs", "pieces", "closed_loop", "guards", "many_minors", "startup"):
    setattr(benchmark, name, lambda *_, **__: [])
benchmark.arms_timed = lambda: {{}}
benchmark.TICKS_A_ROUND = 10
sys.argv = ["pseudoinverse_cost", "--rounds", "3", "--out", {str(tmp_path)!r}]
pseudoinverse_cost.main()
"""
    wide = {**os.environ, "COLUMNS": "250"}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=wide)
    assert done.returncode == 0, done.stderr
    document = json.loads((tmp_path / "bench.json").read_text())
    assert ("numba" in document["not_installed"]) != has_numba
    modes = {each["group"].rsplit(", ", 1)[-1] for each in document["rows"]}
    assert modes == ({NUMPY, COMPILED} if has_numba else {NUMPY})
    groups = {each["group"] for each in document["rows"]}
    for mode in modes:
        assert {f"Panda, xyz: tick, {mode}", f"Panda, xyz: every tick of a motion, {mode}"} <= groups
        assert f"Panda, xyz: rivals, {mode}" in groups
    assert (tmp_path / "bench.png").stat().st_size > 10_000
    assert "99.9th percentile" in (tmp_path / "bench.md").read_text()
    assert "99.9th percentile" in done.stdout
