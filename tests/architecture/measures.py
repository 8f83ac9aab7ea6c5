"""What the house rules look for in a file's syntax tree; ruff holds complexity, parameters and conditions."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
ROOMS = ("companion", "sitl", "gcs_plugins")
LONGEST = 60
Function = ast.FunctionDef | ast.AsyncFunctionDef


def sources(*rooms: str) -> list[Path]:
    """All Python files of these rooms."""
    return sorted(path for room in rooms for path in (ROOT / room).rglob("*.py"))


def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def long_functions(tree: ast.Module) -> list[str]:
    """Names of functions of more than `LONGEST` lines, from `def` to their end."""
    functions = (node for node in ast.walk(tree) if isinstance(node, Function))
    return [node.name for node in functions if (node.end_lineno or 0) - node.lineno + 1 > LONGEST]


def undocumented(tree: ast.Module) -> list[str]:
    """Public functions, classes and methods without a docstring. A method that `companion.core.ports` documents needs
    none of its own."""
    return [name for name, node in _public(tree) if ast.get_docstring(node) is None]


def _public(tree: ast.Module) -> Iterator[tuple[str, Function | ast.ClassDef]]:
    for node in tree.body:
        if isinstance(node, Function | ast.ClassDef) and not node.name.startswith("_"):
            yield node.name, node
            if isinstance(node, ast.ClassDef):
                for part in node.body:
                    if isinstance(part, Function) and not part.name.startswith("_") and part.name not in _of_ports():
                        yield f"{node.name}.{part.name}", part


@cache
def _of_ports() -> frozenset[str]:
    tree = parsed(ROOT / "companion" / "core" / "ports.py")
    return frozenset(part.name for part in ast.walk(tree) if isinstance(part, Function))
