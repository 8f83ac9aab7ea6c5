"""The generated pages are whole: every parameter, key, command, failsafe, column and text stands in them."""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass
from pathlib import Path

import pytest

from companion.cli.main import argument_parser
from companion.config.units import unit_of
from companion.config.vessel import VesselConfig
from companion.core.decision import ModeId, TextKind
from companion.leader_module.config import LeaderConfig
from companion.params.table import TABLE
from companion.supervisor.authority import ROWS
from companion.supervisor.failsafes import FAILSAFES
from companion.supervisor.mode_changes import MODE_CHANGES
from docs.generate.command_line import commands
from docs.generate.house import layers, rooms
from docs.generate.keys import UndescribedKey, keys
from docs.generate.log_columns import UndescribedColumn, columns
from docs.generate.mavlink import command_handlers, described_params, refusals
from docs.generate.pages import PAGES
from docs.generate.results import figure, results
from docs.generate.statustexts import all_texts, severity
from docs.generate.templates import templates
from tests.docs.pages import DOCS, ROOT, generated


def _page(place: str) -> str:
    return generated()[DOCS / place]


@pytest.mark.parametrize("place", [place for place in PAGES if place.endswith(".md")])
def test_a_page_is_well_formed(place: str) -> None:
    text = _page(place)
    assert text.startswith("# ")
    assert not re.search(r"<function|<class|object at 0x|\bnan\b|\| None \|", text), place
    widths = [line.replace("\\|", "").count("|") for line in text.splitlines() if line.startswith("|")]
    assert all(width >= 3 for width in widths)


def test_every_parameter_has_its_line() -> None:
    text = _page("reference/parameters.md")
    missing = [spec.name for spec in TABLE if f"`{spec.name}`{{#{spec.name.lower()}}}" not in text]
    assert not missing


def test_every_table_of_a_file_stands_in_the_page() -> None:
    text = _page("reference/vessel-file.md")
    for root in (VesselConfig, LeaderConfig):
        for key in keys(root):
            assert f"| `{key.name}` |" in text
    assert "### `[[thruster]]`" in text and "### `[sitl.plants.NAME.nozzle]`" in text


def test_a_key_without_a_meaning_is_named() -> None:
    @dataclass
    class Table:
        speed_mps: float

    Table.__annotations__ = {"speed_mps": float}
    with pytest.raises(UndescribedKey, match=r"Table\.speed_mps"):
        list(keys(Table))


def test_a_column_without_a_meaning_is_named() -> None:
    with pytest.raises(UndescribedColumn, match="shoe_size"):
        columns(["t_s", "shoe_size"], {"t_s": "Time."})


def test_every_command_has_its_section() -> None:
    text = _page("reference/command-line.md")
    for path, _, command in commands(argument_parser(), "companion"):
        if not any(hasattr(action, "choices") and isinstance(action.choices, dict) for action in command._actions):
            assert f"### `{path}`" in text, path


def test_every_mavlink_command_is_described() -> None:
    text = _page("reference/mavlink.md")
    for number, handler in command_handlers().items():
        assert f"({number})\n" in text, number
        assert handler.__doc__


def test_params_and_refusals_of_a_command_are_read_from_its_function() -> None:
    assert described_params("Do.\n\nparam1: One\ngoes on.\nparam3: Three.\n") == [(1, "One goes on."), (3, "Three.")]
    arm = command_handlers()[400]
    assert refusals(arm) == ["param 1 of arming should be 0 or 1"]


def test_every_mode_and_failsafe_stands_in_its_page() -> None:
    assert all(f"| `{mode.value}` |" in _page("reference/modes.md") for mode in ModeId)
    text = _page("reference/authority.md")
    places = [text.index(f"`{row.name}`{{#{row.name}}}") for row in FAILSAFES]
    assert places == sorted(places)


def test_every_rule_and_every_reason_to_change_the_mode_stands_on_the_page_in_order() -> None:
    text = _page("reference/authority.md")
    rules = [text.index(f"`{row.name}`{{#{row.name}}}") for row in ROWS]
    assert rules == sorted(rules)
    changes = text[text.index("## What changes the mode") :]
    reasons = [changes.index(f"| `{change.name}` |") for change in MODE_CHANGES]
    assert reasons == sorted(reasons)


def test_texts_are_found_with_severity_and_name() -> None:
    said = {(one.text, severity(one), one.name) for one in all_texts()}
    assert ("Disarmed", "INFO", "disarmed") in said
    assert ("Position lost", "CRITICAL", "position_lost") in said
    assert ("PreArm: water in the hull", "WARNING", "arming_refused") in said
    assert any(text.startswith("Go-to refused: ") for text, _, _ in said), "through a function that refuses"
    assert len(said) > 200
    assert all(
        kind in TextKind.__members__ or kind == "as the case is"
        for one in all_texts()
        for kind in one.kind.split(" or ")
    )


def test_a_text_of_several_parts_becomes_a_template() -> None:
    function = ast.parse(
        "def f(self, name):\n    text = f'{name} at {self.speed_mps:.1f} m/s' if fast else 'slow'\n    say(text + '!')\n"
    ).body[0]
    assert isinstance(function, ast.FunctionDef)
    call = next(node for node in ast.walk(function) if isinstance(node, ast.Call))
    assert templates(call.args[0], function) == ["\0name\0 at {speed_mps} m/s!", "slow!"]


@pytest.mark.parametrize(
    ("name", "unit"),
    [("speed_mps", "m/s"), ("x_m", "m"), ("full_v", "V"), ("y_v", ""), ("yaw_nm", "Nm"), ("sway_n", "N"), ("mode", "")],
)
def test_a_name_ends_in_its_unit(name: str, unit: str) -> None:
    assert unit_of(name) == unit


def test_every_room_stands_in_the_table_of_the_architecture() -> None:
    page = (DOCS / "inside" / "architecture.md").read_text(encoding="utf-8")
    table_of_rooms = page.partition("## The rooms")[2].partition("\n## ")[0]
    folders = [name for name in rooms() if (ROOT / "companion" / name).is_dir()]
    assert [name for name in folders if f"`{name}`" not in table_of_rooms] == []


def test_the_house_has_every_room_once_and_imports_point_down() -> None:
    found = rooms()
    rows = layers(found)
    assert sorted(room.name for row in rows for room in row) == sorted(found)
    floor = {room.name: i for i, row in enumerate(rows) for room in row}
    up = [(name, used) for name, room in found.items() for used in room.uses if floor[used] < floor[name]]
    assert not up


def test_figures_of_a_table_are_the_worst_the_mean_or_a_count() -> None:
    runs = [{"metrics": {"a": 1.0}}, {"metrics": {"a": 0.0}}, {"metrics": {"a": 4.0}}]
    assert figure({"metric": "a", "of": "max"}, runs) == "4"
    assert figure({"metric": "a", "of": "mean"}, runs) == "1.67"
    assert figure({"metric": "a", "of": "count"}, runs) == "2 of 3"
    assert figure({"metric": "b", "of": "max"}, runs) == ""


def test_results_without_a_table_say_so(tmp_path: Path) -> None:
    assert "No table is measured yet" in results(tmp_path)
