"""A module's source as mypyc gets it: the same statements, in the form that mypyc makes fast code of.

* A dataclass gets the `__init__` that it would get from `dataclass`, so that it is compiled. It loses `slots` and
  `frozen`, of which mypyc's own classes have the first and do not know the second; mypy has checked the second. Its
  other methods come from `companion/native_values.py`, since `dataclass` makes them of text at each start.
* A constant of a module becomes `Final`, else mypyc looks it up by its name each time.
* Statements and expressions get other forms (`forms.py`).
* A NamedTuple of `_VALUES` becomes a dataclass; who unpacks one nevertheless is found by mypy.
* A parameter named `_` gets another name, since mypyc gives no type to it.

* A class from which other packages inherit is told to allow that.

Lines move only after a dataclass's last one, and by such a class.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass

from sitl.native.edits import Edits
from sitl.native.forms import change_form, change_formats

_CONSTANT = re.compile(r"_*[A-Z][A-Z0-9_]*")
_FUTURE = "from __future__ import annotations"
_OPEN = ("StreamDriver",)  # from which drivers of other packages inherit, which are not compiled
_ATTRIBUTE = "@mypy_extensions.mypyc_attr(allow_interpreted_subclasses=True)\n"
_DECORATOR = "@dataclass(init=False, repr=False, eq=False)\n"
_GIVEN = "native_values.give"
_VALUES = (
    *("Place", "Offset", "PositionSeen", "VelocitySeen", "HeadingSeen", "ModelStep", "LaneStep", "InertialStep"),
)
"""NamedTuples that nobody takes for tuples: compiled, they are made and read without Python's objects."""
_NO_CONSTANTS = ("TypeVar", "ParamSpec", "NewType")


def prepared(text: str) -> str:
    """The source for mypyc. Raises ValueError where mypyc would not do what is written."""
    tree = ast.parse(text)
    edits = Edits(text)
    tail: list[str] = []
    done: set[ast.AST] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr) and node not in done:
            done |= change_formats(node, edits)
        if node not in done or isinstance(node, ast.Slice):
            tail += _statement(node, edits, node in tree.body)
    _imports(edits, _constants(tree, edits) > 0)
    return edits.done() + "".join(f"{line}\n" for line in tail)


def _statement(node: ast.AST, edits: Edits, outermost: bool) -> list[str]:
    """Change one node. Returns what the module's end gets."""
    if isinstance(node, ast.ClassDef):
        if node.name in _OPEN:
            edits.insert(edits.start(node), _ATTRIBUTE)
        if node.name in _VALUES and [ast.unparse(base) for base in node.bases] == ["NamedTuple"]:
            return _value(node, edits)
        return _dataclass(node, edits, outermost)
    if isinstance(node, ast.arg) and node.arg == "_":
        edits.insert(edits.start(node), "unused")
    else:
        change_form(node, edits)
    return []


def _imports(edits: Edits, final: bool) -> None:
    """Add the imports of what was inserted."""
    lines = ["; from typing import Final"] if final else []
    if any(new == _DECORATOR for _, _, new in edits.edits):
        lines += ["; from dataclasses import dataclass"]
    if any(_GIVEN in new for _, _, new in edits.edits):
        lines += ["; from companion import native_values"]
    if any(new == _ATTRIBUTE for _, _, new in edits.edits):
        lines += ["; from typing import TYPE_CHECKING\nif TYPE_CHECKING: import mypy_extensions"]
    if lines:
        edits.insert(edits.text.encode().index(_FUTURE.encode()) + len(_FUTURE), "".join(lines))


# --- constants -------------------------------------------------------------------------------------------------------


def _constants(tree: ast.Module, edits: Edits) -> int:
    """Make the constants of a module `Final`; how many."""
    changed = 0
    names = [name for statement in ast.walk(tree) for name in _bound(statement)]
    for statement in tree.body:
        targets = _targets(statement)
        if targets and all(_CONSTANT.fullmatch(name) and names.count(name) == 1 for name in targets):
            changed += _finalise(statement, edits)
    return changed


def _bound(node: ast.AST) -> Iterator[str]:
    if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
        yield node.id
    elif isinstance(node, ast.Global):
        yield from node.names


def _targets(statement: ast.stmt) -> list[str]:
    if isinstance(statement, ast.AnnAssign) and statement.value is not None:
        return [ast.unparse(statement.target)]
    if not isinstance(statement, ast.Assign) or len(statement.targets) != 1:
        return []
    target = statement.targets[0]
    parts = target.elts if isinstance(target, ast.Tuple) else [target]
    return [ast.unparse(part) for part in parts]


def _finalise(statement: ast.stmt, edits: Edits) -> bool:
    if isinstance(statement, ast.AnnAssign):
        if "TypeAlias" in ast.unparse(statement.annotation):
            return False
        edits.insert(edits.start(statement.annotation), "Final[")
        edits.insert(edits.end(statement.annotation), "]")
        return True
    assert isinstance(statement, ast.Assign)
    target, value = statement.targets[0], statement.value
    if isinstance(target, ast.Tuple):
        if not isinstance(value, ast.Tuple) or len(value.elts) != len(target.elts):
            return False
        pairs = zip(target.elts, value.elts, strict=True)
        text = "; ".join(f"{ast.unparse(name)}: Final = {ast.unparse(part)}" for name, part in pairs)
        edits.replace(edits.start(statement), edits.end(statement), text)
        return True
    if isinstance(value, ast.Call) and ast.unparse(value.func) in _NO_CONSTANTS:
        return False
    edits.insert(edits.end(target), ": Final")
    return True


# --- dataclasses -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Field:
    name: str
    annotation: str
    default: str | None
    plain: bool


def _dataclass(node: ast.ClassDef, edits: Edits, outermost: bool) -> list[str]:
    """Change a dataclass. Returns what the module's end gets: its annotations as they are written, which mypyc
    simplifies."""
    decorator = next((item for item in node.decorator_list if _is_dataclass(item)), None)
    if decorator is None:
        return []
    if any(ast.unparse(base).startswith("Generic[") for base in node.bases):
        raise ValueError(f"line {node.lineno}: a generic dataclass, which cannot be imported once compiled")
    methods = {statement.name for statement in node.body if isinstance(statement, ast.FunctionDef)}
    fields = [found for statement in node.body if (found := _field(statement)) is not None]
    own = not node.bases and not methods & {"__init__", "__post_init__"}
    options, after = _options(decorator, methods), ""
    if own and fields and all(item.plain for item in fields):
        after = _init(node, fields)
        options["init"] = "False"  # else `dataclass` would compile one at import, and leave it
    if outermost and "order" not in options:
        after += _given(node, _taken(options, methods))
    edits.insert(edits.end(node), after)
    written = ", ".join(f"{name}={value}" for name, value in options.items())
    edits.replace(edits.start(decorator), edits.end(decorator), f"dataclass({written})")
    annotations = {item.name: item.annotation for item in fields}
    return [f"setattr({node.name}, '__annotations__', {annotations!r})"] if outermost and fields else []


def _value(node: ast.ClassDef, edits: Edits) -> list[str]:
    """Make a NamedTuple a dataclass."""
    edits.insert(edits.start(node), _DECORATOR)
    base = node.bases[0]
    edits.replace(edits.start(base) - 1, edits.end(base) + 1, "")
    fields = [found for statement in node.body if (found := _field(statement)) is not None]
    edits.insert(edits.end(node), _init(node, fields) + _given(node, ("repr", "eq", "hash")))
    return []


def _taken(options: dict[str, str], methods: Container[str]) -> list[str]:
    """The methods that the options ask for; the options ask for them no longer."""
    described, compared = options.get("repr") != "False", options.get("eq") != "False"
    taken = ["repr"] if described and "__repr__" not in methods else []
    taken += ["eq"] if compared and "__eq__" not in methods else []
    if options.pop("unsafe_hash", "False") == "True":
        taken += ["hash"]
    elif compared and "__hash__" not in methods:
        taken += ["no hash"]
    options |= {"repr": "False", "eq": "False"}
    return taken


def _given(node: ast.ClassDef, methods: Sequence[str]) -> str:
    names = "".join(f', "{name}"' for name in methods)
    return f"\n{_GIVEN}({node.name}{names})" if methods else ""


def _is_dataclass(node: ast.expr) -> bool:
    return ast.unparse(node.func if isinstance(node, ast.Call) else node) == "dataclass"


def _options(decorator: ast.expr, methods: Container[str]) -> dict[str, str]:
    given = decorator.keywords if isinstance(decorator, ast.Call) else []
    options = {item.arg or "": ast.unparse(item.value) for item in given}
    if options.pop("frozen", "False") == "True" and "eq" not in options and "__hash__" not in methods:
        options["unsafe_hash"] = "True"
    options.pop("slots", None)
    return options


def _field(statement: ast.stmt) -> _Field | None:
    if not isinstance(statement, ast.AnnAssign) or not isinstance(statement.target, ast.Name):
        return None
    annotation, value = ast.unparse(statement.annotation), statement.value
    if annotation.startswith("ClassVar"):
        raise ValueError(f"line {statement.lineno}: a ClassVar in a dataclass, which mypyc takes for a field")
    if isinstance(value, ast.Call) and ast.unparse(value.func) == "field":
        given = {item.arg: ast.unparse(item.value) for item in value.keywords}
        return _Field(statement.target.id, annotation, given.get("default"), set(given) == {"default"})
    return _Field(statement.target.id, annotation, None if value is None else ast.unparse(value), True)


def _init(node: ast.ClassDef, fields: list[_Field]) -> str:
    given = (f"{item.name}: {item.annotation}" + (f" = {item.default}" if item.default else "") for item in fields)
    kept = "; ".join(f"self.{item.name} = {item.name}" for item in fields)
    return f"\n{' ' * node.body[0].col_offset}def __init__(self, {', '.join(given)}) -> None: {kept}"
