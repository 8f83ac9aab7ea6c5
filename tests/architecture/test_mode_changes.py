"""Every change of mode names its cause, and the table of mode changes has them all."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from companion.params.table import TABLE
from companion.supervisor.failsafes import FAILSAFES, FailsafeAction
from companion.supervisor.mode_changes import MODE_CHANGES, Cause

ROOT = Path(__file__).parents[2] / "companion"
HELM = ROOT / "supervisor" / "helm.py"
CHANGES = {"switch": 3, "choose_disarmed": 1, "stop": 0}  # name → place of the cause among the arguments
PARSED = {path: ast.parse(path.read_text(encoding="utf-8")) for path in sorted(ROOT.rglob("*.py"))}


def is_helm(node: ast.expr, path: Path) -> bool:
    name = node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ""
    return name in ("helm", "_helm") or (path == HELM and name == "self")


def uses(path: Path) -> Iterator[ast.Attribute]:
    for node in ast.walk(PARSED[path]):
        if isinstance(node, ast.Attribute) and node.attr in CHANGES and is_helm(node.value, path):
            yield node


def sites() -> list[tuple[Path, ast.Call]]:
    """Every call that changes the mode or stops the boat."""
    found = []
    for path in PARSED:
        calls = [node for node in ast.walk(PARSED[path]) if isinstance(node, ast.Call)]
        functions = {id(call.func): call for call in calls}
        for use in uses(path):
            assert id(use) in functions, f"{path.name}:{use.lineno}: call helm.{use.attr} itself, with its cause"
            found.append((path, functions[id(use)]))
    return found


SITES = sites()


@pytest.mark.parametrize(("path", "call"), SITES, ids=[f"{path.stem}:{call.lineno}" for path, call in SITES])
def test_each_change_of_mode_names_its_cause(path: Path, call: ast.Call) -> None:
    """As `Cause.X`, or as a name whose type mypy knows to be Cause."""
    assert isinstance(call.func, ast.Attribute)
    place = CHANGES[call.func.attr]
    assert len(call.args) == place + 1 and not call.keywords
    cause = call.args[place]
    if isinstance(cause, ast.Attribute):
        assert isinstance(cause.value, ast.Name) and cause.value.id == "Cause" and cause.attr in Cause.__members__
    else:
        assert isinstance(cause, ast.Name) and cause.id in ("cause", "refused")


def test_nobody_but_the_helm_sets_the_mode() -> None:
    for path, tree in PARSED.items():
        for node in ast.walk(tree):
            targets = node.targets if isinstance(node, ast.Assign) else []
            for target in targets:
                written = isinstance(target, ast.Attribute) and target.attr in ("mode", "stopped")
                assert not written or path == HELM or not is_helm(target.value, path), f"{path.name}:{node.lineno}"


def test_each_cause_is_used_and_has_its_row() -> None:
    used = {
        node.attr
        for path, tree in PARSED.items()
        if path.stem != "mode_changes"
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "Cause"
    }
    assert used == set(Cause.__members__)
    assert {row.cause for row in MODE_CHANGES} == set(Cause)


def test_each_failsafe_that_acts_has_its_row_in_their_order() -> None:
    rows = [row.name for row in MODE_CHANGES if row.cause is Cause.FAILSAFE]
    assert rows == [failsafe.name for failsafe in FAILSAFES if failsafe.action is not FailsafeAction.IGNORE]
    over = [row.name for row in MODE_CHANGES if row.cause is Cause.FAILSAFE_OVER]
    assert over == [f"{failsafe.name}_over" for failsafe in FAILSAFES if failsafe.stays is not None]
    assert len({row.name for row in MODE_CHANGES}) == len(MODE_CHANGES)


def test_parameters_exist() -> None:
    names = {spec.name for spec in TABLE}
    assert {row.parameter for row in MODE_CHANGES if row.parameter} <= names
