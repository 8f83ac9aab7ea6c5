"""What must be true of bridges and of the calibration of their drives."""

from __future__ import annotations

from companion.config.actuators import BRIDGES
from companion.config.bridges import OutputConfig
from companion.config.devices import ActuatorConfig, ThrusterConfig
from companion.config.kinds import BridgeKind, Equipment, Problem, foreign_problems

_SHORTEST_US, _LONGEST_US = 500.0, 2500.0


def bridge_problems(equipment: Equipment) -> list[Problem]:
    """Faults of all bridges and of `[thruster.output]`, with their places. Of a driver that is not in the table `io`
    judges: it may be a plug-in."""
    problems: list[Problem] = []
    for i, bridge in enumerate(equipment.bridges):
        if (kind := BRIDGES.get(bridge.driver)) is not None:
            problems += foreign_problems(bridge, ("actuator", i), BRIDGES)
            problems += problems_of_kind(bridge, i, kind, equipment)
    return problems


def problems_of_kind(bridge: ActuatorConfig, i: int, kind: BridgeKind, equipment: Equipment) -> list[Problem]:
    """Faults of the i-th bridge, which is of that kind, and of the calibration of its drives."""
    problems = kind.problems(bridge, ("actuator", i), equipment)
    for k, thruster in enumerate(equipment.thrusters):
        if thruster.output is not None and thruster.name in bridge.thrusters:
            problems += [
                (("thruster", k, "output", key), text)
                for key, text in _of_output(thruster.output, thruster, kind.pulses)
            ]
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
