"""statustexts.md: every text that the boat can send, found in the source where it is sent."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache

from companion.core.decision import TextKind
from docs.generate.markdown import code, page, section, table
from docs.generate.reasons import Reason, plan_reasons, reasons
from docs.generate.source import Module, called, calls, functions, modules, own_calls
from docs.generate.templates import assigned, bound, filled, marks, parameters, plain, templates
from docs.generate.text_lengths import CHUNK, PLACES, WHY_LONG, usual_length

_INTRODUCTION = """All texts that the boat sends as STATUSTEXT, in alphabetical order. `events.csv` also has the name. A
text without a name goes only to the ground station that asked, and is in no log of events.

A word in braces stands for a value, such as `{name}`. The length is that of the text with usual values; a text longer
than 50 characters comes in several STATUSTEXT messages, which ground stations put together. The same text under the
same name comes once in 10 s."""

_KINDS = """Each text has a kind, from which its severity follows. QGroundControl opens a window for ERROR and
worse, keeps WARNING and INFO in its list, and speaks NOTICE and worse."""

_LONG = """Each of these needs its length: it says who, what and how much."""

_REASONS = """What stands for `{reason}`, `{refusal}`, `{found}`, `{fault}` and the like in the texts above."""

_PLANS = """What follows `mission item 12` and the like where an upload is refused; `companion mission` prints the same.
These texts come in two or three messages: they name the command, its field, the value and what it should be."""

_PASSED_ON = """Places that send a text which is made elsewhere: a reason, a fault of a link or
of storage."""

_SAYS = frozenset({"say", "_say"})
_ANSWERS = {"denied": TextKind.REFUSAL, "not_now": TextKind.REFUSAL, "unread": TextKind.HINT}
_DEEPEST = 3
_DEPENDS = "as the case is"
_HEADERS = ("severity", "kind", "name", "sent by")


@dataclass(frozen=True, slots=True, order=True)
class Said:
    """One text, where it comes from, its kind and its name in the log; empty for a text that no log of events
    has."""

    text: str
    kind: str
    name: str
    place: str

    @property
    def length(self) -> int:
        """Characters of the text, with usual values in its places."""
        return usual_length(self.text)


def statustexts() -> str:
    """The page."""
    said = sorted(set(all_texts()), key=lambda one: (one.text.lower(), one.name, one.place, one))
    passed_on = [one for one in said if not _has_words(one.text)]
    texts = [one for one in said if one not in passed_on]
    kinds = ((code(kind.name), kind.severity.name, str(int(kind.severity)), kind.meaning) for kind in TextKind)
    return page(
        "Texts of the boat",
        _INTRODUCTION,
        section(2, "Kinds", _KINDS, table(("kind", "severity", "number", "it says"), kinds)),
        section(2, "Texts", table(("text", "length", *_HEADERS), (_row(one) for one in texts))),
        section(2, "Longer than 50 characters", _LONG, table(("text", "length", "why"), _long_rows(texts))),
        section(2, "Reasons", _REASONS, table(("reason", "length", "given by"), map(_reason_row, reasons()))),
        section(
            2, "Refusals of a plan", _PLANS, table(("reason", "length", "given by"), map(_reason_row, plan_reasons()))
        ),
        section(2, "Passed on", _PASSED_ON, table(_HEADERS, dict.fromkeys(_row(one)[2:] for one in passed_on))),
    )


def _has_words(text: str) -> bool:
    """Whether a text says anything beside the values that are filled in."""
    return any(letter.isalpha() for letter in PLACES.sub("", text))


def _long_rows(texts: Sequence[Said]) -> Iterator[tuple[str, ...]]:
    long = {one.text: one.length for one in texts if one.length > CHUNK}
    return ((code(text), str(length), WHY_LONG.get(text, "")) for text, length in long.items())


def _reason_row(reason: Reason) -> tuple[str, ...]:
    return code(reason.text), str(usual_length(reason.text)), code(reason.place)


def _row(said: Said) -> tuple[str, ...]:
    return code(said.text), str(said.length), severity(said), said.kind, code(said.name), code(said.place)


def severity(said: Said) -> str:
    """The severity of a text's kind, or of each of its kinds."""
    kinds = [TextKind[name].severity.name for name in said.kind.split(" or ") if name in TextKind.__members__]
    return " or ".join(dict.fromkeys(kinds))


@cache
def all_texts() -> tuple[Said, ...]:
    """Every text of every module."""
    return tuple(said for module in modules("companion") for said in _texts_of(module))


def _texts_of(module: Module) -> Iterator[Said]:
    for function in functions(module.tree):
        for call in own_calls(function):
            if is_say(call, module):
                yield from _expanded(_spoken(call, function), function, module, 0)
            elif called(call) in _ANSWERS and call.args:
                texts = [text for text in templates(call.args[0], function) if text]
                yield from (Said(plain(text), _ANSWERS[called(call)].name, "", module.place) for text in texts)
    yield from _failsafes(module)
    yield from _arming(module)


def is_say(call: ast.Call, module: Module) -> bool:
    """Whether this call sends a text, and not by way of a function of the same module that does (`_expanded` finds
    those)."""
    if called(call) not in _SAYS or not any(_kinds(argument) for argument in call.args):
        return False
    same = [function for function in functions(module.tree) if function.name == called(call)]
    return not any(called(inner) in _SAYS and inner is not call for function in same for inner in own_calls(function))


def _kinds(node: ast.expr) -> bool:
    """Whether an argument is a kind."""
    match node:
        case ast.Attribute(value=ast.Name(id="TextKind")) | ast.Name(id="kind") | ast.Attribute(attr="kind"):
            return True
        case ast.IfExp(body=body):
            return _kinds(body)
    return False


def _kind_texts(node: ast.expr, function: ast.FunctionDef) -> list[str]:
    match node:
        case ast.Attribute(value=ast.Name(id="TextKind"), attr=name):
            return [name]
        case ast.IfExp(body=body, orelse=orelse):
            return [" or ".join(dict.fromkeys(_kind_texts(body, function) + _kind_texts(orelse, function)))]
        case ast.Name(id=name) if name not in parameters(function):
            given = [text for value in assigned(name, function) for text in _kind_texts(value, function)]
            return [" or ".join(dict.fromkeys(given))]
        case ast.Attribute(attr="kind"):
            return [_DEPENDS]
    return templates(node, function)


def _spoken(call: ast.Call, function: ast.FunctionDef) -> list[Said]:
    """The texts of one call, with marks for what the function is given."""
    place = next(i for i, argument in enumerate(call.args) if _kinds(argument))
    rest = call.args[place + 1 :]
    names = templates(rest[0], function) if len(rest) > 1 else [""]
    kinds = _kind_texts(call.args[place], function)
    texts = templates(rest[-1], function)
    return [Said(text, kind, name, "") for text in texts for kind in kinds for name in names]


def _expanded(said: list[Said], function: ast.FunctionDef, module: Module, depth: int) -> Iterator[Said]:
    """What depends on the function's parameters, as its callers in the module give them."""
    open_ = [one for one in said if marks(one.text + one.kind + one.name)]
    callers = [
        (caller, call)
        for caller in functions(module.tree)
        for call in own_calls(caller)
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
    return _kind_texts(value, caller) if _kinds(value) else templates(value, caller)


def _with(said: Said, given: dict[str, list[str]]) -> list[Said]:
    return [
        Said(text, kind, name, said.place)
        for text in filled(said.text, given)
        for kind in filled(said.kind, given)
        for name in filled(said.name, given)
    ]


def _closed(said: Said, module: Module) -> Said:
    return Said(plain(said.text), plain(said.kind).strip("{}"), plain(said.name), module.place)


def _failsafes(module: Module) -> Iterator[Said]:
    """What a failsafe announces when it begins and when it ends, from the rows of the table."""
    for call in calls(module.tree):
        if called(call) != "Failsafe" or len(call.args) < 7:
            continue
        name, kind, starts, ends = call.args[0], call.args[1], call.args[5], call.args[6]
        kind_name = kind.attr if isinstance(kind, ast.Attribute) and kind.attr in TextKind.__members__ else _DEPENDS
        for text in _lambda_texts(starts, module):
            yield Said(plain(text), kind_name, templates(name, None)[0], module.place)
        yield Said(templates(ends, None)[0], TextKind.ROUTINE.name, f"{templates(name, None)[0]}_over", module.place)


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
            if isinstance(node, ast.Yield) and isinstance(node.value, ast.Call):
                for text in templates(node.value.args[1], function):
                    yield Said(f"PreArm: {plain(text)}", TextKind.ATTENTION.name, "arming_refused", module.place)


def _is_check(function: ast.FunctionDef) -> bool:
    """`(s: Situation) -> Iterator[ArmingFinding]`."""
    if [taken.arg for taken in function.args.args] != ["s"] or function.returns is None:
        return False
    takes = ast.unparse(function.args) == "s: Situation"
    return takes and "Iterator[ArmingFinding]" in ast.unparse(function.returns)
