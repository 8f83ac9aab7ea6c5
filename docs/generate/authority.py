"""authority.md: every reason for which the boat leaves its mode, in order, and who is obeyed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from companion.params.table import TABLE
from companion.supervisor.authority import ROWS, RequestedAction, Right
from companion.supervisor.failsafes import FAILSAFES, Failsafe, FailsafeAction
from companion.supervisor.mode_changes import MODE_CHANGES
from docs.generate.markdown import code, page, section, sentence, table
from docs.generate.parameters import shown
from docs.generate.statustexts import all_texts

_INTRODUCTION = """Who is obeyed, and every reason for which the boat leaves its mode, in order."""
_PEOPLE = """Each rule refuses what its row says. The first that applies gives the reason. What no rule refuses is
obeyed.
The newest choice of a person counts, whether it comes from a ground station or from the lead boat's crew."""
_FAILSAFES = """A failsafe begins when its cause lasts and it applies to what the boat does. It acts once. What an
operator asks for afterwards stands,
until the failsafe has ended and begins again.

The most severe comes first. While one that acted lasts, those below wait, and act when it ends if they still last.

Neutral: no thrust while the failsafe lasts. The boat stays armed in its mode and goes on in it afterwards.
A boat that pushes against its berth stays there: Hold and RTL leave it, Neutral ends the push."""
_CHANGES = """Every reason for which the boat leaves its mode. A reason beats those below it."""

_SOURCES = """The rules stand in `companion/supervisor/authority.py`, the reasons in
`companion/supervisor/mode_changes.py`, the failsafes
in `companion/supervisor/failsafes.py` and, for those of a single mode, in the mode's own file in `companion/modes/`."""

CAUSES: Mapping[str, tuple[str, str]] = {  # name of a failsafe → what begins it, when it applies
    "capsized": ("The boat heels by more than `FS_TILT_ANG`", "armed"),
    "bridge_silent": ("A thruster bridge does not answer", "armed"),
    "thrust_lost": ("So many thrusters have failed that the boat cannot go ahead, or cannot steer", "armed"),
    "one_sided_thrust": (
        "A fixed thruster off the centre line is the only one left: the boat would go in circles",
        "armed, in a mode that steers itself",
    ),
    "ticks_late": ("Five ticks of 3 s begin more than `FS_TICK_LATE` late; ends 3 s after the last", "armed"),
    "position_lost": (
        "The position is not valid: dead reckoning for `FS_POS_T`, or worse than `COM_POS_FS_EPH`",
        "armed, in a mode that needs it",
    ),
    "heading_lost": ("The heading is not valid", "armed, in a mode that needs it"),
    "leak": ("The leak sensor is wet", "always"),
    "battery_critical": ("The battery is below `BAT_CRIT_THR`", "always"),
    "battery_return": (
        "The battery just takes the boat home, with `BAT_RET_MARG` and `BAT_CRIT_THR` left there",
        "armed, in a mode that steers itself",
    ),
    "battery_low": ("The battery is below `BAT_LOW_THR`", "always"),
    "shallow": ("A sounder measures less than `FS_DEPTH_MIN`", "armed, in a mode that steers itself"),
    "ranges_lost": (
        "A ranging sensor that was heard is silent for 2 s",
        "armed, in a mode that steers itself",
    ),
    "aground_or_fouled": ("Thrust makes no way for `FS_WAY_T`", "armed, in a mode that steers itself"),
    "fence": ("The boat leaves the fence, or is about to under sticks", "armed"),
    "transmitter_lost": (
        "The transmitter is silent for `COM_RC_LOSS_T` with its safe switch on",
        "armed, in a mode with sticks",
    ),
    "sticks_lost": ("The sticks are silent for `COM_RC_LOSS_T`", "armed, in a mode with sticks, safe switch off"),
    "station_lost": ("No ground station is heard for `COM_DL_LOSS_T`", "armed, in a mode that steers itself"),
    "leader_lost": ("The leader, its position or the boat's own is lost for `FOLL_LOSS_T`", "armed, in Follow"),
    "offboard_lost": ("No setpoint is younger than `OFFB_TIMEOUT`", "armed, in Offboard"),
    "stuck": ("The boat makes no headway for `WP_STUCK_T`", "armed, under way"),
}


class UndescribedFailsafe(Exception):
    """A row of the table of failsafes that this page does not know."""


def authority() -> str:
    """The page."""
    headers = ("", "failsafe", "begins when", "applies", "action", "default", "announces")
    return page(
        "Who is obeyed, and what ends a mode",
        _INTRODUCTION,
        section(
            2, "Who is obeyed", _PEOPLE, table(("", "rule", "who asks", "asks to", "the rule in words"), rule_rows())
        ),
        section(
            2,
            "What changes the mode",
            _CHANGES,
            table(("", "reason", "leaves", "mode then", "when", "parameter"), change_rows()),
        ),
        section(2, "Failsafes", _FAILSAFES, table(headers, failsafe_rows())),
        section(2, "In the program", _SOURCES),
    )


def failsafe_rows() -> Iterator[tuple[str, ...]]:
    """One row a failsafe, most severe first. Raises UndescribedFailsafe."""
    specs = {spec.name: spec for spec in TABLE}
    texts = {said.name: said.text for said in all_texts()}
    for place, row in enumerate(FAILSAFES, start=1):
        if row.name not in CAUSES:
            raise UndescribedFailsafe(
                f"failsafe {row.name}: say in docs/generate/authority.py what begins it and when it applies"
            )
        cause, applies = CAUSES[row.name]
        action, default = _action(row), ""
        if isinstance(row.action, str):
            default = shown(specs[row.action], specs[row.action].default)
        yield (
            str(place),
            f"{code(row.name)}{{#{row.name}}}",
            sentence(cause),
            applies,
            action,
            default,
            code(texts.get(row.name, "")),
        )


def _action(row: Failsafe) -> str:
    if isinstance(row.action, FailsafeAction):
        return {FailsafeAction.IGNORE: "warns only", FailsafeAction.NEUTRAL: "Neutral"}.get(
            row.action, row.action.name.title()
        )
    return f"[`{row.action}`](parameters.md#{row.action.lower()})"


# --- who is obeyed -------------------------------------------------------------------------------------------------


def rule_rows() -> Iterator[tuple[str, ...]]:
    """One row a rule of authority, in order."""
    for place, row in enumerate(ROWS, start=1):
        about = "; ".join(action.value for action in RequestedAction if action in row.about)
        by = "; ".join(right.value for right in Right if right in row.by)
        yield str(place), f"{code(row.name)}{{#{row.name}}}", by, about, row.doc


# --- what changes the mode -----------------------------------------------------------------------------------------


def change_rows() -> Iterator[tuple[str, ...]]:
    """One row a reason to change the mode, in order of precedence."""
    for place, change in enumerate(MODE_CHANGES, start=1):
        parameter = f"[`{change.parameter}`](parameters.md#{change.parameter.lower()})" if change.parameter else ""
        yield str(place), code(change.name), change.leaves, change.to, sentence(change.condition), parameter
