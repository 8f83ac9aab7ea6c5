"""What of a run's weather is more than the boat holds by its file: a run that failed may have asked too much of it."""

from __future__ import annotations

from collections.abc import Mapping

from companion.analysis.static_limits import static_limits
from companion.config.vessel import VesselConfig


def more_than_it_holds(config: VesselConfig, settings: Mapping[str, str]) -> str:
    """One sentence with the remedy; empty where `wind` and `current`, each by itself, are within what it holds."""
    from sitl.environment import parse_directed
    from sitl.gusts import parse_wind

    limits = static_limits(config)
    if limits is None:
        return ""
    wind, current = settings.get("wind"), settings.get("current")
    wind_mps = parse_wind(wind)[0] if wind else 0.0
    current_mps = parse_directed(current)[0] if current else 0.0
    given = (("wind", wind_mps, limits.wind.held), ("current", current_mps, limits.current.held))
    beyond = [(name, value, most) for name, value, most in given if value > most]
    if not beyond:
        return ""
    said = " and ".join(f"{name} of {value:g} m/s, of which it holds {most:.2g}" for name, value, most in beyond)
    keys = ", ".join(f"--set {name}=" for name, _, _ in beyond)
    return f"note: {said} (companion check prints it): try less, {keys}"
