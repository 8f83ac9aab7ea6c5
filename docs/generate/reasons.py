"""Reasons of refusals, which stand within other texts: what functions return that tell why something cannot be done."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass

from docs.generate.source import Module, called, calls, functions, modules
from docs.generate.templates import plain, templates
from docs.generate.text_lengths import PLACES

_ROOMS = ("fence", "following", "guidance", "mission", "modes", "supervisor")
_PLAN_FILES = ("mission/validation.py", "io/mavlink/transfer/mission_codec.py", "io/mavlink/transfer/mission_upload.py")
_PLAN_CALLS = frozenset({"PlanRefusal", "_refuse", "_no_output"})


@dataclass(frozen=True, slots=True, order=True)
class Reason:
    """One reason, and the file that gives it."""

    text: str
    place: str


def reasons() -> list[Reason]:
    """Why something cannot be done: the texts that functions with the result `str | None` return, and the rules of
    authority."""
    rooms = tuple(f"companion/{room}/" for room in _ROOMS)
    found = {reason for module in modules("companion") if module.place.startswith(rooms) for reason in _given(module)}
    return sorted(found)


def plan_reasons() -> list[Reason]:
    """Why a plan is refused."""
    places = tuple(f"companion/{place}" for place in _PLAN_FILES)
    return sorted({reason for module in modules("companion") if module.place in places for reason in _refused(module)})


def _given(module: Module) -> Iterator[Reason]:
    for function in functions(module.tree):
        if function.returns is None or ast.unparse(function.returns) != "str | None":
            continue
        for node in ast.walk(function):
            if isinstance(node, ast.Return) and node.value is not None:
                yield from _reasons(node.value, function, module)
    for call in calls(module.tree):
        if called(call) == "RefusalRule" and len(call.args) == 6 and isinstance(call.args[4], ast.Lambda):
            yield from _reasons(call.args[4].body, None, module)


def _refused(module: Module) -> Iterator[Reason]:
    for function in functions(module.tree):
        for call in calls(function):
            if called(call) in _PLAN_CALLS and function.name not in _PLAN_CALLS:
                for argument in call.args[1:]:
                    if not isinstance(argument, ast.Attribute | ast.Subscript):
                        yield from _reasons(argument, function, module)


def _reasons(node: ast.expr, function: ast.FunctionDef | None, module: Module) -> Iterator[Reason]:
    for text in templates(node, function):
        if any(letter.isalpha() for letter in PLACES.sub("", plain(text))):
            yield Reason(plain(text), module.place)
