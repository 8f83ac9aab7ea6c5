"""Every change of mode names its cause, and the table of mode changes has them all."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from companion.params.table import TABLE
from companion.supervisor.failsafes import FAILSAFES, FailsafeAction
from companion.supervisor.mode_changes import MODE_CHANGES, Cause
from docs.generate import source

ROOT = source.ROOT / "companion"
HELM = ROOT / "supervisor" / "helm.py"
CHANGES = {"switch": 3, "choose_disarmed": 1, "stop": 0}  # name → place of the cause among the arguments


@cache
def parsed() -> dict[Path, ast.Module]:
    return {source.ROOT / module.place: module.tree for module in source.modules("companion")}


def is_helm(node: ast.expr, path: Path) -> bool:
    name = node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ""
    return name in ("helm", "_helm") or (path == HELM and name == "self")


def uses(path: Path) -> Iterator[ast.Attribute]:
    for node in ast.walk(parsed()[path]):
        if isinstance(node, ast.Attribute) and node.attr in CHANGES and is_helm(node.value, path):
            yield node


def sites() -> list[tuple[Path, ast.Call]]:
    """Every call that changes the mode or stops the boat."""
    found = []
    for path, tree in parsed().items():
        functions = {id(call.func): call for call in source.calls(tree)}
        for use in uses(path):
            assert id(use) in functions, f"{path.name}:{use.lineno}: call helm.{use.attr} itself, with its cause"
            found.append((path, functions[id(use)]))
    return found


def test_each_change_of_mode_names_its_cause() -> None:
    """As `Cause.X`, or as a name whose type mypy knows to be Cause."""
    found = sites()
    assert found
    for path, call in found:
        where = f"{path.name}:{call.lineno}"
        assert isinstance(call.func, ast.Attribute), where
        place = CHANGES[call.func.attr]
        assert len(call.args) == place + 1 and not call.keywords, where
        cause = call.args[place]
        if isinstance(cause, ast.Attribute):
            assert isinstance(cause.value, ast.Name) and cause.value.id == "Cause", where
            assert cause.attr in Cause.__members__, where
        else:
            assert isinstance(cause, ast.Name) and cause.id in ("cause", "refused"), where


def test_nobody_but_the_helm_sets_the_mode() -> None:
    for path, tree in parsed().items():
        for node in ast.walk(tree):
            targets = node.targets if isinstance(node, ast.Assign) else []
            for target in targets:
                written = isinstance(target, ast.Attribute) and target.attr in ("mode", "stopped")
                assert not written or path == HELM or not is_helm(target.value, path), f"{path.name}:{node.lineno}"


def test_each_cause_is_used_and_has_its_row() -> None:
    used = {
        node.attr
        for path, tree in parsed().items()
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
