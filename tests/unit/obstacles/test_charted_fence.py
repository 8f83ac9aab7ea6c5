"""The fence and the chart together."""

from __future__ import annotations

from shapely.geometry import box

from companion.config.vessel import find, load
from companion.core.events import EventLog
from companion.core.geodesy import LocalFrame
from companion.fence.guard import FenceGuard
from companion.mission.plan import Plans
from companion.obstacles.chart_water import ChartKeeper
from companion.obstacles.charted_fence import ChartedFence
from companion.params.store import Parameters
from companion.params.table import table_of
from tests.unit.obstacles.charted import feature

OTTER = load(find("otter"))
HOME = LocalFrame(OTTER.home.lat_deg, OTTER.home.lon_deg)


def test_where_a_mission_has_switched_the_fence_off_the_chart_still_counts() -> None:
    parameters, events, plans = Parameters(OTTER.parameters, table_of(OTTER)), EventLog(), Plans()
    fence = FenceGuard(OTTER, parameters, plans, events, lambda: HOME, lambda: None)
    chart = ChartKeeper(OTTER, parameters, lambda: HOME, [feature("land", box(20.0, -10.0, 40.0, 10.0), frame=HOME)])
    charted = ChartedFence(OTTER, parameters, plans, lambda: HOME, fence, chart).now
    assert charted.point_refusal(30.0, 0.0, fenced=False) == "in a chart obstacle"
    assert charted.line_refusal([(0.0, 0.0), (60.0, 0.0)], fenced=False) == "way crosses a chart obstacle"
    assert charted.line_refusal([(0.0, 30.0), (60.0, 30.0)], fenced=False) is None
