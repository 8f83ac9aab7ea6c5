"""Every TOML block on the pages is a vessel file, a leader module's file, a sweep's design, or a part of one that fits a
bundled vessel."""

from __future__ import annotations

import tomllib
from copy import deepcopy
from typing import Any

import pytest
from pydantic import TypeAdapter, ValidationError

from companion.config.dimensions.completion import completed
from companion.config.vessel import VesselConfig, find, parse
from companion.io.actuators import DRIVERS as ACTUATOR_DRIVERS
from companion.io.sensors import DRIVERS as SENSOR_DRIVERS
from companion.leader_module.config import LeaderConfig, parse_leader
from companion.params.table import TABLE
from sitl.scenarios import SCENARIOS
from sitl.sweep.design import parse_design
from tests.docs.pages import Block, blocks

_BASE = "revolt"
_PARAMETERS = frozenset(spec.name for spec in TABLE)


def _merged(base: dict[str, Any], part: dict[str, Any]) -> dict[str, Any]:
    """`part` over `base`: tables key by key; of several tables each is completed by the base's first one."""
    found = deepcopy(base)
    for key, value in part.items():
        before = found.get(key)
        if isinstance(value, dict) and isinstance(before, dict):
            found[key] = _merged(before, value)
        elif _is_tables(value) and _is_tables(before):
            found[key] = [_merged(before[0], row) for row in value]
        else:
            found[key] = value
    return found


def _is_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(row, dict) for row in value)


def _check_whole(block: Block, data: dict[str, Any]) -> bool:
    """Whether the block is a whole file; it is checked then."""
    if "control_rate_hz" in data:
        parse(block.text, block.place)
        return True
    if "system_id" in data:
        parse_leader(block.text, block.place)
        return True
    if "part" in data:
        parse_design(block.text, block.place, SCENARIOS)
        return True
    return False


@pytest.mark.parametrize("block", list(blocks("toml")), ids=lambda block: block.place)
def test_every_toml_block_fits(block: Block) -> None:
    data = tomllib.loads(block.text)
    if not _check_whole(block, data):
        leader = bool({"joystick", "local_links", "follower", "thrifty"} & data.keys())
        base = dict(completed(tomllib.loads(find(_BASE).read_text(encoding="utf-8"))).data)
        whole = {"name": "module", "system_id": 42, "links": ["udpin:0.0.0.0:1"], "sensor": base["sensor"]}
        kind: Any = LeaderConfig if leader else VesselConfig
        try:
            TypeAdapter(kind).validate_python(_merged(whole if leader else base, data))
        except ValidationError as error:
            pytest.fail(f"{block.place}: {error}")
    drivers = {"sensor": SENSOR_DRIVERS, "actuator": ACTUATOR_DRIVERS}
    unknown = [
        row["driver"] for name, table in drivers.items() for row in data.get(name, ()) if row["driver"] not in table
    ]
    unknown += [name for name in data.get("parameters", {}) if name not in _PARAMETERS]
    assert not unknown, f"{block.place}: unknown {', '.join(unknown)}"
