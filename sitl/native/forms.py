"""Statements and expressions in the form of which mypyc makes fast code, with the same result:

* `sum` gets a list: mypyc would add a generator's values in a loop of its own, without the compensation of Python 3.12.
* A loop over `zip` loses `strict`, and `min` and `max` of several become those of two each: forms of which mypyc makes
  loops and comparisons of its own.
* `isinstance(x, A | B)` gets a tuple, of which mypyc makes two comparisons of types.
* `(a, b), (c, d) = x, y` becomes one assignment each: mypyc would make objects of all the numbers.
* A format in an f-string becomes a call of `format`, which `operations.py` knows.
"""

from __future__ import annotations

import ast
import copy
from collections.abc import Iterator

from sitl.native.edits import Edits

_PURE = {"int", "len", "max", "min", "round"}


def change_form(node: ast.AST, edits: Edits) -> None:
    """Change one node. Raises ValueError where mypyc would not do what is written."""
    if isinstance(node, ast.Call):
        _refuse_bare(node)
        _sum(node, edits)
        _kinds(node, edits)
        _extreme(node, edits)
    elif isinstance(node, ast.Assign):
        _nested(node, edits)
    elif isinstance(node, ast.For | ast.comprehension):
        _zip(node.iter, edits)
    elif isinstance(node, ast.Slice):
        _refuse_effects(node)
    elif isinstance(node, ast.FunctionDef):
        _refuse_empty(node)


def _refuse_effects(node: ast.Slice) -> None:
    """mypyc 2.4 does the bounds of a slice twice."""
    calls = {ast.unparse(part.func) for part in ast.walk(node) if isinstance(part, ast.Call)}
    if (not calls <= _PURE) or any(isinstance(part, ast.NamedExpr) for part in ast.walk(node)):
        raise ValueError(f"line {node.lineno}: a call in the bounds of a slice, which mypyc does twice")


def _refuse_bare(call: ast.Call) -> None:
    """mypyc's classes call `__init__` in `__new__`, so there is no object without it."""
    if isinstance(call.func, ast.Attribute) and call.func.attr == "__new__":
        raise ValueError(f"line {call.lineno}: an object made by __new__, for which mypyc calls __init__")


def _refuse_empty(function: ast.FunctionDef) -> None:
    """A name whose first value is `()` has the type of the empty tuple in mypyc, and no other tuple goes into it."""
    known = {argument.arg for argument in (*function.args.args, *function.args.kwonlyargs)}
    statements = [node for node in ast.walk(function) if isinstance(node, ast.Assign | ast.AnnAssign)]
    for statement in sorted(statements, key=lambda each: each.lineno):
        targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
        value = statement.value if isinstance(statement, ast.Assign) else None  # an annotated name has its type
        for name, begins in [bound for target in targets for bound in _bound(target, value)]:
            if name not in known and isinstance(begins, ast.Tuple) and not begins.elts:
                raise ValueError(f"line {statement.lineno}: {name} begins as (), whose type mypyc keeps: annotate it")
            known.add(name)


def _bound(target: ast.expr, value: ast.expr | None) -> Iterator[tuple[str, ast.expr | None]]:
    """Each name that an assignment binds, with the value that is written beside it."""
    if isinstance(target, ast.Name):
        yield target.id, value
    elif isinstance(target, ast.Tuple):
        beside = value.elts if isinstance(value, ast.Tuple) else [None] * len(target.elts)
        for part, own in zip(target.elts, beside, strict=False):
            yield from _bound(part, own)


def _sum(call: ast.Call, edits: Edits) -> None:
    if isinstance(call.func, ast.Name) and call.func.id == "sum" and isinstance(call.args[0], ast.GeneratorExp):
        start, end = edits.start(call.args[0]), edits.end(call.args[0])  # with its parentheses
        edits.replace(start, start + 1, "([")
        edits.replace(end - 1, end, "])")


def _kinds(call: ast.Call, edits: Edits) -> None:
    if not isinstance(call.func, ast.Name) or call.func.id != "isinstance" or not isinstance(call.args[1], ast.BinOp):
        return
    kinds = ast.unparse(call.args[1]).split(" | ")
    if "None" in kinds:
        return  # which stands for its type only in such a union
    edits.replace(edits.start(call.args[1]), edits.end(call.args[1]), f"({', '.join(kinds)})")


def _extreme(call: ast.Call, edits: Edits) -> None:
    """`max(a, b, c)` as `max(max(a, b), c)`, which compares the same pairs."""
    if not isinstance(call.func, ast.Name) or call.func.id not in ("min", "max") or call.keywords:
        return
    if len(call.args) > 2 and not any(isinstance(given, ast.Starred) for given in call.args):
        edits.insert(edits.start(call.args[0]), f"{call.func.id}(" * (len(call.args) - 2))
        for given in call.args[1:-1]:
            edits.insert(edits.end(given), ")")


def _zip(call: ast.expr, edits: Edits) -> None:
    if not isinstance(call, ast.Call) or not isinstance(call.func, ast.Name) or call.func.id != "zip":
        return
    if len(call.args) > 1 and call.keywords and not any(isinstance(given, ast.Starred) for given in call.args):
        edits.replace(edits.end(call.args[-1]), edits.end(call) - 1, "")


def _nested(node: ast.Assign, edits: Edits) -> None:
    """One assignment for each part of tuples in a tuple; all values come first, as before."""
    target, value = node.targets[0], node.value
    if len(node.targets) > 1 or not isinstance(target, ast.Tuple) or not isinstance(value, ast.Tuple):
        return
    parts, values, text = target.elts, value.elts, edits.text.encode()
    if len(parts) != len(values) or not any(isinstance(part, ast.Tuple) for part in parts):
        return
    starts, ends = [edits.start(one) for one in values], [edits.end(one) for one in values]
    between = [text[end:start] for end, start in zip(ends, starts[1:], strict=False)]
    if any(isinstance(one, ast.Constant | ast.List | ast.Dict | ast.Set) for one in values):
        return  # a name for it would have no type
    if any(gap.strip() != b"," for gap in between) or ends[-1] != edits.end(node) or starts[0] != edits.start(value):
        return
    names = [f"value_{node.lineno}_{n}" for n in range(len(parts))]
    edits.replace(edits.start(node), starts[0], f"{names[0]} = ")
    for end, start, name in zip(ends, starts[1:], names[1:], strict=False):
        edits.replace(end, start, f"; {name} = ")
    edits.insert(ends[-1], "".join(f"; {ast.unparse(part)} = {name}" for part, name in zip(parts, names, strict=True)))


class _Formats(ast.NodeTransformer):
    """`{x:.3f}` as `{format(x, '.3f')}`. `count`: how many."""

    def __init__(self) -> None:
        self.count = 0

    def visit_FormattedValue(self, node: ast.FormattedValue) -> ast.FormattedValue:
        """As `ast.NodeTransformer`."""
        self.generic_visit(node)
        form = node.format_spec
        if node.conversion != -1 or not isinstance(form, ast.JoinedStr) or not form.values:
            return node
        self.count += 1
        constant = len(form.values) == 1 and isinstance(form.values[0], ast.Constant)
        call = ast.Call(ast.Name("format", ast.Load()), [node.value, form.values[0] if constant else form], [])
        return ast.FormattedValue(call, -1, None)


def change_formats(string: ast.JoinedStr, edits: Edits) -> set[ast.AST]:
    """Change the formats of an f-string. Returns the nodes that this replaces."""
    inner = set(ast.walk(string))
    formats = _Formats()
    changed = formats.visit(copy.deepcopy(string))
    start, end = edits.start(string), edits.end(string)
    lines = (string.end_lineno or string.lineno) - string.lineno
    if formats.count and b'"""' not in edits.text.encode()[start:end]:
        edits.replace(start, end, ast.unparse(changed) + "\n" * lines)
        return inner
    return set()
