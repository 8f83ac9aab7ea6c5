"""`companion signing`: the key that MAVProxy makes of the same passphrase, kept where the vessel looks for it."""

from __future__ import annotations

import hashlib
import io
from pathlib import Path

import pytest

from companion.cli.main import main
from companion.record.signing_file import FILE, read_signing, write_signing
from companion.record.state_file import StateFile


def typed(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO(text))


def test_set_status_clear(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    typed(monkeypatch, "deep water\n")
    assert main(["signing", "set", "revolt", "--state", str(tmp_path)]) == 0
    assert read_signing(tmp_path)[0] == hashlib.sha256(b"deep water").digest()
    assert main(["signing", "status", "revolt", "--state", str(tmp_path)]) == 0
    assert main(["signing", "clear", "revolt", "--state", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "a key is set" in said and "deep water" not in said and hashlib.sha256(b"deep water").hexdigest() not in said
    assert read_signing(tmp_path) == (None, 0)
    (tmp_path / FILE).chmod(0o644)
    assert main(["signing", "status", "revolt", "--state", str(tmp_path)]) == 1
    assert "chmod 600" in capsys.readouterr().err


def test_the_same_key_again_keeps_its_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_signing(tmp_path, hashlib.sha256(b"deep water").digest(), 4711)
    for passphrase, horizon in (("deep water\n", 4711), ("shallow\n", 0)):
        typed(monkeypatch, passphrase)
        assert main(["signing", "set", "revolt", "--state", str(tmp_path)]) == 0
        assert read_signing(tmp_path)[1] == horizon


def test_each_boat_has_its_own_and_a_leader_module_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    for arguments, folder in ((["revolt"], "revolt"), (["revolt", "--sitl"], "revolt-sitl"), (["viknes"], "viknes")):
        typed(monkeypatch, f"{folder}\n")
        assert main(["signing", "set", *arguments]) == 0
        assert (
            read_signing(tmp_path / "usv-companion" / folder / "state")[0] == hashlib.sha256(folder.encode()).digest()
        )


def test_nothing_is_changed_by_mistakes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    typed(monkeypatch, "\n")
    assert main(["signing", "set", "revolt", "--state", str(tmp_path)]) == 2
    assert "the passphrase is empty" in capsys.readouterr().err
    assert main(["signing", "status", "no-such-boat"]) == 2
    running = StateFile(tmp_path)
    typed(monkeypatch, "while it runs\n")
    assert main(["signing", "set", "revolt", "--state", str(tmp_path)]) == 2
    assert "in use by another companion" in capsys.readouterr().err
    running.close()
    assert not (tmp_path / FILE).exists()


def test_ctrl_d_in_place_of_a_passphrase_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def ended(prompt: str) -> str:
        raise EOFError

    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    monkeypatch.setattr("getpass.getpass", ended)
    assert main(["signing", "set", "revolt", f"--state={tmp_path}"]) == 2
    assert capsys.readouterr().err == "companion: no passphrase; nothing was changed\n"
    assert not (tmp_path / FILE).exists()
