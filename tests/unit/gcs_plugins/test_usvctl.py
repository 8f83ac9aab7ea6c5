"""`usvctl` without a boat: parameter files, mistakes on the command line."""

from __future__ import annotations

import io
import sys
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from gcs_plugins.usvctl import parameters, status
from gcs_plugins.usvctl.boat import Mistake, NoVessel
from gcs_plugins.usvctl.cli import main


def test_a_saved_file_reads_back(tmp_path: Path) -> None:
    path = tmp_path / "usv.params"
    path.write_text(parameters.to_text({"NAV_DLL_ACT": 2, "PATH_BW_SURGE": 0.4}, 7), encoding="utf-8")
    assert "7\t1\tNAV_DLL_ACT\t2\t6\n7\t1\tPATH_BW_SURGE\t0.4\t9\n" in path.read_text(encoding="utf-8")
    assert parameters.from_file(path) == {"NAV_DLL_ACT": 2.0, "PATH_BW_SURGE": 0.4}


@pytest.mark.parametrize(
    "line", ["PATH_BW_SURGE 0.4", "PATH_BW_SURGE,0.4", "PATH_BW_SURGE=0.4", "1\t1\tPATH_BW_SURGE\t0.4\t9"]
)
def test_the_forms_of_other_tools(line: str, tmp_path: Path) -> None:
    path = tmp_path / "some.parm"
    path.write_text(f"# a comment\n\n{line}\n", encoding="utf-8")
    assert parameters.from_file(path) == {"PATH_BW_SURGE": 0.4}


@pytest.mark.parametrize(
    "line", ["PATH_BW_SURGE", "PATH_BW_SURGE much", "PATH_BW_SURGE nan", "1 1 PATH_BW_SURGE 0.4", "a b c d e f"]
)
def test_a_line_that_is_none_is_named(line: str, tmp_path: Path) -> None:
    path = tmp_path / "some.parm"
    path.write_text(f"NAV_DLL_ACT 1\n{line}\n", encoding="utf-8")
    with pytest.raises(Mistake, match="line 2"):
        parameters.from_file(path)


@pytest.mark.parametrize(
    "words",
    [
        ("goto", "95", "10"),
        ("goto", "63", "nan"),
        ("nudge", "far", "0"),
        ("station", "180"),
        ("follow", "--station", "180@-5"),
        ("mode", "Fly"),
        ("do", "nothing"),
        ("start", "--wait", "--within", "0"),
        (),
    ],
)
def test_mistakes_end_with_2_before_any_boat_is_looked_for(
    words: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 2 and "usage: usvctl" in capsys.readouterr().err


class Boat:
    """What a boat has said."""

    def __init__(self, armed: bool, system_status: int, health: int) -> None:
        self.armed = armed
        self.said = {"HEARTBEAT": {"system_status": system_status}}
        if health >= 0:
            self.said["SYS_STATUS"] = {"onboard_control_sensors_health": health}

    def wait(self, condition: Callable[[], bool], timeout_s: float) -> bool:
        return condition()

    def newest(self, kind: str) -> dict[str, int] | None:
        return self.said.get(kind)


@pytest.mark.parametrize(
    ("boat", "reasons"),
    [
        (Boat(False, 3, 0x10000000), []),
        (Boat(True, 4, 0), []),
        (Boat(False, 3, 0x00000020), ["arming would be refused"]),
        (Boat(True, 5, 0x10000000), ["a failsafe acts"]),
    ],
)
def test_ready_is_free_to_arm_or_armed_without_a_failsafe(boat: Any, reasons: list[str]) -> None:
    assert status.not_ready(boat) == reasons


def test_a_silent_boat_is_neither_ready_nor_not() -> None:
    boat: Any = Boat(False, 3, -1)
    with pytest.raises(NoVessel, match="SYS_STATUS"):
        status.not_ready(boat)


def test_an_answer_of_the_shell_counts_when_it_is_complete() -> None:
    printed = "USV companion 0.1\nusv> status\nReVolt: disarmed\nLoad: 3%\n"
    assert status.answer_in(printed, "status") is None
    assert status.answer_in(printed + "usv> ", "status") == ["ReVolt: disarmed", "Load: 3%"]
    assert status.answer_in(printed + "usv> ", "devices") is None


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("words", [("arm",), ("do", "lower"), ("dock",), ("start", "--arm"), ("follow",)])
@pytest.mark.parametrize("answer", ["n\n", "\n", ""])
def test_at_a_terminal_it_asks_before_what_is_not_safe_at_once(
    words: tuple[str, ...], answer: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "stdin", Terminal(answer))
    assert main(words) == 2
    said = capsys.readouterr()
    assert "Send it? [y/N]" in said.out and said.err == "usvctl: not sent\n"


@pytest.mark.parametrize(
    ("words", "stdin"),
    [
        (("arm",), Terminal("y\n")),
        (("--yes", "arm"), Terminal("")),
        (("arm", "--yes"), Terminal("")),
        (("arm",), io.StringIO("")),  # a script
        (("hold",), Terminal("")),
        (("stop",), Terminal("")),
    ],
)
def test_what_is_confirmed_safe_or_asked_by_a_script_is_sent(
    words: tuple[str, ...], stdin: io.StringIO, monkeypatch: pytest.MonkeyPatch
) -> None:
    sent: list[str] = []
    monkeypatch.setattr(sys, "stdin", stdin)
    boat = SimpleNamespace(do=sent.append)
    monkeypatch.setattr("gcs_plugins.usvctl.boat.connected", lambda link, timeout_s: nullcontext(boat))
    assert main(words) == 0 and sent == [word for word in words if word != "--yes"]


def test_without_mavsdk_it_says_how_to_get_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "mavsdk", None)
    monkeypatch.delitem(sys.modules, "gcs_plugins.usvctl.boat")
    assert main(["hold"]) == 2
    assert "pip install 'usv-companion[usvctl]'" in capsys.readouterr().err
