"""The engine: the same table from any number of processes, resumed where it stopped, with nothing left behind."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from small_study import SMALL, processes_of, repeatable, run_command, start_command, study_file

import aspect_control as ac
from aspect_control.exceptions import (
    DamagedShardWarning,
    OutputError,
    ParameterError,
    StudyError,
    UnknownNameError,
    WorkerError,
)
from aspect_control.studies.shards import merge_folders, read_folder, study_of

posix = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks at the processes in /proc")
LONGER = SMALL.replace("random = 6", "random = 200").replace("[0.01]", "[0.002]")
"""800 runs of a twentieth of a second."""


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    return ac.Study.load(study_file(tmp_path_factory.mktemp("study")))


@pytest.fixture(scope="module")
def table(small):
    return small.run()


def shards_of(folder):
    return sorted((folder / "shards").glob("*.parquet"))


def test_two_processes_give_the_table_of_one(small, table, tmp_path):
    spread = small.run(tmp_path / "out", workers=2)
    assert table.num_rows == small.runs
    assert table.column("row").to_pylist() == list(range(small.runs))
    assert repeatable(spread).equals(repeatable(table))
    assert set(spread.column("kernels").to_pylist()) == set(table.column("kernels").to_pylist())
    assert not [field for field in table.schema if pa.types.is_nested(field.type) or pa.types.is_null(field.type)]


def test_a_run_made_again_is_that_of_its_row(small, table):
    for row in (0, 7, small.runs - 1):
        found = table.slice(row, 1).to_pylist()[0]
        metrics = small.record(*small.place(row)).metrics()
        assert {name: found[name] for name in metrics} == metrics


def test_what_is_there_is_not_run_again(small, table, tmp_path):
    small.run(tmp_path, shard="1/2")
    first = {path: path.stat().st_mtime_ns for path in shards_of(tmp_path)}
    assert 0 < len(first) < small.chunks
    progress = []
    again = small.run(tmp_path, progress=progress.append)
    assert {path: path.stat().st_mtime_ns for path in shards_of(tmp_path)}.items() >= first.items()
    assert (progress[0].done, progress[0].made) == (len(first) * small.chunk_size, 0)
    assert (progress[-1].done, progress[-1].made) == (small.runs, small.runs - progress[0].done)
    assert repeatable(again).equals(repeatable(table))
    progress.clear()
    small.run(tmp_path, progress=progress.append)
    assert progress == []
    small.run(tmp_path, resume=False)
    assert not {path.stat().st_mtime_ns for path in shards_of(tmp_path)} & set(first.values())


def test_made_anew_costs_neither_other_parts_nor_what_cannot_be_made_again(small, tmp_path, monkeypatch):
    small.run(tmp_path)
    first = {path: path.stat().st_mtime_ns for path in shards_of(tmp_path)}
    small.run(tmp_path, shard="2/4", resume=False)
    kept = {path: path.stat().st_mtime_ns for path in shards_of(tmp_path)}.items() & first.items()
    assert len(kept) == small.chunks - len(small.chunks_of("2/4"))

    def refused(self):
        raise ParameterError("a law that cannot be built")

    before = {path: path.stat().st_mtime_ns for path in shards_of(tmp_path)}
    monkeypatch.setattr(ac.Study, "require_buildable", refused)
    with pytest.raises(ParameterError):
        small.run(tmp_path, resume=False)
    assert {path: path.stat().st_mtime_ns for path in shards_of(tmp_path)} == before


def test_shards_of_a_queue_are_merged(small, table, tmp_path):
    for part in ("1/3", "3/3"):
        small.run(tmp_path / part[0], shard=part)
    folders = [tmp_path / "1", tmp_path / "3"]
    _, missing = merge_folders(folders, tmp_path / "two.parquet")
    assert missing == sum(len(small.rows_of(chunk)) for chunk in small.chunks_of("2/3"))
    small.run(tmp_path / "2", shard="2/3")
    merged, missing = merge_folders([*folders, tmp_path / "2", tmp_path / "1"], tmp_path / "all.parquet")
    assert missing == 0
    assert repeatable(merged).equals(repeatable(table))
    assert pq.read_table(tmp_path / "all.parquet").equals(merged)


def test_progress_tells_done_failed_rate_and_what_is_left(tmp_path):
    text = SMALL.replace("[0.01]", "[0.01, 50.0]")  # every run at a step of 50 s raises
    told = []
    study = ac.Study.load(study_file(tmp_path, text))
    table = study.run(progress=told.append)
    assert [each.done for each in told] == sorted(each.done for each in told)
    last = told[-1]
    assert (last.total, last.done, last.made, last.failed) == (48, 48, 48, 24)
    assert last.rate == pytest.approx(48 / last.seconds)
    assert (last.remaining, told[0].remaining) == (0.0, None)
    errors = table.filter(pa.compute.equal(table.column("status"), "error"))
    assert errors.num_rows == 24
    assert set(errors.column("peak_torque").to_pylist()) == {None}
    assert all("dt must not be longer" in message for message in errors.column("message").to_pylist())


def test_a_file_that_is_cut_short_is_made_again(small, table, tmp_path):
    small.run(tmp_path)
    victim = shards_of(tmp_path)[3]
    victim.write_bytes(victim.read_bytes()[:200])
    with pytest.raises(OutputError, match=rf"{victim.name} is cut short or no Parquet file"):
        read_folder(tmp_path)
    with pytest.raises(OutputError, match="is cut short"):
        merge_folders([tmp_path], tmp_path / "all.parquet")
    with pytest.warns(DamagedShardWarning, match=rf"{victim.name} is cut short .*; its runs are made again"):
        again = small.run(tmp_path)
    assert repeatable(again).equals(repeatable(table))


def test_a_changed_study_is_noticed(small, tmp_path):
    small.run(tmp_path / "out")
    before = {path: path.read_bytes() for path in shards_of(tmp_path / "out")}
    changed = ac.Study.load(study_file(tmp_path, SMALL.replace("seed = 3", "seed = 4")))
    with pytest.raises(StudyError, match=r"holds the study 'small' .*motions\.seed was 3 and is 4.*another folder"):
        changed.run(tmp_path / "out")
    assert {path: path.read_bytes() for path in shards_of(tmp_path / "out")} == before
    changed.run(tmp_path / "other", shard="1/24")
    with pytest.raises(StudyError, match=r"motions\.seed"):
        merge_folders([tmp_path / "out", tmp_path / "other"], tmp_path / "all.parquet")


def test_a_file_of_another_study_is_noticed(small, tmp_path):
    other = ac.Study.load(study_file(tmp_path, SMALL.replace("seed = 3", "seed = 4")))
    other.run(tmp_path / "other", shard="1/24")
    small.run(tmp_path / "out", shard="2/24")
    shards_of(tmp_path / "other")[0].rename(tmp_path / "out" / "shards" / "000000.parquet")
    with pytest.raises(StudyError, match=r"000000\.parquet belongs to another study \([0-9a-f]{8}\), the folder to"):
        small.run(tmp_path / "out")
    pq.write_table(pa.table({"status": ["finished"]}), tmp_path / "out" / "shards" / "000000.parquet")
    with pytest.raises(StudyError, match=r"000000\.parquet belongs to no study"):
        read_folder(tmp_path / "out")


def test_a_folder_knows_its_study(small, tmp_path):
    small.run(tmp_path, shard="1/24")
    again = study_of(tmp_path)
    assert (again.hash, again.name, again.runs) == (small.hash, small.name, small.runs)
    assert again.record(*again.place(3)) == small.record(*small.place(3))


@pytest.mark.parametrize("text", [None, "{}", "[1]", "{", '"x"'])
def test_a_folder_of_no_study_is_refused(text, tmp_path):
    if text is not None:
        (tmp_path / "study.json").write_text(text)
    with pytest.raises(StudyError, match=r"study\.json"):
        read_folder(tmp_path)


@pytest.mark.parametrize(
    ("how", "error", "words"),
    [
        ({"workers": 0}, ParameterError, "workers"),
        ({"workers": 10**6}, ParameterError, "workers"),
        ({"engine": "ray"}, UnknownNameError, "available: 'loky', 'dask'"),
        ({"engine": "dask"}, ParameterError, "a Dask cluster needs engine='dask' and scheduler='tcp://HOST:PORT'"),
        ({"scheduler": "tcp://127.0.0.1:1"}, ParameterError, "needs engine='dask'"),
        ({"out": "/dev/null"}, OutputError, "/dev/null"),
    ],
)
def test_bad_input_is_refused(small, how, error, words):
    with pytest.raises(error, match=words):
        small.run(**how)


def test_a_worker_that_dies_is_told_and_what_is_there_stays(tmp_path):
    study = ac.Study.load(study_file(tmp_path, LONGER))

    def kill_a_worker(progress):
        if progress.made:
            children = [int(each) for each in Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()]
            workers = [each for each in children if b"popen_loky" in read_command(each)]
            if workers:
                os.kill(workers[0], signal.SIGKILL)

    with pytest.raises(WorkerError, match="a worker process ended by itself"):
        study.run(tmp_path / "out", workers=2, progress=kill_a_worker)
    assert shards_of(tmp_path / "out")


def read_command(process):
    try:
        with open(f"/proc/{process}/cmdline", "rb") as file:  # noqa: PTH123
            return file.read()
    except OSError:
        return b""


# From the command line


@pytest.fixture
def started():
    """Starts a command; whatever a failed test leaves of it is ended."""
    commands = []

    def start(*arguments, **options):
        commands.append(start_command(*arguments, **options))
        return commands[-1]

    yield start
    for command in commands:
        for process in processes_of(command.pid):
            os.kill(process, signal.SIGKILL)
        command.communicate()


@posix
def test_kill_9_costs_the_chunks_under_way_and_leaves_no_worker(tmp_path, started):
    path, out = study_file(tmp_path, LONGER), tmp_path / "out"
    command = started("study", path, "--out", out, "--workers", 2, stderr=subprocess.DEVNULL)
    wait_for(lambda: len(shards_of(out)) >= 4)
    assert len(processes_of(command.pid)) >= 3
    command.kill()
    command.wait()
    wait_for(lambda: not processes_of(command.pid))
    assert not list(tmp_path.glob("out/shards/.*"))
    before = {path: path.stat().st_mtime_ns for path in shards_of(out)}
    rest = ac.Study.load(path).run(out, workers=2, shard="1/8")
    assert {path: path.stat().st_mtime_ns for path in shards_of(out)}.items() >= before.items()
    assert rest.num_rows >= 12 * len(before)


@posix
def test_ctrl_c_ends_with_what_there_is(tmp_path, started):
    path, out = study_file(tmp_path, LONGER), tmp_path / "out"
    command = started("study", path, "--out", out, "--workers", 2, stderr=subprocess.PIPE)
    wait_for(lambda: len(shards_of(out)) >= 4)
    os.killpg(command.pid, signal.SIGINT)
    _, words = command.communicate(timeout=60)
    assert command.returncode == 130
    assert words.splitlines()[-1] == "aspect-control: interrupted; what was written stays"
    assert "Traceback" not in words
    wait_for(lambda: not processes_of(command.pid))
    assert 0 < read_folder(out).num_rows < 800


@posix
def test_a_disk_that_fills_costs_nothing_that_is_there(tmp_path):
    path = study_file(tmp_path)
    whole = ac.Study.load(path).run(tmp_path / "whole")
    size = max(shard.stat().st_size for shard in shards_of(tmp_path / "whole"))
    script = (
        "import resource, signal, sys; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "from aspect_control import Study\n"
        f"study = Study.load({str(path)!r})\n"
        "def full(progress):\n"
        "    if progress.made > 3: resource.setrlimit(resource.RLIMIT_FSIZE, "
        f"({size // 2}, {size // 2}))\n"
        "from aspect_control.exceptions import OutputError\n"
        "try:\n"
        f"    study.run({str(tmp_path / 'out')!r}, progress=full)\n"
        "except OutputError as error:\n"
        "    sys.exit(str(error))\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "cannot write" in done.stderr.splitlines()[-1]
    assert "File too large" in done.stderr
    kept = read_folder(tmp_path / "out")
    assert 0 < kept.num_rows < 24
    assert repeatable(kept).equals(repeatable(whole).take(kept.column("row")))
    assert not list((tmp_path / "out" / "shards").glob(".*"))


def test_the_command_runs_merges_and_records(tmp_path):
    path = study_file(tmp_path)
    done = run_command("study", path, "--workers", 2, cwd=tmp_path)
    assert (done.returncode, done.stdout.splitlines()[-1][:27]) == (0, "24 of 24 runs are in result"), done.stderr
    assert done.stderr.startswith("24 runs: 1 scenario, 2 grid points, 6 motions, 2 laws; at most ")
    folder = tmp_path / "results" / "studies" / "small"
    done = run_command("study", "merge", folder, "--out", tmp_path / "all.parquet")
    assert done.returncode == 0
    import hashlib

    digest = hashlib.sha256((tmp_path / "all.parquet").read_bytes()).hexdigest()
    assert done.stdout == f"24 runs written to {tmp_path / 'all.parquet'}, SHA-256 {digest}\n"
    done = run_command("study", "record", folder, 5, 0)
    assert done.returncode == 0, done.stderr
    names = sorted(each.name for each in (folder / "recordings").iterdir())
    assert names == ["000000-planar3r-null-space-vector.npz", "000005-planar3r-jmdc.npz"]
    run = ac.Run.load(folder / "recordings" / names[1])
    assert run.metrics()["peak_torque"] == read_folder(folder).column("peak_torque")[5].as_py()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["no-such.toml"], "cannot read study no-such.toml"),
        (["run", "FILE", "--shard", "9/8"], "shard must be i/n"),
        (["FILE", "--engine", "slurm"], "unknown engine 'slurm'"),
        (["merge", "FOLDER", "--out", "x.parquet"], "is no folder of a study"),
        (["record", "FOLDER", "0"], "is no folder of a study"),
        (["HUGE"], "a study of 40,000,000 runs takes about"),
    ],
)
def test_bad_input_on_the_command_line_is_one_line(arguments, words, tmp_path):
    huge = SMALL.replace("random = 6", "random = 10_000_000")
    given = {"FILE": study_file(tmp_path), "HUGE": study_file(tmp_path, huge, "huge"), "FOLDER": tmp_path}
    done = run_command("study", *(given.get(each, each) for each in arguments), cwd=tmp_path)
    assert done.returncode == 2
    assert words in done.stderr.splitlines()[-1]
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.glob("results/studies/*/shards/*"))


def wait_for(condition, seconds=300.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.05)
