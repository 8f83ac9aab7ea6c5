"""Tests look at what the code does, not at its private attributes. The files below may, each for a reason; no
others."""

from __future__ import annotations

import ast
from pathlib import Path

from tests.architecture.measures import ROOT

ALLOWED = {
    "tests/unit/conftest.py": "hands out the helm and the fence guard of a supervisor to tests of modes",
    "tests/unit/nav/test_error_state.py": "derivatives of the filter against differences",
    "tests/unit/analysis/test_report.py": "parts of one page",
    "tests/unit/cli/test_service.py": "what must not happen on the machine that tests",
    "tests/unit/io/mavlink/wire/test_framer.py": "counts the looks at a flood",
    "tests/unit/io/mavlink/wire/test_messages.py": "rebuilds the classes of the wheel",
    "tests/unit/io/mavlink/hub/test_operators.py": "every message that the hub handles",
    "tests/unit/positioning/test_consequence.py": "counts steps of a solver",
}
PUBLIC_ALL_THE_SAME = ("_replace", "_asdict", "_fields", "_exit")  # of named tuples and of os, in spite of their names
MOST = 8  # files; the list may only shrink
PACKAGES = ("companion", "sitl", "gcs_plugins")
OTHERS = ("tests/docs/", "tests/packaging/", "tests/bench")  # argparse; measurements, no tests


def own_names(tree: ast.Module) -> set[str]:
    """Private names that a file itself gives to its functions, classes and their attributes."""
    found = {
        node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and of_itself(node):
            found.add(node.attr)
    return found


def of_itself(node: ast.Attribute) -> bool:
    return isinstance(node.value, ast.Name) and node.value.id in ("self", "cls")


def private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__") and name not in PUBLIC_ALL_THE_SAME


def looks_inside(path: Path) -> bool:
    """Whether a file takes a private attribute of another's object, or imports a private name of ours."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    own = own_names(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and private(node.attr) and not of_itself(node) and node.attr not in own:
            return True
        ours = isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] in PACKAGES
        if ours and any(private(alias.name) for alias in node.names):
            return True
    return False


def test_few_tests_look_inside_the_code_under_test() -> None:
    files = (path for path in sorted((ROOT / "tests").rglob("*.py")))
    names = {str(path.relative_to(ROOT)) for path in files if looks_inside(path)}
    found = {name for name in names if not name.startswith(OTHERS)}
    assert found <= set(ALLOWED), f"use a public property, or tests.remembered: {found - set(ALLOWED)}"
    assert found == set(ALLOWED), f"no longer needed in the list: {set(ALLOWED) - found}"
    assert len(ALLOWED) <= MOST
