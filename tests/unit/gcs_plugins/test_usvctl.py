"""`usvctl` without a boat: parameter files, mistakes on the command line."""

from __future__ import annotations

import io
import sys
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import pytest

from gcs_plugins.usvctl import parameters
from gcs_plugins.usvctl.boat import Mistake
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
    assert main(words) == 0 and sent == [words[-1]]


def test_without_mavsdk_it_says_how_to_get_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "mavsdk", None)
    monkeypatch.delitem(sys.modules, "gcs_plugins.usvctl.boat")
    assert main(["hold"]) == 2
    assert "pip install 'usv-companion[usvctl]'" in capsys.readouterr().err
