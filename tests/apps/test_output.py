from __future__ import annotations

import pytest

from ridedown.apps.output import check_folder, staged
from ridedown.errors import InvalidInput


def test_files_appear_only_when_the_block_has_succeeded(tmp_path):
    out = tmp_path / "new" / "results"
    with staged(out) as stage:
        (stage / "a.txt").write_text("a")
        (stage / "deep").mkdir()
        (stage / "deep" / "b.txt").write_text("b")
        assert not out.exists()
    assert (out / "a.txt").read_text() == "a"
    assert (out / "deep" / "b.txt").read_text() == "b"
    assert [path.name for path in tmp_path.iterdir()] == ["new"]


def test_a_failure_leaves_nothing(tmp_path):
    out = tmp_path / "results"

    def write_half():
        with staged(out) as stage:
            (stage / "a.txt").write_text("a")
            raise RuntimeError("half way")

    with pytest.raises(RuntimeError, match="half way"):
        write_half()
    assert list(tmp_path.iterdir()) == []


def test_other_files_stay_and_old_ones_are_replaced(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "a.txt").write_text("old")
    with staged(tmp_path) as stage:
        (stage / "a.txt").write_text("new")
    assert (tmp_path / "notes.txt").read_text() == "mine"
    assert (tmp_path / "a.txt").read_text() == "new"


@pytest.mark.parametrize("inside", ["", "folder"])
def test_a_file_is_no_folder(tmp_path, inside):
    taken = tmp_path / "taken"
    taken.write_text("mine")
    with pytest.raises(InvalidInput, match="is a file"):
        check_folder(taken / inside)
    assert taken.read_text() == "mine"
