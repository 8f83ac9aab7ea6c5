"""QGroundControl's action files and their installer."""

from __future__ import annotations

import json
from pathlib import Path

import platformdirs
import pytest

from gcs_plugins.commands import ACTIONS, BY_NAME
from gcs_plugins.qgroundcontrol.__main__ import main
from gcs_plugins.qgroundcontrol.action_files import files

KEYS = {"label": str, "description": str, "mavCmd": int} | {f"param{n}": float for n in range(1, 8)}
NAMES = sorted(files())


@pytest.mark.parametrize("name", NAMES)
def test_a_file_passes_the_checks_that_qgroundcontrol_makes(name: str) -> None:
    """Those of MavlinkActionManager.cc: file type, version, required keys, types; and no other keys."""
    content = json.loads(files()[name])
    assert set(content) == {"version", "fileType", "actions"}
    assert content["version"] == 1 and content["fileType"] == name.split("/")[0]
    assert content["actions"]
    for action in content["actions"]:
        assert {"label", "description", "mavCmd"} <= set(action) <= set(KEYS)
        assert all(type(value) is KEYS[key] for key, value in action.items())


def test_the_fly_view_shows_what_is_safe_at_one_click_and_the_joystick_its_share() -> None:
    fly_view, joystick = (
        json.loads(files()[f"MavlinkActions/usv_{name}.json"])["actions"] for name in ("fly_view", "joystick")
    )
    assert [action["label"] for action in fly_view] == [action.label for action in ACTIONS if action.at_once]
    arms = [action for action in (*fly_view, *joystick) if action["mavCmd"] == 400 and action.get("param1") == 1.0]
    assert not arms, "QGroundControl's own slider arms"
    assert [action["label"] for action in joystick] == [action.label for action in ACTIONS if action.joystick]
    hold = next(action for action in fly_view if action["label"] == BY_NAME["hold"].label)
    assert (hold["mavCmd"], hold["param1"], hold["param2"]) == (176, 1.0, 50593792.0)


def test_install_keeps_what_was_there_and_uninstall_brings_it_back(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    theirs = tmp_path / "MavlinkActions" / "usv_fly_view.json"
    theirs.parent.mkdir()
    theirs.write_text("somebody's own", encoding="utf-8")
    assert main(["install", "--dir", str(tmp_path)]) == 0
    assert main(["install", "--dir", str(tmp_path)]) == 0, "again, as after an update"
    assert "usv_fly_view.json" in capsys.readouterr().out
    assert {name: (tmp_path / name).read_text(encoding="utf-8") for name in NAMES} == files()
    assert theirs.with_name("usv_fly_view.json.before-usv").read_text(encoding="utf-8") == "somebody's own"
    assert not theirs.with_name("usv_fly_view.json.before-usv-2").exists(), "our own file is no one's to keep"
    assert main(["uninstall", "--dir", str(tmp_path)]) == 0
    left = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file()}
    assert left == {"MavlinkActions/usv_fly_view.json"}
    assert theirs.read_text(encoding="utf-8") == "somebody's own"


def test_a_file_changed_after_installing_is_not_lost(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["install", "--dir", str(tmp_path)]) == 0
    changed = tmp_path / "CustomActions" / "usv_joystick.json"
    changed.write_text("with my own buttons", encoding="utf-8")
    assert main(["install", "--dir", str(tmp_path)]) == 0
    assert changed.with_name("usv_joystick.json.before-usv").read_text(encoding="utf-8") == "with my own buttons"
    changed.write_text("changed again", encoding="utf-8")
    assert main(["uninstall", "--dir", str(tmp_path)]) == 0
    assert changed.read_text(encoding="utf-8") == "changed again"
    assert "changed since" in capsys.readouterr().out


def test_it_finds_the_folders_of_the_release_and_of_the_daily_build(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(platformdirs, "user_documents_path", lambda: tmp_path)
    assert main(["install"]) == 2
    assert "start QGroundControl once" in capsys.readouterr().err
    for name in ("QGroundControl", "QGroundControl Daily"):
        (tmp_path / name).mkdir()
    assert main(["install"]) == 0
    assert len(list(tmp_path.rglob("usv_joystick.json"))) == 4


def test_mistakes_are_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["install", "--dir", str(tmp_path / "nowhere")]) == 2
    assert main(["uninstall", "--dir", str(tmp_path)]) == 2
    assert "no action files of ours are installed in" in capsys.readouterr().err
