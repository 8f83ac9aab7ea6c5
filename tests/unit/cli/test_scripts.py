"""Scripts of a vessel on a medium that takes nothing."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

from companion.cli.scripts import keep_scripts, script_links
from companion.config.scripts import ScriptConfig
from companion.core.events import EventLog
from companion.loop import Vessel


def test_a_boat_starts_where_the_folder_of_a_script_cannot_be_made(tmp_path: Path) -> None:
    """It ended with a traceback, and after a restart under way nobody could reach the boat."""
    (tmp_path / "state").touch()
    recorders: list[Any] = []
    config = SimpleNamespace(scripts=(ScriptConfig("survey", "survey.py"),))
    vessel = SimpleNamespace(
        config=config, events=EventLog(), parameters={"SCR_ENABLE": 1.0}, add_recorder=recorders.append
    )
    links = script_links(config.scripts)
    keep_scripts(cast(Vessel, vessel), tmp_path / "boat.toml", links, tmp_path / "state", tmp_path / "log", 3.0)
    assert [event.text for event in vessel.events.drain()] == ["Script survey: no folder: Not a directory"]
    assert links[0].fault == "no folder: Not a directory"
    for closing in (*recorders, *links):
        closing.close()
