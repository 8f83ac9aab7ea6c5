"""What modes declare, and that everybody reads it there."""

from __future__ import annotations

import pytest

from companion.core.decision import ModeId, Need
from companion.io.mavlink.wire.personas import PX4
from companion.modes.table import DECLARATIONS, ROWS
from companion.params.table import TABLE
from companion.supervisor.failsafes import FAILSAFES
from gcs_plugins.commands import MODES


def test_every_mode_declares_itself_once() -> None:
    assert len(ROWS) == len(DECLARATIONS)
    assert set(DECLARATIONS) == set(ModeId)
    assert all(declared.text and declared.again for declared in DECLARATIONS.values())


def test_persona_numbers_are_unique() -> None:
    declared = DECLARATIONS.values()
    assert len({d.px4 for d in declared}) == len(DECLARATIONS)
    rover = [number for d in declared for number in (d.rover, *d.rover_aliases)]
    assert len(set(rover)) == len(rover)
    standard = [d.standard_mode for d in declared if d.standard_mode]
    assert len(set(standard)) == len(standard)


def test_only_manual_passes_the_allocation_by_and_needs_nothing() -> None:
    assert [d.id for d in DECLARATIONS.values() if not d.allocates] == [ModeId.MANUAL]
    assert [d.id for d in DECLARATIONS.values() if not d.needs] == [ModeId.MANUAL, ModeId.FORCES, ModeId.RATE]
    assert all({Need.POSITION, Need.HEADING} <= d.needs for d in DECLARATIONS.values() if not d.by_stick)


def test_failsafes_in_order_of_severity() -> None:
    assert [row.name for row in FAILSAFES] == [
        "capsized",
        "bridge_silent",
        "thrust_lost",
        "one_sided_thrust",
        "ticks_late",
        "position_lost",
        "heading_lost",
        "leak",
        "battery_critical",
        "battery_return",
        "battery_low",
        "shallow",
        "ranges_lost",
        "aground_or_fouled",
        "fence",
        "transmitter_lost",
        "station_lost",
        "sticks_lost",
        "leader_lost",
        "offboard_lost",
        "stuck",
    ]


def test_declared_failsafes_name_parameters() -> None:
    known = {spec.name for spec in TABLE}
    for declared in DECLARATIONS.values():
        if declared.failsafe is not None:
            assert declared.failsafe.action in known
            assert declared.failsafe.back_after is None or declared.failsafe.back_after in known


@pytest.mark.parametrize(
    ("mode", "flags"),
    [
        (ModeId.MANUAL, 64),
        (ModeId.FORCES, 64),
        (ModeId.RATE, 64),
        (ModeId.HEADING, 64 | 16),
        (ModeId.HOLD, 16 | 8),
        (ModeId.OFFBOARD, 16 | 8),
        (ModeId.MISSION, 16 | 8 | 4),
        (ModeId.RTL, 16 | 8 | 4),
        (ModeId.DOCK, 16 | 8 | 4),
        (ModeId.CIRCLE, 16 | 8 | 4),
        (ModeId.TRIAL, 16 | 8 | 4),
        (ModeId.FOLLOW, 16 | 8 | 4),
    ],
)
def test_base_mode_flags(mode: ModeId, flags: int) -> None:
    assert PX4.base_mode(mode, armed=False) == 1 | flags


def test_plugins_list_the_modes_that_are_declared() -> None:
    """Plug-ins run inside ground stations and cannot import the companion: their list is held against it here."""
    listed = {name: (numbers.px4, numbers.rover) for name, numbers in MODES.items()}
    assert listed == {d.id.value: (d.px4, d.rover) for d in DECLARATIONS.values()}
