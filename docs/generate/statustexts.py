"""statustexts.md: every text that the boat can send, found in the source where it is sent."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass

from companion.core.decision import Severity
from docs.generate.markdown import code, page, section, table
from docs.generate.source import Module, called, calls, functions, modules
from docs.generate.templates import bound, filled, marks, parameters, plain, templates

_INTRODUCTION = """What the boat announces, sorted by its first words. A ground station shows the text; `events.csv`
has its name besides.

A word in braces stands for a value, such as `{name}`. A text longer than 50 characters comes in several STATUSTEXT
messages, which ground
stations put together. The same text under the same name comes once in 10 s."""

_REFUSED = """Texts for the ground station whose command was refused, with the reason. No log of events has them."""

_PASSED_ON = """Places that send a text which is made elsewhere: a reason from the list above, a fault of a link or
of storage."""

_SAYS = frozenset({"say", "_say"})
_ANSWERS = frozenset({"denied", "not_now"})
_DEEPEST = 3
_PLACES = re.compile(r"\{[^}]*\}")


@dataclass(frozen=True, slots=True, order=True)
class Said:
    """One text, where it comes from, its severity and its name in the log; empty for a text that no log of events
    has."""

    text: str
    severity: str
    name: str
    place: str


def statustexts() -> str:
    """The page."""
    said = sorted(set(all_texts()), key=lambda one: (one.text.lower(), one.name, one.place))
    passed_on = [one for one in said if not _has_words(one.text)]
    announced = [one for one in said if one.name and one not in passed_on]
    answered = [one for one in said if not one.name and one not in passed_on]
    meaning = table(("severity", "number"), ((code(severity.name), str(int(severity))) for severity in Severity))
    return page(
        "Texts of the boat",
        _INTRODUCTION,
        section(2, "Announced", table(("text", "severity", "name", "sent by"), (_row(one) for one in announced))),
        section(
            2,
            "Answers to one ground station",
            _REFUSED,
            table(("text", "severity", "sent by"), (_answer_row(one) for one in answered)),
        ),
        section(
            2, "Passed on", _PASSED_ON, table(("severity", "name", "sent by"), (_row(one)[1:] for one in passed_on))
        ),
        section(2, "Severities", "The numbers are MAVLink's MAV_SEVERITY.", meaning),
    )


def _has_words(text: str) -> bool:
    """Whether a text says anything beside the values that are filled in."""
    return any(letter.isalpha() for letter in _PLACES.sub("", text))


def _row(said: Said) -> tuple[str, ...]:
    return code(said.text), said.severity, code(said.name), code(said.place)


def _answer_row(said: Said) -> tuple[str, ...]:
    return code(said.text), said.severity, code(said.place)


def all_texts() -> Iterator[Said]:
    """Every text of every module."""
    for module in modules("companion"):
        for function in functions(module.tree):
            for call in _own_calls(function):
                if is_say(call, module):
                    yield from _expanded(_spoken(call, function), function, module, 0)
                elif called(call) in _ANSWERS and call.args:
                    texts = [text for text in templates(call.args[0], function) if text]
                    yield from (Said(plain(text), Severity.WARNING.name, "", module.place) for text in texts)
        yield from _failsafes(module)
        yield from _arming(module)


def is_say(call: ast.Call, module: Module) -> bool:
    """Whether this call sends a text, and not by way of a function of the same module that does (`_expanded` finds
    those)."""
    if called(call) not in _SAYS or not any(_severities(argument) for argument in call.args):
        return False
    same = [function for function in functions(module.tree) if function.name == called(call)]
    return not any(called(inner) in _SAYS and inner is not call for function in same for inner in _own_calls(function))


def _own_calls(function: ast.FunctionDef) -> Iterator[ast.Call]:
    """The calls of a function, without those of functions within it."""
    inner = {id(call) for nested in functions(function) if nested is not function for call in calls(nested)}
    return (call for call in calls(function) if id(call) not in inner)


def _severities(node: ast.expr) -> bool:
    """Whether an argument is a severity."""
    match node:
        case ast.Attribute(value=ast.Name(id="Severity")) | ast.Name(id="severity") | ast.Attribute(attr="severity"):
            return True
        case ast.IfExp(body=body):
            return _severities(body)
    return False


def _severity_texts(node: ast.expr, function: ast.FunctionDef) -> list[str]:
    match node:
        case ast.Attribute(value=ast.Name(id="Severity"), attr=name):
            return [name]
        case ast.IfExp(body=body, orelse=orelse):
            return [" or ".join(dict.fromkeys(_severity_texts(body, function) + _severity_texts(orelse, function)))]
        case ast.Name(id=name) if name not in parameters(function):
            return ["as the case is"]
    return templates(node, function)


def _spoken(call: ast.Call, function: ast.FunctionDef) -> list[Said]:
    """The texts of one call, with marks for what the function is given."""
    place = next(i for i, argument in enumerate(call.args) if _severities(argument))
    rest = call.args[place + 1 :]
    names = templates(rest[0], function) if len(rest) > 1 else [""]
    severities = _severity_texts(call.args[place], function)
    texts = templates(rest[-1], function)
    return [Said(text, severity, name, "") for text in texts for severity in severities for name in names]


def _expanded(said: list[Said], function: ast.FunctionDef, module: Module, depth: int) -> Iterator[Said]:
    """What depends on the function's parameters, as its callers in the module give them."""
    open_ = [one for one in said if marks(one.text + one.severity + one.name)]
    callers = [
        (caller, call)
        for caller in functions(module.tree)
        for call in _own_calls(caller)
        if called(call) == function.name and caller is not function
    ]
    if not open_ or not callers or depth >= _DEEPEST:
        yield from (_closed(one, module) for one in said)
        return
    yield from (_closed(one, module) for one in said if one not in open_)
    for caller, call in callers:
        given = {name: _given(value, caller) for name, value in bound(call, function).items()}
        yield from _expanded([new for one in open_ for new in _with(one, given)], caller, module, depth + 1)


def _given(value: ast.expr, caller: ast.FunctionDef) -> list[str]:
    return _severity_texts(value, caller) if _severities(value) else templates(value, caller)


def _with(said: Said, given: dict[str, list[str]]) -> list[Said]:
    return [
        Said(text, severity, name, said.place)
        for text in filled(said.text, given)
        for severity in filled(said.severity, given)
        for name in filled(said.name, given)
    ]


def _closed(said: Said, module: Module) -> Said:
    return Said(plain(said.text), plain(said.severity).strip("{}"), plain(said.name), module.place)


def _failsafes(module: Module) -> Iterator[Said]:
    """What a failsafe announces when it begins and when it ends, from the rows of the table."""
    for call in calls(module.tree):
        if called(call) != "Failsafe" or len(call.args) < 7:
            continue
        name, severity, starts, ends = call.args[0], call.args[1], call.args[5], call.args[6]
        severity_name = severity.attr if isinstance(severity, ast.Attribute) else ""
        for text in _lambda_texts(starts, module):
            yield Said(plain(text), severity_name, templates(name, None)[0], module.place)
        yield Said(templates(ends, None)[0], Severity.NOTICE.name, f"{templates(name, None)[0]}_over", module.place)


def _lambda_texts(node: ast.expr, module: Module) -> list[str]:
    """The texts of a lambda, or of the function of the module that is named."""
    if isinstance(node, ast.Lambda):
        return templates(node.body, None)
    named = [function for function in functions(module.tree) if isinstance(node, ast.Name) and function.name == node.id]
    returned = [
        inner.value
        for function in named
        for inner in ast.walk(function)
        if isinstance(inner, ast.Return) and inner.value is not None
    ]
    return [text for value in returned for text in templates(value, named[0])] or ["{text}"]


def _arming(module: Module) -> Iterator[Said]:
    """Why the boat does not arm: what the checks of arming yield."""
    for function in functions(module.tree):
        if not _is_check(function):
            continue
        for node in ast.walk(function):
            if isinstance(node, ast.Yield) and node.value is not None:
                for text in templates(node.value, function):
                    yield Said(f"PreArm: {plain(text)}", Severity.WARNING.name, "arming_refused", module.place)


def _is_check(function: ast.FunctionDef) -> bool:
    """`(s: Situation) -> Iterator[str]`."""
    takes = ast.unparse(function.args).endswith(": Situation")
    return takes and function.returns is not None and "Iterator[str]" in ast.unparse(function.returns)
