"""The MAVProxy module: `usv …` at the prompt. Loads with `module load gcs_plugins.mavproxy.mavproxy_usv`; tried with
MAVProxy 1.8.75."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from MAVProxy.modules.lib import mp_module

from gcs_plugins.commands import ACTIONS, BY_NAME, TUNING, TUNING_STEP, MavCmd, OperatorAction
from gcs_plugins.readout import Readout

_DO_REPOSITION, _CHANGE_MODE, _FRAME_GLOBAL = 192, 1.0, 0

_YES = "yes"

_USAGE = {
    "status": ("", "position, and how well the boat holds, sails or follows"),
    "watch": ("[SECONDS | off]", "the status again and again"),
    "goto": ("LAT LON [HEADING_DEG [SPEED_MPS]]", "go there and hold"),
    "nudge": ("AHEAD_M STARBOARD_M [TURN_DEG]", "move the hold point and the heading"),
    "turn": ("HEADING_DEG", "another heading at the hold point"),
    "station": ("BEARING_DEG DISTANCE_M", "follow position: 180 astern, 90 to starboard of the leader"),
    "tune": ("[LOOP [up | down | FACTOR]]", f"bandwidths, a tenth more or less at a step, of {', '.join(TUNING)}"),
    "help": ("", "this text"),
}


class Mistake(Exception):
    """A mistake in the input: printed at the prompt, nothing was sent."""


class UsvModule(mp_module.MPModule):
    """Sends the actions of the table, and commands that take numbers. MAVProxy itself prints the answers: COMMAND_ACK
    and texts."""

    def __init__(self, mpstate: Any) -> None:
        super().__init__(mpstate, "usv", "uncrewed surface vessel", public=True)
        self._readout = Readout()
        self._watch_s: float | None = None
        self._watched_s = 0.0
        self._verbs: Mapping[str, Callable[[Sequence[str]], None]] = {
            "status": self._status,
            "watch": self._watch,
            "goto": self._goto,
            "nudge": self._nudge,
            "turn": self._turn,
            "station": self._station,
            "tune": self._tune,
            "help": self._help,
        }
        self.add_command("usv", self._command, "uncrewed surface vessel: usv help", completions())

    def mavlink_packet(self, packet: Any) -> None:
        """Every message that comes in, of any vehicle."""
        if self.message_is_from_primary_vehicle(packet):
            self._readout.hear(packet.get_type(), packet, self.get_time())

    def idle_task(self) -> None:
        """Repeat the status report while `usv watch` is on."""
        now_s = self.get_time()
        if self._watch_s is not None and now_s - self._watched_s >= self._watch_s:
            self._watched_s = now_s
            self._status(())

    def unload(self) -> None:
        """Remove the command with the module."""
        self.remove_command("usv")
        super().unload()

    def _command(self, args: Sequence[str]) -> None:
        verb, rest = (args[0], args[1:]) if args else ("status", ())
        try:
            if verb in BY_NAME:
                self._send_action(BY_NAME[verb], rest)
            elif verb in self._verbs:
                self._verbs[verb](rest)
            else:
                raise Mistake(f"usv {verb}: no such command; usv help lists them")
        except Mistake as mistake:
            print(mistake)

    # --- what it shows ---------------------------------------------------------------------------------------------

    def _status(self, rest: Sequence[str]) -> None:
        for line in self._readout.lines(self.get_time()):
            print(f"usv: {line}")

    def _watch(self, rest: Sequence[str]) -> None:
        if rest and rest[0] == "off":
            self._watch_s = None
        else:
            (self._watch_s,) = _numbers("watch", rest or ("2",), 1, 1)

    def _help(self, rest: Sequence[str]) -> None:
        for verb, (_, text) in _USAGE.items():
            print(f"{_usage(verb)}: {text}")
        for action in ACTIONS:
            sure = f" {_YES}" if action.asks else ""
            print(f"usv {action.name}{sure}: {action.text} ({action.where.value})")

    # --- what it sends ---------------------------------------------------------------------------------------------

    def _send_action(self, action: OperatorAction, rest: Sequence[str]) -> None:
        if rest and not (action.asks and tuple(rest) == (_YES,)):
            raise Mistake(f"usv {action.name} takes no arguments")
        if action.asks and not rest:
            raise Mistake(f"{action.label}: {action.asks}. usv {action.name} {_YES} sends it")
        if action.mode is not None and self._readout.mode is None:
            raise Mistake(f"usv {action.name}: no heartbeat of the boat yet, so its mode numbers are not known")
        self._send(action.command, *action.all_params(self._readout.rover_numbers))

    def _send(self, command: int, *params: float) -> None:
        padded = (*params, *(0.0 for _ in range(7 - len(params))))
        self.master.mav.command_long_send(self.target_system, self.target_component, command, 0, *padded)

    def _goto(self, rest: Sequence[str]) -> None:
        lat_deg, lon_deg, heading_deg, speed_mps = _numbers("goto", rest, 2, 4, (math.nan, -1.0))
        if not (abs(lat_deg) <= 90.0 and abs(lon_deg) <= 180.0):
            raise Mistake("usv goto: give latitude and longitude in degrees")
        place = (round(lat_deg * 1e7), round(lon_deg * 1e7), 0.0)
        how = (speed_mps, _CHANGE_MODE, 0.0, math.radians(heading_deg))
        self.master.mav.command_int_send(
            self.target_system, self.target_component, _FRAME_GLOBAL, _DO_REPOSITION, 0, 0, *how, *place
        )

    def _nudge(self, rest: Sequence[str]) -> None:
        self._send(MavCmd.USER_1, 1.0, *_numbers("nudge", rest, 2, 3, (0.0,)))

    def _turn(self, rest: Sequence[str]) -> None:
        (heading_deg,) = _numbers("turn", rest, 1, 1)
        self._send(MavCmd.USER_1, 2.0, heading_deg % 360.0)

    def _station(self, rest: Sequence[str]) -> None:
        self._send(MavCmd.USER_3, *_numbers("station", rest, 2, 2))

    def _tune(self, rest: Sequence[str]) -> None:
        """Without a step, print the bandwidths."""
        loop, step = (*rest, "", "")[:2]
        if (loop and loop not in TUNING) or len(rest) > 2:
            raise Mistake(f"usage: {_usage('tune')}; loops are {', '.join(TUNING)}")
        names = TUNING[loop] if loop else (*TUNING["dp"], *TUNING["path"])
        for name in names:
            value = self.get_mav_param(name)
            if value is None:
                raise Mistake(f"usv tune: {name} is not known yet; `param fetch` first")
            if step:
                self._set(name, value * _factor(step))
            else:
                print(f"usv: {name} {value:.3f} rad/s")

    def _set(self, name: str, value: float) -> None:
        if not self.mpstate.functions.param_set(name, value):
            raise Mistake(f"usv tune: the boat does not take {name} = {value:.3f}")
        print(f"usv: {name} {value:.3f} rad/s")


def completions() -> list[str]:
    """Rules for the prompt's tab key. A verb with arguments has a rule of its own: MAVProxy fails on a shorter rule
    that fits."""
    first = [verb for verb in (*_USAGE, *BY_NAME) if verb not in ("tune", "watch")]
    return [f"<{'|'.join(first)}>", f"tune <{'|'.join(TUNING)}> <up|down>", "watch <off>"]


def _factor(step: str) -> float:
    if step in ("up", "down"):
        return TUNING_STEP if step == "up" else 1.0 / TUNING_STEP
    (factor,) = _numbers("tune", (step,), 1, 1)
    if not 0.1 <= factor <= 10.0:
        raise Mistake("usv tune: give a factor from 0.1 to 10")
    return factor


def _usage(verb: str) -> str:
    return f"usv {verb} {_USAGE[verb][0]}".rstrip()


def _numbers(verb: str, words: Sequence[str], least: int, most: int, others: Sequence[float] = ()) -> list[float]:
    """The words as finite numbers; `others` are the defaults of the last ones. Raises Mistake."""
    try:
        values = [float(word) for word in words]
    except ValueError:
        raise Mistake(f"usage: {_usage(verb)}") from None
    if not least <= len(values) <= most or not all(math.isfinite(value) for value in values):
        raise Mistake(f"usage: {_usage(verb)}")
    return values + list(others[len(values) - least :])


def init(mpstate: Any) -> UsvModule:
    """MAVProxy calls this to load the module."""
    return UsvModule(mpstate)
