"""parameters.md: every parameter by group, and what the bundled vessels set."""

from __future__ import annotations

from collections.abc import Iterable

from companion.config.vessel import VesselConfig, bundled, find, load
from companion.params.spec import ParamSpec
from companion.params.table import TABLE
from docs.generate.markdown import anchored, code, number, page, section, sentence, table

_INTRODUCTION = """Every value that you can tune. A ground station shows the same names, texts, units and ranges.

A value comes from three places, the last one counts: the default in this table, `[parameters]` in the vessel file,
and what an operator set.
The boat keeps what an operator set over restarts. A change takes effect at once, unless the table says *restart*."""

_FIXED = """Values that QGroundControl's pages for PX4 look up. They cannot be changed and do nothing."""


def parameters() -> str:
    """The page."""
    tunable = [spec for spec in TABLE if not spec.read_only]
    groups = list(dict.fromkeys(spec.group for spec in tunable))
    parts = [section(2, group, _group(spec for spec in tunable if spec.group == group)) for group in groups]
    vessels = [load(find(name)) for name in bundled()]
    own = [section(3, vessel.title, _overridden(vessel)) for vessel in vessels if vessel.parameters]
    fixed = table(
        ("name", "meaning", "value"),
        ((anchored(spec.name), sentence(spec.text), number(spec.default)) for spec in TABLE if spec.read_only),
    )
    return page(
        "Parameters",
        _INTRODUCTION,
        *parts,
        section(2, "Defaults of the bundled vessels", *own),
        section(2, "Fixed values", _FIXED, fixed),
    )


def _group(specs: Iterable[ParamSpec]) -> str:
    headers = ("name", "meaning", "unit", "range", "default", "")
    return table(
        headers,
        (
            (anchored(s.name), _meaning(s), s.unit, _range(s), shown(s, s.default), "restart" if s.reboot else "")
            for s in specs
        ),
    )


def _meaning(spec: ParamSpec) -> str:
    choices = ", ".join(f"{value}: {text}" for value, text in spec.choices.items())
    return sentence(spec.text) + (f"<br>{choices}" if choices else "")


def _range(spec: ParamSpec) -> str:
    return "" if spec.choices else f"{number(spec.minimum)} to {number(spec.maximum)}"


def shown(spec: ParamSpec, value: float) -> str:
    """A value of a parameter, with the name of the choice that it is."""
    choice = spec.choices.get(round(value))
    return number(value) if choice is None else f"{number(value)} ({choice})"


def _overridden(vessel: VesselConfig) -> str:
    specs = {spec.name: spec for spec in TABLE}
    rows = (
        (code(name), shown(specs[name], specs[name].default), shown(specs[name], value))
        for name, value in vessel.parameters.items()
    )
    return table(("name", "default", f"in `{vessel.name}`"), rows)
