"""`usvctl` without a boat: parameter files, mistakes on the command line."""

from __future__ import annotations

import sys
from pathlib import Path

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


def test_without_mavsdk_it_says_how_to_get_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "mavsdk", None)
    monkeypatch.delitem(sys.modules, "gcs_plugins.usvctl.boat")
    assert main(["hold"]) == 2
    assert "pip install 'usv-companion[usvctl]'" in capsys.readouterr().err
