"""Reading of files that anybody may have written."""

from __future__ import annotations

import os
import socket
from pathlib import Path

import pytest

from shockwave.errors import FileAccessError, InvalidValueError
from shockwave.files import lines_of, open_new, open_regular, parse_json, read_bytes, read_text


def test_a_file_of_the_limit_is_read(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"1234")
    assert read_bytes(tmp_path / "a", 4) == b"1234"


def test_a_larger_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"12345")
    with pytest.raises(FileAccessError, match=r"a: must be at most 4 bytes \(got more; cut it\)"):
        read_bytes(tmp_path / "a", 4, "cut it")


def test_a_link_to_a_file_is_read(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"1")
    (tmp_path / "b").symlink_to("a")
    assert read_bytes(tmp_path / "b", 4) == b"1"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no such pipes here")
def test_a_pipe_is_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a")
    with pytest.raises(FileAccessError, match=r"a: is not a file \(got a pipe or a device\)"):
        open_regular(tmp_path / "a")


@pytest.mark.skipif(not os.path.exists("/dev/zero"), reason="there are no such devices here")
def test_a_link_to_a_device_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a").symlink_to("/dev/zero")
    with pytest.raises(FileAccessError, match="is not a file"):
        read_bytes(tmp_path / "a", 4)


@pytest.mark.skipif(not hasattr(socket, "AF_UNIX"), reason="there are no such sockets here")
def test_a_socket_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # names of sockets are short
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind("a")
        with pytest.raises(FileAccessError, match="a: cannot be read"):
            read_bytes("a", 4)


@pytest.mark.parametrize(
    ("path", "told"), [(".", "is not a file"), ("none", "cannot be read"), ("a\0b", "is no path")], ids=repr
)
def test_a_path_that_is_not_a_readable_file_is_named(tmp_path: Path, path: str, told: str) -> None:
    with pytest.raises(FileAccessError, match=told):
        read_bytes(tmp_path / path, 4)


def test_text_has_no_byte_order_mark(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"\xef\xbb\xbfa")
    assert read_text(tmp_path / "a", 4) == "a"


def test_bytes_that_are_not_text_are_reported_with_their_line(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"a\n\xff")
    with pytest.raises(FileAccessError, match=r"got the byte 0xff in line 2"):
        read_text(tmp_path / "a", 4)


@pytest.mark.parametrize("text", ["[" * 100_000, '{"a": ' * 100_000, "", "{", "[NaN]", "9" * 5000], ids=lambda t: t[:8])
def test_invalid_json_is_refused(text: str) -> None:
    with pytest.raises(InvalidValueError, match="sweep: must be JSON"):
        parse_json(text, "sweep")


def test_json_that_is_nested_too_deeply_is_refused() -> None:
    parse_json("[" * 100 + "]" * 100, "sweep")
    with pytest.raises(InvalidValueError, match=r"got lists or mappings nested too deeply; mend it\)"):
        parse_json("[" * 101 + "]" * 101, "sweep", "mend it")


def test_lines_keep_their_ends(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"12\n\n3")
    with open_regular(tmp_path / "a") as file:
        assert list(lines_of(file, "a", 4)) == [b"12\n", b"\n", b"3"]


def test_a_line_without_end_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"1\n2345")
    with open_regular(tmp_path / "a") as file, pytest.raises(FileAccessError, match="a: must have lines shorter than"):
        list(lines_of(file, "a", 4))


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no such pipes here")
@pytest.mark.parametrize("mode", ["ab", "r+b"])
def test_a_pipe_is_not_waited_for_to_be_written(tmp_path: Path, mode: str) -> None:
    os.mkfifo(tmp_path / "a")
    with pytest.raises(FileAccessError, match=r"a: (is not a file|cannot be written)"):
        open_regular(tmp_path / "a", mode=mode, buffering=0)


def test_a_new_file_takes_the_place_of_a_link(tmp_path: Path) -> None:
    (tmp_path / "other").write_bytes(b"kept")
    (tmp_path / "a").symlink_to("other")
    with open_new(tmp_path / "a") as file:
        file.write(b"new")
    assert ((tmp_path / "other").read_bytes(), (tmp_path / "a").read_bytes()) == (b"kept", b"new")


def test_a_link_is_not_written_through(tmp_path: Path) -> None:
    (tmp_path / "precious").write_bytes(b"1")
    (tmp_path / "a").symlink_to("precious")
    with pytest.raises(FileAccessError, match=r"a: is not a file \(got a link; delete it\)"):
        open_regular(tmp_path / "a", mode="r+b")


@pytest.mark.skipif(os.name == "nt", reason="there are no such permissions here")
def test_a_new_file_is_not_executable(tmp_path: Path) -> None:
    open_regular(tmp_path / "a", mode="ab").close()
    assert (tmp_path / "a").stat().st_mode & 0o111 == 0
