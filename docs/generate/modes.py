"""modes.md: the modes, their numbers for each persona, what they need."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from companion.cli.rig import LockstepRig
from companion.config.vessel import bundled
from companion.core.decision import ModeDeclaration, Need
from companion.io.mavlink.wire.personas import PERSONAS
from companion.modes.mode import ModeInfo
from companion.modes.table import DECLARATIONS
from docs.generate.markdown import code, page, section, sentence, table
from sitl.scenarios.rig import Conditions

_INTRODUCTION = """A mode is one way of steering the boat. Choose it at any time; thrusters move only while the boat
is armed.

*Needs* is what of the estimate must be valid: without it the mode is refused, and losing it is a failsafe.
A mode with *sticks* is steered by hand; all others steer by themselves."""
_NUMBERS = """`custom_mode` of HEARTBEAT and DO_SET_MODE. The persona belongs to the link: `?dialect=ardupilot`,
`?dialect=generic`; without it, px4."""


def modes() -> str:
    """The page."""
    headers = ("mode", "needs", "sticks", "chosen again", "allocation", "disarmed choice")
    return page(
        "Modes",
        _INTRODUCTION,
        table(headers, (_row(mode) for mode in DECLARATIONS.values())),
        section(2, "Numbers", _NUMBERS, numbers_table()),
        section(2, "On the bundled vessels", *_vessels()),
    )


def _row(mode: ModeDeclaration) -> tuple[str, ...]:
    needs = [need.value for need in Need if need in mode.needs]
    early = "before it can be entered" if mode.early else ""
    allocation = "" if mode.allocates else "sticks drive the thrusters directly"
    return code(mode.id.value), ", ".join(needs), "yes" if mode.by_stick else "", mode.again, allocation, early


def numbers_table() -> str:
    """Mode numbers by persona."""
    rows = []
    for mode in DECLARATIONS.values():
        numbers = [persona.modes.get(mode.id) for persona in PERSONAS.values()]
        shown = ["" if n is None else code(f"0x{n:08X}") if n > 0xFF else code(n) for n in numbers]
        rows.append((code(mode.id.value), *shown))
    return table(("mode", *PERSONAS), rows)


@cache
def offered(vessel: str) -> tuple[ModeInfo, ...]:
    """The modes of a bundled vessel, as ground stations list them."""
    with TemporaryDirectory() as folder:
        rig = LockstepRig(Conditions(vessel), Path(folder))
        found = tuple(rig.vessel.supervisor.modes)
        rig.close()
    return found


def _vessels() -> Iterator[str]:
    """One table for all modes whose text is the same everywhere, then those that differ."""
    lists = {vessel: {mode.id: mode for mode in offered(vessel)} for vessel in bundled()}
    for mode in DECLARATIONS.values():
        texts = {
            vessel: sentence(modes[mode.id].text) + ("" if modes[mode.id].declaration.selectable else " Not offered.")
            for vessel, modes in lists.items()
        }
        if len(set(texts.values())) == 1:
            yield section(3, mode.id.value, next(iter(texts.values())))
        else:
            yield section(
                3,
                mode.id.value,
                table(("vessel", "what it does there"), ((code(vessel), text) for vessel, text in texts.items())),
            )
