"""A copy is the process that it stands for."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from tests.copies import Copy, run_to_end
from tests.protocol.process import Companion
from tests.waiting import CAP_S

pytestmark = pytest.mark.process


@pytest.mark.parametrize("words", [("run", "revlot", "--sitl"), ("check", "revolt"), ("mission", "no.plan")])
def test_it_says_and_returns_what_a_new_process_does(words: tuple[str, ...], tmp_path: Path) -> None:
    new = subprocess.run([sys.executable, "-m", "companion", *words], capture_output=True, text=True, check=False)
    copy = run_to_end(*words)
    assert (copy.returncode, copy.stdout, copy.stderr) == (new.returncode, new.stdout, new.stderr)


def test_it_has_the_folder_and_the_environment_of_the_asker(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "kept"))
    done = run_to_end("run", "revolt", "--sitl", "--duration=0.2", "--log=logs", "--link=udpout:127.0.0.1:9")
    assert done.returncode == 0, done.stderr
    assert list((tmp_path / "logs").glob("*/ticks.csv")) and (tmp_path / "kept").is_dir()


def test_its_end_is_told(tmp_path: Path) -> None:
    folders = (f"--state={tmp_path / 'state'}", f"--log={tmp_path / 'logs'}")
    copy = Copy(["run", "revolt", "--sitl", "--link=udpout:127.0.0.1:9", *folders])
    assert copy.stdout.readline().startswith("USV companion") and copy.poll() is None
    with pytest.raises(subprocess.TimeoutExpired):
        copy.wait(0.0)
    copy.kill()
    copy.communicate(CAP_S)
    assert copy.poll() == copy.wait() == -signal.SIGKILL
    copy.send_signal(signal.SIGINT)  # to nobody


def test_nobody_else_gets_the_port_that_it_sends_to(tmp_path: Path) -> None:
    """A program that listened there would answer, and be obeyed as a ground station."""
    boat = Companion(tmp_path)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        port = int(boat.links[0].rpartition(":")[2])
        with pytest.raises(OSError, match="in use"):
            other.bind(("127.0.0.1", port))
        other.bind(("127.0.0.1", boat.udp_port))
        assert other.getsockname()[1] == port
