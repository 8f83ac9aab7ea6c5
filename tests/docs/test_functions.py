"""The page of the transmitter has every function and mode of a switch, that of missions every item that is accepted."""

from __future__ import annotations

import re

from companion.mission.commands import CIRCLES, POLYGONS, RULES, Command, Role
from companion.params.transmitter import NO_MODE, SWITCH_MODES, AuxFunction
from tests.docs.pages import DOCS


def _page(name: str) -> str:
    return (DOCS / "use" / name).read_text(encoding="utf-8")


def _numbers(heading: str) -> set[int]:
    """Numbers in the first column of the table under a heading of the transmitter's page."""
    section = _page("transmitter.md").partition(f"## {heading}\n")[2].partition("\n## ")[0]
    cells = re.findall(r"^\| ([-\d, ]+) \|", section, re.MULTILINE)
    return {int(number) for cell in cells for number in cell.split(",")}


def test_every_function_of_a_channel_stands_on_the_page() -> None:
    assert _numbers("Functions of a channel") == set(AuxFunction)


def test_every_mode_of_the_mode_switch_stands_on_the_page() -> None:
    assert _numbers("Modes of the mode switch") == {NO_MODE, *SWITCH_MODES}


def test_every_item_of_a_mission_stands_on_a_page() -> None:
    """Here, or with the cameras."""
    elsewhere = {Command.FENCE_RETURN_POINT, Command.RALLY_POINT, *CIRCLES, *POLYGONS}
    cameras = {command for command, rule in RULES.items() if rule.role is Role.PAYLOAD}
    for page, commands in (("missions.md", set(RULES) - elsewhere - cameras), ("payload.md", cameras)):
        said = set(re.findall(r"\w+", _page(page)))
        names = {Command(command).name for command in commands}
        assert {name for name in names if name not in said and f"MAV_CMD_{name}" not in said} == set(), page
