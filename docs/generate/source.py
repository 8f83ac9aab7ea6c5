"""The program's own source as syntax trees."""

from __future__ import annotations

import ast
import gc
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True, slots=True)
class Module:
    """One file. `place`: its path from the top level, `name`: as it is imported."""

    place: str
    name: str
    tree: ast.Module
    lines: int


@cache
def modules(package: str) -> tuple[Module, ...]:
    """Every module of a package of the top level. The trees are kept: a collection of garbage looks at none of their
    nodes, which takes longer than to make them."""
    gc.disable()
    try:
        return tuple(_module(path) for path in sorted((ROOT / package).rglob("*.py")))
    finally:
        gc.freeze()
        gc.enable()


def _module(path: Path) -> Module:
    text = path.read_text(encoding="utf-8")
    place = path.relative_to(ROOT)
    parts = place.with_suffix("").parts
    name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
    return Module(place.as_posix(), name, ast.parse(text), len(text.splitlines()))


@cache
def _kept(tree: ast.AST) -> tuple[ast.FunctionDef | ast.Call | ast.Import | ast.ImportFrom, ...]:
    kinds = ast.FunctionDef | ast.Call | ast.Import | ast.ImportFrom
    return tuple(node for node in ast.walk(tree) if isinstance(node, kinds))


@cache
def imports(tree: ast.AST) -> tuple[ast.Import | ast.ImportFrom, ...]:
    """Every import statement, at any depth."""
    return tuple(node for node in _kept(tree) if isinstance(node, ast.Import | ast.ImportFrom))


@cache
def functions(tree: ast.AST) -> tuple[ast.FunctionDef, ...]:
    """Every function and method, at any depth."""
    return tuple(node for node in _kept(tree) if isinstance(node, ast.FunctionDef))


@cache
def calls(tree: ast.AST) -> tuple[ast.Call, ...]:
    """Every call, at any depth."""
    return tuple(node for node in _kept(tree) if isinstance(node, ast.Call))


@cache
def own_calls(function: ast.FunctionDef) -> tuple[ast.Call, ...]:
    """The calls of a function, without those of functions within it."""
    inner = {call for nested in functions(function) if nested is not function for call in calls(nested)}
    return tuple(call for call in calls(function) if call not in inner)


def called(call: ast.Call) -> str:
    """The last name of what is called: `say` of `self._events.say(…)`."""
    if isinstance(call.func, ast.Attribute):
        return call.func.attr
    return call.func.id if isinstance(call.func, ast.Name) else ""
