"""Output files: whole or not at all, and ordinary files only."""

import os
import stat
from pathlib import Path

import pytest

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import remove_older, write_whole


def test_links_are_followed_and_folders_made(tmp_path):
    link, target = tmp_path / "link", tmp_path / "far" / "file"
    link.symlink_to(target)
    for content in ("first", "second"):
        write_whole(link, content)
        assert link.is_symlink() and target.read_text() == content
    remove_older(link)
    assert link.is_symlink() and not target.exists()


def test_a_failure_leaves_what_was_there(tmp_path, monkeypatch):
    path = tmp_path / "file"
    write_whole(path, "before")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.replace", full)
    with pytest.raises(InputError, match=r"^[^\n]*file: cannot write: No space left on device$"):
        write_whole(path, "after")
    assert [(each.name, each.read_text()) for each in tmp_path.iterdir()] == [("file", "before")]


def test_what_is_no_ordinary_file_stays(tmp_path):
    pipe, loop, device = tmp_path / "pipe", tmp_path / "loop", tmp_path / "null"
    os.mkfifo(pipe)
    loop.symlink_to(loop)
    device.symlink_to(os.devnull)
    for path, why in (
        (pipe, "a pipe"),
        (loop, "cannot write"),
        (device, "a device"),
        (tmp_path, "is a folder"),
    ):
        for act in (remove_older, lambda path: write_whole(path, "text")):
            with pytest.raises(InputError, match=why):
                act(path)
    assert stat.S_ISFIFO(pipe.stat().st_mode) and stat.S_ISCHR(Path(os.devnull).stat().st_mode)
    with pytest.raises(InputError, match="cannot make this folder: File exists"):
        write_whole(write_whole(tmp_path / "file", "text") / "more", "text")
