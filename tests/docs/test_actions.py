"""The page of the plug-ins has every action of their table, in the column that says whether it is asked for."""

from __future__ import annotations

import re

from gcs_plugins.commands import ACTIONS
from tests.docs.pages import DOCS

_PAGE = (DOCS / "ground-stations" / "plug-ins.md").read_text(encoding="utf-8")
_ROWS = re.findall(r"^\| ([^|]*) \|([^|]*)\|([^|]*)\|$", _PAGE.partition("## Actions")[2].partition("\n## ")[0], re.M)


def _names(column: int) -> set[str]:
    return {name for row in _ROWS for name in re.findall(r"`([\w-]+)`", row[column])}


def test_the_first_column_has_what_is_safe_at_one_click() -> None:
    assert _names(1) == {action.name for action in ACTIONS if action.at_once}


def test_the_second_column_has_what_is_asked_for_first() -> None:
    assert _names(2) == {action.name for action in ACTIONS if not action.at_once}
