"""A module as mypyc gets it says the same as before."""

from __future__ import annotations

import ast
import dataclasses
import re
from pathlib import Path
from typing import Any

import pytest

from sitl.native.modules import compiled, known
from sitl.native.source import prepared

ROOT = Path(__file__).parents[3]

MODULE = '''"""A module."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NamedTuple

_GAP_S = 0.5
LOW, HIGH = 1.0, 2 * _GAP_S  # both
NAMES: tuple[str, ...] = ("ä", "b")
changed = 3


@dataclass(frozen=True, slots=True)
class Point:
    """A place."""

    x_m: float
    y_m: float = field(default=0.0)
    tags: tuple[str, ...] | None = ()

    @property
    def total(self) -> float:
        """ä"""; return sum(value for value in (self.x_m, self.y_m))


@dataclass(slots=True)
class Bag:
    items: list[int] = field(default_factory=list)


@dataclass(frozen=True, slots=True, eq=False)
class Same:
    x: int


def call(_: int, other: float) -> float:
    return sum((part * _GAP_S for part in (other, HIGH)), 1.0)


def moved(point: Point) -> Point:
    return replace(point, x_m=point.x_m + LOW)


class Seen(NamedTuple):
    """A name of `_VALUES` would do."""

    x_m: float
    far: bool = False


class Place(NamedTuple):
    north_m: float
    east_m: float = 2.0


def forms(a: float, b: float) -> list[object]:
    pairs = [x + y for x, y in zip((a, b), (b, a), strict=True)]
    for one, other in zip([a], [b], strict=True):
        pairs.append(one - other)
    (p, q), (r, s) = divmod(a, 2.0), (max(a, b, 0.0, -a), min(b, 1.0, a))
    (t, u), v = (a, b), None
    width = 3
    text = f"é {a:.3f},{b + 1.0:+08.2f} {width:02d} {width:0{width}d} {a!r:>7}" f"{max(a, b, 9.0)}"
    return [pairs, p, q, r, s, t, u, v, text, Place(a).east_m]
'''


@pytest.fixture
def both(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    import sys
    import types

    modules = []
    for name, text in (("as_written", MODULE), ("as_prepared", prepared(MODULE))):
        module: Any = types.ModuleType(name)
        monkeypatch.setitem(sys.modules, name, module)
        exec(compile(text, name, "exec"), module.__dict__)
        modules.append(module)
    return modules


def test_forms_are_the_same(both: list[Any]) -> None:
    written, changed = both
    for a, b in ((1.5, 2.25), (-3.0, 0.125), (7.0, 7.0)):
        assert written.forms(a, b) == changed.forms(a, b)


def test_a_class_with_its_constructor_written_gets_no_other_at_import() -> None:
    text = prepared(MODULE)
    decorated = {name: given for given, name in re.findall(r"@dataclass\((.*)\)\nclass (\w+)", text)}
    assert {name for name, given in decorated.items() if "init=False" in given} == {"Point", "Same", "Place"}
    assert "Bag" in decorated and text.count("def __init__") == 3


def test_forms_that_mypyc_makes_slow_are_gone() -> None:
    text = prepared(MODULE)
    assert "strict=True" not in text and "max(max(max(a, b), 0.0), -a)" in text and "{format(a, '.3f')}" in text
    assert "(p, q) = " in text and "class Place:" in text and "class Seen(NamedTuple):" in text


def test_values_are_the_same(both: list[Any]) -> None:
    for module in both:
        point = module.Point(1.0, tags=("a",))
        assert dataclasses.astuple(module.moved(point)) == (2.0, 0.0, ("a",))
        assert point.total == 1.0
        assert module.call(1, 3.0) == 3.0
        assert (module.LOW, module.HIGH, module.NAMES) == (1.0, 1.0, ("ä", "b"))
        assert point == module.Point(1.0, 0.0, ("a",)) and hash(point) == hash(module.Point(1.0, 0.0, ("a",)))
        assert module.Same(1) != module.Same(1) and {module.Same(1)}
        assert module.Bag().items == [] and module.Bag().items is not module.Bag().items
        with pytest.raises(TypeError):
            hash(module.Bag())


def test_fields_are_the_same(both: list[Any]) -> None:
    described = [[(item.name, item.type, item.default) for item in dataclasses.fields(module.Point)] for module in both]
    assert described[0] == described[1]
    assert both[0].Point.__annotations__ == both[1].Point.__annotations__


def test_a_compiled_class_makes_itself() -> None:
    text = prepared(MODULE)
    made = "def __init__(self, x_m: float, y_m: float = 0.0, tags: tuple[str, ...] | None = ()) -> None: "
    assert made + "self.x_m = x_m; self.y_m = y_m; self.tags = tags" in text
    assert "_GAP_S: Final = 0.5" in text and "LOW: Final = 1.0; HIGH: Final = 2 * _GAP_S  # both" in text
    assert "NAMES: Final[tuple[str, ...]] = " in text and "changed = 3" in text
    assert "sum([value for value in (self.x_m, self.y_m)])" in text and "def call(unused_: int" in text


def test_a_name_bound_twice_is_no_constant() -> None:
    text = "from __future__ import annotations\n\n_N = 0\n\n\ndef up() -> None:\n    global _N\n    _N += 1\n"
    assert prepared(text) == text


def test_every_compiled_module_can_be_prepared() -> None:
    for name in compiled(ROOT):
        text = (ROOT / name).read_text(encoding="utf-8")
        before, after = ast.parse(text), ast.parse(prepared(text))
        names = [[node.name for node in tree.body if hasattr(node, "name")] for tree in (before, after)]
        assert names[0] == names[1], name


def test_what_is_compiled_is_known() -> None:
    assert set(compiled(ROOT)) < set(known(ROOT))
    assert "companion/loop.py" in compiled(ROOT) and "companion/config/vessel.py" in known(ROOT)
    assert "companion/cli/main.py" not in known(ROOT)


@pytest.mark.parametrize("bound", ["take(data)", "(n := 1)"])
def test_a_slice_that_does_something_is_refused(bound: str) -> None:
    with pytest.raises(ValueError, match="line 1: a call in the bounds"):
        prepared(f"rest = data[{bound} :]\n")


def test_a_name_that_begins_as_an_empty_tuple_is_refused() -> None:
    """Compiled, logs with channels of a transmitter or with a lidar's distances could not be read."""
    for bound in ("found = ()", "name, found = '', ()"):
        with pytest.raises(ValueError, match="line 2: found begins as"):
            prepared(f"def read(data):\n    {bound}\n    found = take(data)\n")
    for bound in ("found: tuple[int, ...] = ()", "found = take(data)\n    found = ()"):
        prepared(f"def read(data):\n    {bound}\n    found = take(data)\n")
    prepared("def read(data, found):\n    data, found = 1, ()\n")


def test_an_object_without_its_init_is_refused() -> None:
    with pytest.raises(ValueError, match="line 1: an object made by __new__"):
        prepared("area = Area.__new__(Area)\n")
    with pytest.raises(ValueError, match="line 1: an object made by __new__"):
        prepared("member = int.__new__(cls, number)\n")


def test_kinds_of_a_value_are_a_tuple() -> None:
    assert (
        prepared("found = isinstance(value, Fix | core.Heading)\n")
        == "found = isinstance(value, (Fix, core.Heading))\n"
    )
    for text in ("found = isinstance(value, KINDS)\n", "found = isinstance(value, Fix | None)\n"):
        assert prepared(text) == text


def test_a_class_variable_of_a_dataclass_is_refused() -> None:
    with pytest.raises(ValueError, match="line 3: a ClassVar"):
        prepared("@dataclass\nclass Point:\n    kind: ClassVar[int] = 1\n")


def test_a_dataclass_keeps_the_hash_of_its_own() -> None:
    text = "from __future__ import annotations\n@dataclass(frozen=True)\nclass Point:\n    x: int\n"
    assert 'give(Point, "repr", "eq", "hash")' in prepared(text)
    assert 'give(Point, "repr", "eq")' in prepared(text + "\n    def __hash__(self) -> int:\n        return 1\n")


def test_dataclass_makes_no_methods_of_text_where_it_can_be_left_out() -> None:
    given = dict(re.findall(r"native_values\.give\((\w+)(.*)\)", prepared(MODULE)))
    assert given == {
        "Point": ', "repr", "eq", "hash"',
        "Bag": ', "repr", "eq", "no hash"',
        "Same": ', "repr"',
        "Place": ', "repr", "eq", "hash"',
    }


def test_a_dataclass_with_an_order_is_left_to_dataclass() -> None:
    text = "@dataclass(frozen=True, order=True)\nclass Point:\n    x: int\n"
    assert "give" not in prepared(text) and "order=True, unsafe_hash=True, init=False" in prepared(text)


def test_a_generic_dataclass_is_refused() -> None:
    with pytest.raises(ValueError, match="line 2: a generic dataclass"):
        prepared("@dataclass(frozen=True)\nclass Answer(Generic[T]):\n    found: T\n")


def test_drivers_of_other_packages_may_inherit() -> None:
    text = prepared((ROOT / "companion/io/sensors/driver.py").read_text(encoding="utf-8"))
    assert "\n@mypy_extensions.mypyc_attr(allow_interpreted_subclasses=True)\nclass StreamDriver(ABC):" in text
