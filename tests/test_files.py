import os
import stat

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
