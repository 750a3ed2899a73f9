import os
import signal
import socket
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from aspect_control.exceptions import OutputError
from aspect_control.files import atomic_path, output_folder, write_text


class Interrupted(Exception):
    pass


@pytest.fixture
def umask():
    before = os.umask(0o022)
    yield os.umask
    os.umask(before)


def listing(folder):
    return sorted(path.name for path in folder.iterdir())


def test_the_block_writes_the_file(tmp_path):
    with atomic_path(tmp_path / "run.npz") as temporary:
        temporary.write_bytes(b"new")
    assert (tmp_path / "run.npz").read_bytes() == b"new"


def test_an_existing_file_is_replaced(tmp_path):
    (tmp_path / "run.npz").write_bytes(b"a longer old file")
    with atomic_path(tmp_path / "run.npz") as temporary:
        temporary.write_bytes(b"new")
    assert (tmp_path / "run.npz").read_bytes() == b"new"


def test_nothing_is_seen_of_the_new_file_inside_the_block(tmp_path):
    (tmp_path / "run.npz").write_bytes(b"old")
    with atomic_path(tmp_path / "run.npz") as temporary:
        temporary.write_bytes(b"new")
        assert (tmp_path / "run.npz").read_bytes() == b"old"


def test_the_temporary_file_is_a_neighbour_of_the_same_suffix(tmp_path):
    with atomic_path(tmp_path / "figure.svg") as temporary:
        assert temporary.parent == tmp_path
        assert temporary.suffix == ".svg"


@pytest.mark.parametrize("error", [Interrupted, KeyboardInterrupt, ValueError])
def test_the_old_file_is_left_when_the_block_raises(tmp_path, error):
    (tmp_path / "run.npz").write_bytes(b"old")

    def interrupted():
        with atomic_path(tmp_path / "run.npz") as temporary:
            temporary.write_bytes(b"half")
            raise error

    with pytest.raises(error):
        interrupted()
    assert (tmp_path / "run.npz").read_bytes() == b"old"
    assert listing(tmp_path) == ["run.npz"]


def test_no_file_appears_when_the_block_raises(tmp_path):
    def interrupted():
        with atomic_path(tmp_path / "run.npz") as temporary:
            temporary.write_bytes(b"half")
            raise Interrupted

    with pytest.raises(Interrupted):
        interrupted()
    assert listing(tmp_path) == []


def test_a_full_disk_is_an_output_error_and_leaves_the_old_file(tmp_path):
    (tmp_path / "run.npz").write_bytes(b"old")

    def on_a_full_disk():
        with atomic_path(tmp_path / "run.npz"):
            raise OSError(28, "No space left on device")

    with pytest.raises(OutputError, match=r"run\.npz: No space left on device"):
        on_a_full_disk()
    assert (tmp_path / "run.npz").read_bytes() == b"old"
    assert listing(tmp_path) == ["run.npz"]


def test_no_temporary_file_is_left_when_the_block_ends_well(tmp_path):
    write_text(tmp_path / "report.md", "text")
    assert listing(tmp_path) == ["report.md"]


@pytest.mark.parametrize("mask", [0o022, 0o077, 0o002])
def test_the_mode_respects_the_umask(tmp_path, umask, mask):
    umask(mask)
    write_text(tmp_path / "report.md", "text")
    assert stat.S_IMODE((tmp_path / "report.md").stat().st_mode) == 0o666 & ~mask


def test_the_umask_is_put_back(tmp_path, umask):
    umask(0o027)
    write_text(tmp_path / "report.md", "text")
    assert umask(0o022) == 0o027


def test_a_missing_folder_is_an_output_error(tmp_path):
    with pytest.raises(OutputError, match="No such file or directory"):
        write_text(tmp_path / "missing" / "report.md", "text")
    assert listing(tmp_path) == []


def test_a_folder_in_the_way_is_an_output_error(tmp_path):
    (tmp_path / "report.md").mkdir()
    with pytest.raises(OutputError, match=r"report\.md"):
        write_text(tmp_path / "report.md", "text")
    assert listing(tmp_path) == ["report.md"]


def test_text_is_written_as_utf8(tmp_path):
    write_text(tmp_path / "report.md", "θ̇_H·θ̈_H")
    assert (tmp_path / "report.md").read_bytes() == "θ̇_H·θ̈_H".encode()


def test_a_folder_is_made_with_its_parents(tmp_path):
    folder = output_folder(tmp_path / "results" / "paper")
    assert folder == tmp_path / "results" / "paper"
    assert listing(folder) == []


def test_an_existing_folder_keeps_its_files(tmp_path):
    (tmp_path / "old.csv").write_text("old")
    assert output_folder(str(tmp_path)) == tmp_path
    assert listing(tmp_path) == ["old.csv"]


@pytest.mark.parametrize("folder", ["results", "results/paper"])
def test_a_file_in_the_way_is_an_output_error(tmp_path, folder):
    (tmp_path / "results").write_text("no folder")
    with pytest.raises(OutputError, match="results"):
        output_folder(tmp_path / folder)
    assert (tmp_path / "results").read_text() == "no folder"


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_without_permission_is_an_output_error(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(OutputError, match="Permission denied"):
        output_folder(tmp_path)


# What an atomic write must not replace


def device(folder):
    (folder / "out").symlink_to("/dev/full")


def fifo(folder):
    os.mkfifo(folder / "out")


def unix_socket(folder):
    server = socket.socket(socket.AF_UNIX)
    try:
        server.bind(str(folder / "out"))
    finally:
        server.close()


def read_only(folder):
    (folder / "out").write_bytes(b"to be kept")
    (folder / "out").chmod(0o444)


def read_only_by_a_link(folder):
    (folder / "kept").write_bytes(b"to be kept")
    (folder / "kept").chmod(0o400)
    (folder / "out").symlink_to("kept")


def directory(folder):
    (folder / "out").mkdir()


@pytest.mark.skipif(sys.platform == "win32", reason="files of POSIX")
@pytest.mark.parametrize("make", [device, fifo, unix_socket, read_only, read_only_by_a_link, directory])
def test_what_is_no_file_or_read_only_is_refused_before_anything_is_written(tmp_path, make):
    make(tmp_path)
    before, kind = listing(tmp_path), (tmp_path / "out").stat()
    with pytest.raises(OutputError, match=r"cannot write .*out: it is (no file that could be replaced|read-only)"):
        write_text(tmp_path / "out", "text")
    after = (tmp_path / "out").stat()
    assert (after.st_mode, after.st_ino, after.st_size) == (kind.st_mode, kind.st_ino, kind.st_size)
    assert listing(tmp_path) == before


def test_a_device_itself_is_refused():
    with pytest.raises(OutputError, match="cannot write /dev/null: it is no file"):
        write_text("/dev/null", "text")


def test_a_symbolic_link_is_followed_and_stays(tmp_path):
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "report.md").write_text("old")
    (tmp_path / "report.md").symlink_to("elsewhere/report.md")
    write_text(tmp_path / "report.md", "new")
    assert (tmp_path / "report.md").is_symlink()
    assert (tmp_path / "elsewhere" / "report.md").read_text() == "new"
    assert listing(tmp_path / "elsewhere") == ["report.md"]


def test_a_symbolic_link_to_nothing_makes_what_it_points_to(tmp_path):
    (tmp_path / "report.md").symlink_to("new.md")
    write_text(tmp_path / "report.md", "new")
    assert (tmp_path / "report.md").is_symlink()
    assert (tmp_path / "new.md").read_text() == "new"


def test_symbolic_links_in_a_circle_are_refused(tmp_path):
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    with pytest.raises(OutputError, match="cannot write"):
        write_text(tmp_path / "a", "text")
    assert listing(tmp_path) == ["a", "b"]


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o666, 0o755])
def test_the_permissions_of_an_existing_file_stay(tmp_path, umask, mode):
    (tmp_path / "report.md").write_text("old")
    (tmp_path / "report.md").chmod(mode)
    umask(0o077)
    write_text(tmp_path / "report.md", "new")
    assert stat.S_IMODE((tmp_path / "report.md").stat().st_mode) == mode
    assert (tmp_path / "report.md").read_bytes() == b"new"


def test_nobody_else_may_read_the_new_content_of_a_private_file_meanwhile(tmp_path, umask):
    umask(0o000)
    (tmp_path / "report.md").write_text("old")
    (tmp_path / "report.md").chmod(0o600)
    with atomic_path(tmp_path / "report.md") as temporary:
        assert stat.S_IMODE(temporary.stat().st_mode) == 0o600


def test_an_error_of_the_block_reaches_the_caller_unchanged(tmp_path):
    error = RuntimeError("of the block")

    def failing():
        with atomic_path(tmp_path / "run.npz"):
            raise error

    with pytest.raises(RuntimeError) as raised:
        failing()
    assert raised.value is error


def test_a_name_as_long_as_a_name_may_be_can_be_written(tmp_path):
    write_text(tmp_path / ("x" * 252 + ".md"), "text")
    assert listing(tmp_path) == ["x" * 252 + ".md"]


INTERRUPTED_ANYWHERE = """
import os, signal, sys
from aspect_control import files

calls = 0

def interrupt_at(frame, event, argument):
    # A line of `atomic_path` after another is the one at which Ctrl-C comes.
    global calls
    if frame.f_code.co_name != "atomic_path":
        return None
    if event == "line":
        calls += 1
        if calls == int(sys.argv[2]):
            sys.settrace(None)
            signal.raise_signal(signal.SIGINT)
    return interrupt_at

sys.settrace(interrupt_at)
try:
    files.write_text(sys.argv[1], "text")
except KeyboardInterrupt:
    print("interrupted")
else:
    print("written")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_an_interruption_at_any_line_leaves_no_temporary_file(tmp_path):
    outcomes = []
    while not outcomes or outcomes[-1] == "interrupted":
        command = [sys.executable, "-c", INTERRUPTED_ANYWHERE, str(tmp_path / "report.md"), str(len(outcomes) + 1)]
        reset = lambda: signal.signal(signal.SIGINT, signal.default_int_handler)  # noqa: E731
        done = subprocess.run(command, capture_output=True, text=True, check=True, preexec_fn=reset)
        outcomes.append(done.stdout.strip())
        assert not [path for path in Path(tmp_path).iterdir() if path.name != "report.md"], outcomes
    assert len(outcomes) > 8
    assert outcomes[-1] == "written"
