"""The key of signatures on the medium: it comes back, it is its owner's alone, and keeping it holds nobody up."""

from __future__ import annotations

import json
import os
import stat
from pathlib import Path

import pytest

from companion.record.signing_file import FILE, SigningFileError, read_signing, write_signing
from companion.record.state_file import StateFile
from companion.record.writer import ThreadWriter
from tests.faulty_disk import FaultyDisk

KEY = bytes(range(32))


def test_a_key_comes_back_and_no_one_else_can_read_it(tmp_path: Path) -> None:
    assert read_signing(tmp_path) == (None, 0)
    write_signing(tmp_path, KEY, 12345)
    assert read_signing(tmp_path) == (KEY, 12345)
    assert stat.S_IMODE((tmp_path / FILE).stat().st_mode) == 0o600
    write_signing(tmp_path, None, 7)
    assert read_signing(tmp_path) == (None, 7)
    assert [path.name for path in tmp_path.iterdir()] == [FILE]


@pytest.mark.parametrize("mode", [0o640, 0o604, 0o644, 0o620])
def test_a_key_that_others_can_reach_is_refused_with_the_remedy(tmp_path: Path, mode: int) -> None:
    write_signing(tmp_path, KEY, 1)
    (tmp_path / FILE).chmod(mode)
    with pytest.raises(SigningFileError, match="chmod 600"):
        read_signing(tmp_path)
    state = StateFile(tmp_path)
    kept, (warning,) = state.load_signing()
    assert kept == (None, 0) and "chmod 600" in warning and KEY.hex() not in warning
    state.close()


def test_a_temporary_file_left_by_a_power_cut_does_not_lend_its_mode(tmp_path: Path) -> None:
    (tmp_path / f"{FILE}.tmp").write_text("half", encoding="utf-8")
    (tmp_path / f"{FILE}.tmp").chmod(0o644)
    write_signing(tmp_path, KEY, 1)
    assert read_signing(tmp_path) == (KEY, 1)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"{",
        b"[]",
        b'{"format":1}',
        b'{"format":2,"key":null,"horizon":0}',
        b'{"format":1,"key":"00","horizon":0}',
        b'{"format":1,"key":null,"horizon":-1}',
        b'{"format":1,"key":5,"horizon":0}',
        b'{"format":1,"key":null,"horizon":true}',
        b"\xff\xfe",
    ],
)
def test_what_is_no_key_file_is_said(tmp_path: Path, content: bytes) -> None:
    (tmp_path / FILE).write_bytes(content)
    (tmp_path / FILE).chmod(0o600)
    with pytest.raises(SigningFileError, match="set the key again"):
        read_signing(tmp_path)


def test_saving_returns_while_the_medium_takes_its_time_and_the_newest_is_kept(tmp_path: Path) -> None:
    disk = FaultyDisk()
    state = StateFile(tmp_path)
    state.write_with(ThreadWriter(tmp_path, lambda: None, disk))
    disk.stall()
    for horizon in range(100):
        state.save_signing(KEY, horizon)
    disk.wait_for_stall()
    assert not (tmp_path / FILE).exists()
    disk.go_on()
    state.close()
    assert read_signing(tmp_path) == (KEY, 99)
    assert stat.S_IMODE((tmp_path / FILE).stat().st_mode) == 0o600


def test_a_full_medium_is_told_of_and_stops_nothing(tmp_path: Path) -> None:
    disk, warnings = FaultyDisk(), list[str]()
    state = StateFile(tmp_path, warnings.append)
    state.write_with(ThreadWriter(tmp_path, lambda: None, disk))
    disk.fail_with()
    state.save_signing(KEY, 1)
    state.close()
    assert len(warnings) == 1 and "No space left" in warnings[0]


def test_the_copy_of_a_state_in_a_log_folder_holds_no_key(tmp_path: Path) -> None:
    state = StateFile(tmp_path / "state")
    write_signing(tmp_path / "state", KEY, 1)
    state.save_parameters({"WP_RADIUS": 3.0})
    state.copy_to(tmp_path / "log")
    state.close()
    assert [path.name for path in (tmp_path / "log").iterdir()] == ["parameters.json"]
    assert json.loads((tmp_path / "state" / FILE).read_bytes())["key"] == KEY.hex()


@pytest.mark.skipif(os.geteuid() != 0, reason="only the superuser gives files away")
def test_a_key_set_by_the_superuser_belongs_to_who_runs_the_boat(tmp_path: Path) -> None:
    os.chown(tmp_path, 65534, 65534)
    write_signing(tmp_path, KEY, 1)
    kept = (tmp_path / FILE).stat()
    assert (kept.st_uid, kept.st_gid, stat.S_IMODE(kept.st_mode)) == (65534, 65534, 0o600)
