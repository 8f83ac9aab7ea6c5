"""What must be true of bridges and of the calibration of their drives."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from companion.config.bridges import PULSE_DRIVERS, OutputConfig
from companion.config.devices import ActuatorConfig, ThrusterConfig
from companion.config.driving import azimuths_of
from companion.config.outputs import ServoConfig

Problem = tuple[tuple[str | int, ...], str]
_SHORTEST_US, _LONGEST_US = 500.0, 2500.0


def bridge_problems(thrusters: Sequence[ThrusterConfig], actuators: Sequence[ActuatorConfig], servos: Sequence[ServoConfig]) -> list[Problem]:
    """Faults of all bridges and of `[thruster.output]`, with their places."""
    problems: list[Problem] = []
    by_name = {thruster.name: thruster for thruster in thrusters}
    for i, actuator in enumerate(actuators):
        driven = [by_name[name] for name in actuator.thrusters if name in by_name]
        problems += [(("actuator", i, *place), text) for place, text in _of_parts(actuator)]
        turned = {thrusters[k].name for k in azimuths_of(actuator, thrusters, actuators)}
        problems += [(("actuator", i, *place), text) for place, text in _of_mavlink(actuator, driven, turned)]
        if actuator.mavlink is not None and actuator.mavlink.method == "override":
            text = "an overridden channel cannot be without pulses: give it rest_us"
            problems += [(("servo", j, "name"), text) for j, servo in enumerate(servos) if servo.name in actuator.servos and servo.rest_us is None]
    pulsed = {name for actuator in actuators if actuator.driver in PULSE_DRIVERS for name in actuator.thrusters}
    for i, thruster in enumerate(thrusters):
        if thruster.output is not None:
            problems += [(("thruster", i, "output", key), text) for key, text in _of_output(thruster.output, thruster, thruster.name in pulsed)]
    return problems


def _of_output(output: OutputConfig, thruster: ThrusterConfig, pulses: bool) -> list[tuple[str, str]]:
    problems: list[tuple[str, str]] = []
    low, high, unit = (_SHORTEST_US, _LONGEST_US, "µs") if pulses else (-1.0, 1.0, "of what the drive can")
    for key in ("trim", "ahead", "astern"):
        value = getattr(output, key)
        if value is not None and not low <= value <= high:
            problems.append((key, f"should be within {low:g} to {high:g} {unit}"))
    scale = output.scale(pulses)
    if not pulses and scale.trim != 0.0:
        problems.append(("trim", "the neutral of this bridge's board is 0: it is calibrated on the board"))
    ahead, astern = scale.ahead - scale.trim, scale.astern - scale.trim
    if ahead == 0.0 or ahead * astern > 0.0 or (astern == 0.0 and thruster.min_n < 0.0):
        problems.append(("trim", "standstill should lie between full ahead and full astern"))
    elif scale.dead_band >= min(abs(span) for span in (ahead, astern) if span != 0.0):
        problems.append(("dead_band", "leaves nothing between trim and full throttle"))
    if pulses and (output.azimuth_trim_rad != 0.0 or output.azimuth_reversed):
        problems.append(("azimuth_trim_deg", "a servo is calibrated by azimuth_min_us and azimuth_max_us"))
    if output.azimuth_min_us == output.azimuth_max_us:
        problems.append(("azimuth_max_us", "should differ from azimuth_min_us"))
    return problems


def _of_parts(actuator: ActuatorConfig) -> list[Problem]:
    """Bridges whose drives have tables of their own have one for each, and others none."""
    problems: list[Problem] = []
    for driver, table, rows in (("nanotec", "drive", actuator.drives), ("nmea2000", "motor", actuator.motors)):
        if actuator.driver == driver:
            served = {row.thruster for row in rows}
            driven = dict.fromkeys((*actuator.thrusters, *actuator.azimuths))
            problems += [(("driver",), f"needs an [[actuator.{table}]] for '{name}'") for name in driven if name not in served]
            if not driven:
                problems.append((("driver",), "drives nothing: name thrusters, or azimuths"))
        elif rows:
            problems.append(((table,), f"only for the driver '{driver}', not '{actuator.driver}'"))
    if actuator.driver == "nanotec" and actuator.thrusters:
        problems.append((("thrusters",), "this bridge drives azimuths alone: name them in 'azimuths', and another bridge for the propellers"))
    return problems


def _of_mavlink(actuator: ActuatorConfig, driven: Sequence[ThrusterConfig], turned: Collection[str]) -> list[Problem]:
    """`turned`: the thrusters whose azimuth is this bridge's."""
    if actuator.driver != "mavlink_servo":
        return [] if actuator.mavlink is None else [(("mavlink",), f"only for the driver 'mavlink_servo', not '{actuator.driver}'")]
    board = actuator.mavlink
    if board is None:
        return [(("driver",), "needs a table [actuator.mavlink] with the channels")]
    problems: list[Problem] = []
    if len(board.channels) != len(actuator.thrusters):
        problems.append((("mavlink", "channels"), f"needs {len(actuator.thrusters)} channels, one for each of the bridge's thrusters"))
    turns = [thruster.name in turned for thruster in driven]
    problems += [(("azimuths",), f"'{name}' is not among its thrusters") for name in actuator.azimuths if name not in actuator.thrusters]
    if [channel > 0 for channel in board.azimuth_channels or (0,) * len(turns)] != turns:
        problems.append((("mavlink", "azimuth_channels"), "needs one for each of the bridge's thrusters, 0 for those that it does not turn"))
    for key, numbers, names in (("servo_channels", board.servo_channels, actuator.servos), ("relays", board.relays, actuator.relays)):
        if len(numbers) != len(names):
            problems.append((("mavlink", key), f"needs {len(names)}, one for each of the bridge's {'servos' if key == 'servo_channels' else 'relays'}"))
    taken = [channel for channel in (*board.channels, *board.azimuth_channels, *board.servo_channels) if channel]
    wired = (*board.relays, *board.lamps)
    problems += [(("mavlink", "relays"), f"relay {number} is used twice") for number in sorted({n for n in wired if wired.count(n) > 1})]
    problems += [(("mavlink", "channels"), f"channel {channel} is used twice") for channel in sorted({c for c in taken if taken.count(c) > 1})]
    for thruster in driven:
        if thruster.name in turned and (thruster.azimuth_min_rad is None or thruster.azimuth_max_rad is None):
            problems.append((("mavlink", "azimuth_channels"), f"a servo turns '{thruster.name}' between stops: give it azimuth_min_deg and azimuth_max_deg"))
        if thruster.retractable:
            problems.append((("thrusters",), f"'{thruster.name}' is retractable, which this bridge cannot move"))
    if board.relays and not board.unguarded:
        text = "the board leaves its relays as they are when the companion falls silent: say unguarded = true if that hurts nobody"
        problems.append((("mavlink", "relays"), text))
    if board.method == "do_set_servo" and not board.unguarded:
        text = "with DO_SET_SERVO the board holds its last pulses when the companion falls silent: use 'override', or say unguarded = true"
        problems.append((("mavlink", "method"), text))
    return problems
