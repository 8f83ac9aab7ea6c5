"""What a string expression can become: its texts, with a place in braces where a value is filled in."""

from __future__ import annotations

import ast
import itertools
import re
from collections.abc import Iterable, Mapping, Sequence

_MOST = 16  # alternatives of one expression
_MARK = "\x00{}\x00"
_MARKED = re.compile("\x00(\\w+)\x00")


def templates(expression: ast.expr, function: ast.FunctionDef | None) -> list[str]:
    """Every text that `expression` can be within `function`. A parameter of the function stands as a mark (`marks`)."""
    found = [text for text in _texts(expression, function, frozenset()) if text]
    return list(dict.fromkeys(found))[:_MOST] or [""]


def marks(text: str) -> set[str]:
    """The parameters that a template depends on."""
    return set(_MARKED.findall(text))


def filled(text: str, values: Mapping[str, Sequence[str]]) -> list[str]:
    """`text` with its marks replaced by every combination of values."""
    names = [name for name in sorted(marks(text)) if name in values]
    found = []
    for combination in itertools.islice(itertools.product(*(values[name] for name in names)), _MOST):
        done = text
        for name, value in zip(names, combination, strict=True):
            done = done.replace(_MARK.format(name), value)
        found.append(done)
    return found


def plain(text: str) -> str:
    """`text` with marks shown as places."""
    return _MARKED.sub(lambda found: f"{{{found[1]}}}", text)


def _texts(node: ast.expr, function: ast.FunctionDef | None, seen: frozenset[str]) -> list[str]:
    match node:
        case ast.Constant(value=str(text)):
            return [text]
        case ast.JoinedStr(values=parts):
            return _joined([_texts(part, function, seen) for part in parts])
        case ast.FormattedValue(value=value):
            return _texts(value, function, seen)
        case ast.IfExp(body=body, orelse=orelse):
            return _texts(body, function, seen) + _texts(orelse, function, seen)
        case ast.BinOp(op=ast.Add(), left=left, right=right):
            return _joined([_texts(left, function, seen), _texts(right, function, seen)])
        case ast.BoolOp(op=ast.Or(), values=values):
            return [text for value in values for text in _texts(value, function, seen)]
        case ast.Name(id=name) if function is not None and name not in seen:
            return _named(name, function, seen | {name})
    return [f"{{{_short(node)}}}"]


def _joined(parts: Iterable[list[str]]) -> list[str]:
    return ["".join(combination) for combination in itertools.islice(itertools.product(*parts), _MOST)]


def _named(name: str, function: ast.FunctionDef, seen: frozenset[str]) -> list[str]:
    """What was assigned to a local name, or the mark of a parameter."""
    if name in parameters(function):
        return [_MARK.format(name)]
    values = [value for value in assigned(name, function) if _is_text(value)]
    return [text for value in values for text in _texts(value, function, seen)] or [f"{{{name}}}"]


def assigned(name: str, function: ast.FunctionDef) -> list[ast.expr]:
    """What is assigned to a local name, also as one of several: `a, b = (1, 2) if c else (3, 4)`."""
    return [
        value
        for node in ast.walk(function)
        if isinstance(node, (ast.Assign, ast.NamedExpr))
        for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
        for value in _given_to(name, target, node.value)
    ]


def _given_to(name: str, target: ast.expr, value: ast.expr) -> list[ast.expr]:
    match target, value:
        case ast.Name(id=found), _ if found == name:
            return [value]
        case ast.Tuple(), ast.IfExp(body=body, orelse=orelse):
            return _given_to(name, target, body) + _given_to(name, target, orelse)
        case ast.Tuple(elts=targets), ast.Tuple(elts=values):
            pairs = zip(targets, values, strict=False)
            return [found for one, other in pairs for found in _given_to(name, one, other)]
    return []


def _is_text(node: ast.expr) -> bool:
    """Whether an assigned value is text that can be shown, not a number or the result of a call."""
    if isinstance(node, ast.IfExp):
        return _is_text(node.body) or _is_text(node.orelse)
    if isinstance(node, ast.BinOp):
        return _is_text(node.left) or _is_text(node.right)
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str))


def parameters(function: ast.FunctionDef) -> list[str]:
    """Names of a function's parameters, without `self`."""
    arguments = function.args
    return [a.arg for a in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs) if a.arg != "self"]


def bound(call: ast.Call, function: ast.FunctionDef) -> dict[str, ast.expr]:
    """What a call gives for each parameter of a function; defaults where it gives nothing."""
    names = parameters(function)
    defaults = function.args.defaults
    given: dict[str, ast.expr] = dict(zip(names[len(names) - len(defaults) :], defaults, strict=False))
    given |= dict(zip(names, call.args, strict=False))
    return given | {keyword.arg: keyword.value for keyword in call.keywords if keyword.arg is not None}


_CARRIERS = frozenset(
    {"join", "str", "self", "for", "in", "if", "else", "value", "id", "upper", "lower", "sorted", "math", "degrees"}
)


def _short(node: ast.expr) -> str:
    """A name for the value of an expression: what is called, else its last identifier."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "join":
        return _short(node.args[0])
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id not in _CARRIERS:
        return node.func.id.strip("_")
    words = [word.strip("_") for word in re.findall(r"[A-Za-z_]\w*", ast.unparse(node))]
    useful = [word for word in words if word and word not in _CARRIERS]
    return useful[-1] if useful else "value"
