"""The controller with the baseline laws in it, chosen by DP_LAW and WP_LAW."""

from __future__ import annotations

from companion.baselines.positioning import ThesisPositioning
from companion.baselines.tracking import ThesisTracking
from companion.config.vessel import VesselConfig
from companion.control.controller import Controller
from companion.params.store import Parameters


def controller_with_baselines(config: VesselConfig, parameters: Parameters) -> Controller:
    """The companion's controller, which can switch to two baseline laws: positioning of the ReVolt thesis, and path
    tracking of the ÅBOAT thesis."""
    return Controller(
        config, parameters, ThesisPositioning(config, parameters), ThesisTracking(config.limits, parameters)
    )
