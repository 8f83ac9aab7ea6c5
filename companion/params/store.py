"""The values of the parameters: defaults, the vessel's, and what an operator sets."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping

from companion.params.spec import ParamRefusal, ParamSpec, ParamType
from companion.params.table import TABLE


class Parameters:
    """Values of all parameters, by name. Reading costs one dictionary look-up; the table is fixed while the process
    runs."""

    def __init__(self, defaults: Mapping[str, float] | None = None, table: Iterable[ParamSpec] = TABLE) -> None:
        """`defaults`: the vessel's, which override the table's. Raises ValueError for a name or value that the table
        refuses."""
        self.specs: tuple[ParamSpec, ...] = tuple(sorted(table, key=lambda spec: spec.name))
        self._by_name = {spec.name: spec for spec in self.specs}
        self.index = {spec.name: i for i, spec in enumerate(self.specs)}
        self.defaults = {spec.name: self._coerced(spec, spec.default) for spec in self.specs}
        for name, value in (defaults or {}).items():
            refusal = self.refusal(name, value)
            if refusal is not None:
                raise ValueError(f"parameter {name} = {value}: {refusal.name.lower().replace('_', ' ')}")
            self.defaults[name] = self._coerced(self._by_name[name], value)
        self._values = dict(self.defaults)
        self.version = 0  # it grows with each change
        self._listeners: list[Callable[[str, float], None]] = []
        self._after: list[Callable[[], None]] = []

    def __getitem__(self, name: str) -> float:
        return self._values[name]

    def frozen(self) -> Parameters:
        """The values as they are now, for work beside the control thread. What is set later does not change them."""
        copy = Parameters(table=())
        copy.specs, copy._by_name, copy.index, copy.defaults = self.specs, self._by_name, self.index, self.defaults
        copy._values = dict(self._values)
        return copy

    def spec(self, name: str) -> ParamSpec | None:
        """The table's row, or None for an unknown name."""
        return self._by_name.get(name)

    def changed(self) -> dict[str, float]:
        """The values that differ from the defaults: what the state file keeps."""
        return {name: value for name, value in self._values.items() if value != self.defaults[name]}

    def on_change(self, listener: Callable[[str, float], None]) -> None:
        """Call `listener(name, value)` after every accepted change."""
        self._listeners.append(listener)

    def after_change(self, listener: Callable[[], None]) -> None:
        """Call `listener()` once after each change, however many values it has."""
        self._after.append(listener)

    def refusal(self, name: str, value: float) -> ParamRefusal | None:
        """Why `value` would be refused; None if it would be accepted."""
        spec = self._by_name.get(name)
        if spec is None:
            return ParamRefusal.DOES_NOT_EXIST
        if spec.read_only:
            return ParamRefusal.READ_ONLY
        if not math.isfinite(value):
            return ParamRefusal.VALUE_OUT_OF_RANGE
        low, taken, high = (self._coerced(spec, number) for number in (spec.minimum, value, spec.maximum))
        if not low <= taken <= high or (spec.choices and taken not in spec.choices):
            return ParamRefusal.VALUE_OUT_OF_RANGE
        return None

    def set(self, name: str, value: float) -> ParamRefusal | None:
        """Store `value`, call the listeners and return None; or return why it is refused, and change nothing."""
        return self.set_all({name: value})

    def set_all(self, values: Mapping[str, float]) -> ParamRefusal | None:
        """As `set` for several values: all of them or none."""
        for name, value in values.items():
            if (refusal := self.refusal(name, value)) is not None:
                return refusal
        self._store({name: self._coerced(self._by_name[name], value) for name, value in values.items()})
        return None

    def reset(self) -> None:
        """Set all parameters back to the vessel's defaults."""
        self._store({name: value for name, value in self.defaults.items() if self._values[name] != value})

    def _store(self, values: Mapping[str, float]) -> None:
        self._values.update(values)
        self.version += 1
        for name, value in values.items():
            for listener in self._listeners:
                listener(name, value)
        for after in self._after:
            after()

    @staticmethod
    def _coerced(spec: ParamSpec, value: float) -> float:
        if spec.type is ParamType.INT32:
            return round(value) if math.isfinite(value) else value
        return _float32(value)


def _float32(value: float) -> float:
    """The nearest value that a MAVLink float can hold, so that a client reads back what it wrote."""
    if not math.isfinite(value):
        return value
    mantissa, exponent = math.frexp(value)
    return math.ldexp(round(math.ldexp(mantissa, 24)), exponent - 24)
