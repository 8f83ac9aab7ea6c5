"""The page reckons places as the boat does: what is picked on it is where the boat goes."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from companion.core.geodesy import LocalFrame
from tests.browser import Browser, needs_browser
from tests.protocol.test_console import console
from tests.unit.console.recorded import write_log

pytestmark = [needs_browser, pytest.mark.process]


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """A browser with a log open, that stands still."""
    folder = tmp_path_factory.mktemp("places")
    made = Browser(folder, 800, 600)
    with console(str(write_log(folder / "log", seconds=2))) as page:
        made.open(page.url)
        made.wait("window.usvConsole?.model.boat && usvConsole.model.tick?.replay.playing === false", "the log's end")
        yield made
        made.open("about:blank")
    assert made.close() == set()


@pytest.mark.parametrize("lat_deg, lon_deg", [(59.0, 10.0), (78.2, 15.6), (-16.8, 179.999), (-16.8, -179.999)])
@pytest.mark.parametrize("north_m, east_m", [(30.0, -400.0), (-4000.0, 5000.0), (2000.0, -5000.0)])
def test_a_picked_point_is_the_boats(
    browser: Browser, lat_deg: float, lon_deg: float, north_m: float, east_m: float
) -> None:
    """At 78°N it lay 9 m off, 5 km from home; beyond the 180th meridian it was refused or drawn round the Earth."""
    lat, lon, north, east = browser.run(
        "const [lat_deg, lon_deg, north_m, east_m] = arguments; usvConsole.model.boat.frame = { lat_deg, lon_deg };"
        "return import('/static/model.js').then(({ toGeodetic, toNed }) => {"
        " const at = toGeodetic(north_m, east_m); return [...at, ...toNed(...at)]; })",
        lat_deg,
        lon_deg,
        north_m,
        east_m,
    )
    assert abs(lon) <= 180.0
    assert LocalFrame(lat_deg, lon_deg).to_ned(lat, lon) == pytest.approx((north_m, east_m), abs=0.002)
    assert (north, east) == pytest.approx((north_m, east_m), abs=0.002)


def test_the_chart_at_the_180th_meridian_has_its_graticule(browser: Browser) -> None:
    browser.run("usvConsole.model.boat.frame = { lat_deg: -16.8, lon_deg: 179.9999 }")
    browser.click("#tabs [data-view=chart]")
    texts = browser.run(  # the first picture fits the view to the boat, whenever it is drawn
        "usvConsole.redraw();"
        "Object.assign(usvConsole.chartView, { follow: false, fitted: false, perM: 0.4, centre: [0, 0] });"
        "usvConsole.redraw();"
        "return [...document.querySelectorAll('#chart-graticule text')].map((one) => one.textContent)"
    )
    assert any(text.endswith("′W") for text in texts) and any(text.endswith("′E") for text in texts), texts
