"""A test's files are read in any letter case and encoding, within bounds, and never from outside its folder or zip."""

from __future__ import annotations

import io
import os
import struct
import zipfile
import zlib
from pathlib import Path

import pytest

from ridedown.errors import InvalidInput, UnknownName
from ridedown.signals import files
from ridedown.signals.files import decoded, open_tree


def packed(path: Path, members: dict[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> Path:
    with zipfile.ZipFile(path, "w", method) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return path


@pytest.fixture(params=["folder", "stored", "deflated"])
def tree_of(request, tmp_path):
    """Makes a tree of files: a folder, or a zip of either kind."""

    def make(members: dict[str, bytes]) -> files.Tree:
        if request.param != "folder":
            method = zipfile.ZIP_STORED if request.param == "stored" else zipfile.ZIP_DEFLATED
            return open_tree(packed(tmp_path / "test.zip", members, method))
        for name, content in members.items():
            (tmp_path / "test" / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / "test" / name).write_bytes(content)
        return open_tree(tmp_path / "test")

    return make


def test_names_are_sorted_have_forward_slashes_and_match_in_any_letter_case(tree_of):
    tree = tree_of({"T1/Channel/t1.001": b"1", "T1/T1.MME": b"2", "T1/Channel/t1.CHN": b"3"})
    assert tree.names() == ("T1/Channel/t1.001", "T1/Channel/t1.CHN", "T1/T1.MME")
    assert tree.find(".chn") == ("T1/Channel/t1.CHN",)
    assert tree.read_bytes("t1/t1.mme") == b"2"
    assert tree.read_bytes("T1\\CHANNEL\\T1.001") == b"1"
    assert tree.read_bytes("./T1/T1.MME") == b"2"
    assert "t1/CHANNEL/t1.chn" in tree
    assert "t1/other" not in tree


def test_two_files_that_differ_in_letter_case_only_need_their_own(tree_of):
    tree = tree_of({"a.EV5": b"1", "A.ev5": b"2"})
    assert (tree.read_bytes("a.EV5"), tree.read_bytes("A.ev5")) == (b"1", b"2")
    with pytest.raises(InvalidInput, match=r"got 2 files, A.ev5 and a.EV5; need one"):
        tree.read_bytes("a.ev5")


def test_a_name_that_is_not_there_is_answered_with_the_nearest(tree_of):
    with pytest.raises(UnknownName, match=r"no 'v1.02'. Did you mean 'v1.002'"):
        tree_of({"v1.002": b"", "other": b""}).read_bytes("v1.02")


@pytest.mark.parametrize("name", ["../secret", "a/../../secret", "/etc/passwd", "..\\secret", "C:\\secret", "", "\0"])
def test_no_name_leads_out_of_the_tree(tree_of, tmp_path, name):
    (tmp_path / "secret").write_bytes(b"secret")
    tree = tree_of({"a/b": b"1"})
    assert name not in tree
    with pytest.raises(InvalidInput, match="a name that leads out of the folder is not read"):
        tree.read_bytes(name)


@pytest.mark.parametrize("name", ["../secret", "a/../../secret", "/etc/passwd", "..\\secret", "C:/secret"])
def test_members_of_a_zip_that_lead_out_of_it_are_left_out_and_nothing_is_written(tmp_path, name):
    (tmp_path / "in").mkdir()
    path = packed(tmp_path / "in" / "t.zip", {name: b"x", "good": b"1"})
    tree = open_tree(path)
    assert tree.names() == ("good",)
    with pytest.raises(InvalidInput, match="leads out of the folder"):
        tree.read_bytes(name)
    assert sorted(item.name for item in tmp_path.rglob("*")) == ["in", "t.zip"]


def test_links_are_followed_within_the_folder_only(tmp_path):
    (tmp_path / "secret").write_bytes(b"secret")
    root = tmp_path / "test"
    root.mkdir()
    (root / "real").write_bytes(b"1")
    (root / "inner").symlink_to("real")
    (root / "outer").symlink_to(tmp_path / "secret")
    (root / "folder").symlink_to(tmp_path, target_is_directory=True)
    (root / "loop").symlink_to("loop")
    (root / "nowhere").symlink_to("missing")
    tree = open_tree(root)
    assert tree.names() == ("inner", "real")
    assert tree.read_bytes("inner") == b"1"
    for name in ("outer", "folder", "loop", "nowhere"):
        with pytest.raises(InvalidInput, match=f"^{name}: a link that leads"):
            tree.read_bytes(name)


def test_a_folder_that_is_itself_a_link_is_read(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "a").write_bytes(b"1")
    (tmp_path / "link").symlink_to("real", target_is_directory=True)
    assert open_tree(tmp_path / "link").read_bytes("a") == b"1"


def test_pipes_are_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InvalidInput, match=r"^pipe: not a plain file"):
        open_tree(tmp_path).read_bytes("pipe")


def test_a_file_stands_for_the_folder_around_it(tmp_path):
    (tmp_path / "v1.EV5").write_bytes(b"header")
    (tmp_path / "v1.001").write_bytes(b"curve")
    assert open_tree(tmp_path / "v1.EV5").names() == ("v1.001", "v1.EV5")


def test_what_is_not_there_is_refused(tmp_path):
    with pytest.raises(InvalidInput, match=r"which does not exist; need a folder, a zip or a file"):
        open_tree(tmp_path / "missing")


# bounds


def test_files_beyond_the_limit_are_refused_before_and_while_they_are_read(tree_of, monkeypatch):
    monkeypatch.setattr(files, "MAX_FILE_BYTES", 100)
    tree = tree_of({"small": b"x" * 100, "large": b"x" * 101})
    assert tree.names() == ("small",)
    assert len(tree.read_bytes("small")) == 100
    with pytest.raises(InvalidInput, match=r"^large: it has 101 bytes; need at most 100"):
        tree.read_bytes("large")


def test_a_file_that_has_grown_since_is_read_no_further_than_the_limit(tmp_path, monkeypatch):
    (tmp_path / "a").write_bytes(b"1")
    tree = open_tree(tmp_path)
    monkeypatch.setattr(files, "MAX_FILE_BYTES", 100)
    (tmp_path / "a").write_bytes(b"x" * 5000)
    with pytest.raises(InvalidInput, match="need at most 100"):
        tree.read_bytes("a")


def test_more_files_than_a_test_has_are_refused(tree_of, monkeypatch):
    monkeypatch.setattr(files, "MAX_FILES", 5)
    assert len(tree_of({f"{i}": b"" for i in range(5)}).names()) == 5
    with pytest.raises(InvalidInput, match="with more than 5 files; need one test"):
        tree_of({f"{i}": b"" for i in range(7)})


def test_folders_deeper_than_a_test_are_not_walked(tmp_path):
    deep = tmp_path.joinpath(*"abcdefgh")
    deep.mkdir(parents=True)
    (deep / "file").write_bytes(b"")
    (tmp_path / "a" / "file").write_bytes(b"")
    assert open_tree(tmp_path).names() == ("a/file",)


def test_a_bomb_is_refused_for_its_declared_size(tmp_path):
    path = packed(tmp_path / "bomb.zip", {"bomb": b"\0" * (files.MAX_FILE_BYTES + 1)})
    assert path.stat().st_size < 100_000
    with pytest.raises(InvalidInput, match=r"^bomb: it has 67108865 bytes; need at most 67108864"):
        open_tree(path).read_bytes("bomb")


def test_a_zip_whose_members_are_too_much_together_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "MAX_TOTAL_BYTES", 1000)
    path = packed(tmp_path / "many.zip", {f"{i}": b"\0" * 300 for i in range(4)})
    with pytest.raises(InvalidInput, match="GiB unpacked; need one test"):
        open_tree(path)


def zip_of_one(name: bytes, packed_bytes: bytes, *, size: int, crc: int, method: int = 8, flags: int = 0) -> bytes:
    """A zip with one member, each field as given: lies and all (APPNOTE.TXT, PKWARE, 4.3)."""
    about = struct.pack("<HHHHHIIIHH", 20, flags, method, 0, 33, crc, len(packed_bytes), size, len(name), 0)
    local = b"PK\x03\x04" + about + name + packed_bytes
    central = b"PK\x01\x02" + struct.pack("<H", 20) + about + struct.pack("<HHHII", 0, 0, 0, 0, 0) + name
    return local + central + b"PK\x05\x06" + struct.pack("<HHHHIIH", 0, 0, 1, 1, len(central), len(local), 0)


def deflated(content: bytes) -> bytes:
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    return packer.compress(content) + packer.flush()


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"size": 10, "crc": zlib.crc32(b"\0" * 10)}, "11 bytes or more where the list says 10"),
        ({"size": 5000, "crc": 0}, "4096 bytes or more where the list says 5000"),
        ({"size": 4096, "crc": 1}, "its checksum is another one"),
        ({"size": 4096, "crc": 0, "flags": 1}, "it is encrypted"),
        ({"size": 4096, "crc": 0, "method": 14}, "it is packed in a way that is not read"),
    ],
)
def test_a_member_that_lies_is_refused_and_unpacked_no_further_than_it_declares(tmp_path, fields, message):
    path = tmp_path / "lies.zip"
    path.write_bytes(zip_of_one(b"a", deflated(b"\0" * 4096), **fields))
    with pytest.raises(InvalidInput, match=message):
        open_tree(path).read_bytes("a")


def test_the_hand_made_zip_of_these_tests_is_a_good_one_when_it_tells_the_truth(tmp_path):
    path = tmp_path / "true.zip"
    path.write_bytes(zip_of_one(b"a", deflated(b"\0" * 4096), size=4096, crc=zlib.crc32(b"\0" * 4096)))
    assert open_tree(path).read_bytes("a") == b"\0" * 4096


def test_a_list_of_members_larger_than_any_test_has_is_not_read_into_memory(tmp_path):
    honest = zip_of_one(b"a", b"", size=0, crc=0, method=0)
    path = tmp_path / "list.zip"
    end = bytearray(honest[-22:])
    size = files.MAX_DIRECTORY_BYTES + 1
    end[12:16] = struct.pack("<I", size)
    end[16:20] = struct.pack("<I", 4)
    path.write_bytes(b"PK\x03\x04" + b"\0" * size + bytes(end))
    with pytest.raises(InvalidInput, match="with more than 20000 files"):
        open_tree(path)


def test_a_name_that_a_zip_has_twice_is_read_neither_way(tmp_path):
    path = tmp_path / "twice.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a", b"1")
        with pytest.warns(UserWarning, match="Duplicate"):
            archive.writestr("a", b"2")
    with pytest.raises(InvalidInput, match=r"^a: it is in the zip twice"):
        open_tree(path).read_bytes("a")


@pytest.mark.parametrize("keep", [4, 30, 60, -30, -1])
def test_a_zip_cut_short_is_refused(tmp_path, keep):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr("a", b"x" * 100)
    path = tmp_path / "short.zip"
    path.write_bytes(buffer.getvalue()[:keep])
    with pytest.raises(InvalidInput, match=r"^short\.zip: got a damaged zip .*; need a whole one"):
        open_tree(path)


# text


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ("Größe 37 °C".encode(), "Größe 37 °C"),
        (b"\xef\xbb\xbf" + "Größe".encode(), "Größe"),
        ("Größe 37 °C – x".encode("cp1252"), "Größe 37 °C – x"),
        (b"Gr\xf6\xdfe \x81", "Größe \x81"),  # 0x81 is nothing in cp1252: Latin-1
        (b"a\r\nb\rc\nd\r\n", "a\nb\nc\nd\n"),
        (b"a\x0cb\x0bc", "a\x0cb\x0bc"),
        (b"", ""),
    ],
)
def test_text_is_read_in_the_encodings_met_and_with_any_line_end(tree_of, content, text):
    assert tree_of({"t": content}).read_text("t") == text


def test_what_is_not_text_is_refused_with_the_line():
    with pytest.raises(InvalidInput, match=r"^v1\.EV5:3: got binary data; need text"):
        decoded(b"one\ntwo\n\x00\x01", "v1.EV5")


def test_names_in_messages_are_printable_and_short(tree_of):
    with pytest.raises(UnknownName) as problem:
        tree_of({"a": b""}).read_bytes("x" * 5000)
    assert len(str(problem.value)) < 300
    assert files.shown("a\nb\x1b[31m" + "c" * 500) == "a?b?[31m" + "c" * 89 + "..."
