"""A real Dask cluster: a scheduler and two workers as processes on loopback, one of them killed in the middle."""

import socket
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import pytest
from small_study import SMALL, repeatable, run_command, study_file

import aspect_control as ac
from aspect_control.exceptions import WorkerError
from aspect_control.studies.rows import make_row, to_table
from aspect_control.studies.shards import read_folder

DASK = str(Path(sys.executable).with_name("dask"))
TEXT = SMALL.replace("random = 6", "random = 60").replace("[0.01]", "[0.004]")
"""240 runs of some hundredths of a second."""


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextmanager
def cluster(folder, workers):
    """A scheduler and workers on loopback; yields its address and their processes, the scheduler's first."""
    port, quiet = free_port(), {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    address = f"tcp://127.0.0.1:{port}"
    common = ["--host", "127.0.0.1", "--no-dashboard"]
    processes = [subprocess.Popen([DASK, "scheduler", *common, "--port", str(port)], **quiet)]
    try:
        for index in range(workers):
            own = ["--nthreads", "1", "--no-nanny", "--local-directory", str(folder / f"worker{index}")]
            processes.append(subprocess.Popen([DASK, "worker", address, *common, *own], **quiet))
        wait_until_listening(port)
        yield address, processes
    finally:
        for process in processes:
            process.kill()
        for process in processes:
            process.wait()


def wait_until_listening(port):
    end = time.monotonic() + 60.0
    while time.monotonic() < end:
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.1)
    pytest.fail("the scheduler does not answer")


def test_a_cluster_that_loses_a_worker_gives_the_table_of_one_process(tmp_path):
    study, killed = ac.Study.load(study_file(tmp_path, TEXT)), []
    with cluster(tmp_path, 2) as (address, (_, worker, _)):

        def kill_a_worker(progress):
            if progress.made > study.runs // 4 and not killed:
                worker.kill()
                killed.append(progress.made)

        spread = study.run(tmp_path / "out", engine="dask", scheduler=address, progress=kill_a_worker)
    assert killed
    assert killed[0] < study.runs
    assert repeatable(spread).equals(repeatable(study.run()))


def test_a_scheduler_that_dies_is_told_and_what_it_had_stays(tmp_path):
    study = ac.Study.load(study_file(tmp_path, TEXT.replace("random = 60", "random = 1000")))
    with cluster(tmp_path, 1) as (address, (scheduler, _)):

        def kill_the_scheduler(progress):
            if progress.made:
                scheduler.kill()

        with pytest.raises(WorkerError, match=f"the cluster at {address} is gone, what it had computed stays"):
            study.run(tmp_path / "out", engine="dask", scheduler=address, progress=kill_the_scheduler)
    there = read_folder(tmp_path / "out")
    assert 0 < there.num_rows < study.runs
    again = to_table(study, [make_row(study, row) for row in there.column("row").to_pylist()[:8]])
    assert repeatable(again).equals(repeatable(there.slice(0, 8)))


def test_a_scheduler_that_is_not_there_is_one_line(tmp_path):
    address = f"tcp://127.0.0.1:{free_port()}"
    done = run_command("study", study_file(tmp_path), "--engine", "dask", "--scheduler", address, cwd=tmp_path)
    assert done.returncode == 2
    last = done.stderr.splitlines()[-1]
    assert last.startswith(f"aspect-control: error: no scheduler of a Dask cluster answers at {address}")
    assert "Traceback" not in done.stderr
