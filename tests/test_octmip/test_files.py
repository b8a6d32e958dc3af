"""Files appear whole or not at all, and what cannot be read says why in one sentence."""

import os
from pathlib import Path

import pytest

from femlib.files import whole_file
from octmip.errors import DataError
from octmip.input.files import check_writable, read_json_object, read_text, whole_folder, write_bytes


@pytest.mark.parametrize(
    ("error", "ends"), [(OSError(28, "No space left on device"), DataError), (KeyboardInterrupt(), KeyboardInterrupt)]
)
def test_a_write_that_fails_or_is_interrupted_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch, error, ends):
    target = tmp_path / "a.json"
    target.write_bytes(b"old")

    def fails(descriptor):
        raise error

    monkeypatch.setattr(os, "fsync", fails)
    with pytest.raises(ends, match="No space left" if ends is DataError else None):
        write_bytes(target, b"new")
    assert target.read_bytes() == b"old"
    assert len(list(tmp_path.iterdir())) == 1


def test_a_link_stays_and_its_target_is_replaced(tmp_path):
    (tmp_path / "target").write_bytes(b"old")
    (tmp_path / "link").symlink_to(tmp_path / "target")
    write_bytes(tmp_path / "link", b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "target").read_bytes() == b"new"


def test_a_device_is_written_to_as_it_is():
    write_bytes("/dev/null", b"gone")
    check_writable("/dev/null")
    assert Path("/dev/null").is_char_device()


def test_a_file_gets_the_permissions_of_the_user(tmp_path):
    write_bytes(tmp_path / "a", b"1")
    (tmp_path / "b").write_bytes(b"1")
    with whole_file(tmp_path / "c") as passing:
        passing.write_bytes(b"1")
    assert len({(tmp_path / name).stat().st_mode for name in "abc"}) == 1


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o444])
def test_a_file_that_is_written_again_keeps_its_permissions(tmp_path, mode):
    for name in "abc":
        (tmp_path / name).write_bytes(b"old")
        (tmp_path / name).chmod(mode)
    write_bytes(tmp_path / "a", b"new")
    with whole_folder(tmp_path) as passing:
        (passing / "b").write_bytes(b"new")
    with whole_file(tmp_path / "c") as passing:
        passing.write_bytes(b"new")
    assert [(file.read_bytes(), file.stat().st_mode & 0o777) for file in tmp_path.iterdir()] == [(b"new", mode)] * 3


@pytest.mark.parametrize(("name", "reason"), [("", "is a folder"), ("none/a.json", "there is no folder")])
def test_a_place_that_cannot_be_written_is_refused_beforehand(tmp_path, name, reason):
    with pytest.raises(DataError, match=reason):
        check_writable(tmp_path / name)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "is empty"),
        (b" \n", "is empty"),
        (b"ab\n\xff\xfe", "line 2: byte 0xff is not UTF-8"),
    ],
)
def test_text_that_cannot_be_read_says_why(tmp_path, content, reason):
    (tmp_path / "a").write_bytes(content)
    with pytest.raises(DataError, match=reason):
        read_text(tmp_path / "a")


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ('{"a": [1, 2', "ends in the middle"),
        ('{"a": "tex', "ends in the middle"),
        ('{"a": 1,}', "line 1"),
        ("[1]", "holds a JSON list"),
        ('{"a": NaN}', "NaN is no JSON number"),
        ('{"a": ' + "[" * 200_000, "nested deeper than 100 levels"),
        ('{"a": ' + "[" * 101 + "]" * 101 + "}", "nested deeper than 100 levels"),
        ('{"a": 1, "a": 2}', "names 'a' twice"),
        ('{"a": "\\ud800"}', "surrogates not allowed"),
        ('{"a": ' + "9" * 5000 + "}", "4300"),
        ("a,b\n1,2\n", r"begins with 'a,b'; expected JSON: one object \{...\}"),
        ("true,b\n1,2\n", "begins with 'true,b'; expected JSON"),
    ],
)
def test_json_that_cannot_be_read_says_why(tmp_path, content, reason):
    (tmp_path / "a").write_text(content)
    with pytest.raises(DataError, match=reason):
        read_json_object(tmp_path / "a")


def test_nothing_but_a_regular_file_is_read_and_nothing_is_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", "/dev/zero", tmp_path):
        with pytest.raises(DataError, match=r"it is a (pipe or device|folder)\); expected a regular file"):
            read_text(path)
    with pytest.raises(DataError, match="null byte"):
        read_text("a\0b")
