"""The console in a real browser: on a boat that sails, and on its log."""

from __future__ import annotations

import contextlib
import json
import math
import signal
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.record.signing_file import write_signing
from tests.browser import Browser, needs_browser
from tests.copies import Copy
from tests.protocol.process import Companion
from tests.unit.console.recorded import REVOLT, write_log
from tests.waiting import CAP_S, ended, wait_until

pytestmark = [needs_browser, pytest.mark.process]
_SIGMA_95 = 2.4477


class ConsoleProcess:
    """`companion console` with these arguments, on a free port."""

    def __init__(self, *arguments: str) -> None:
        self.process = Copy(["console", "--port=0", *arguments])
        first = self.process.stdout.readline()
        assert first.startswith("console: "), f"{first} {self.process.communicate()}"
        self.url = first.split()[1]

    def close(self) -> None:
        self.process.send_signal(signal.SIGINT)
        _, errors = ended(self.process, "the console")
        assert self.process.returncode == 0 and not errors, errors


@contextlib.contextmanager
def console(*arguments: str) -> Iterator[ConsoleProcess]:
    made = ConsoleProcess(*arguments)
    try:
        yield made
    finally:
        made.close()


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """One browser for all tests here. In the end: no packet went beyond this machine."""
    made = Browser(tmp_path_factory.mktemp("browser"))
    yield made
    assert made.close() == set()


class OtherStation:
    """Another ground station, on TCP."""

    def __init__(self, port: int) -> None:
        self._socket = socket.create_connection(("127.0.0.1", port), timeout=60.0)
        self._codec = mavlink.MAVLink(None, srcSystem=200, srcComponent=190)
        self._codec.robust_parsing = True

    def command(self, number: int, *params: float) -> int:
        """Send a command; its result."""
        seven = (*params, *(0.0,) * 7)[:7]
        message = mavlink.MAVLink_command_long_message(1, 1, number, 0, *seven)
        self._socket.sendall(bytes(message.pack(self._codec)))
        while True:
            for got in self._codec.parse_buffer(self._socket.recv(65536)) or ():
                if got.get_type() == "COMMAND_ACK" and got.command == number:
                    return int(got.result)

    def close(self) -> None:
        self._socket.close()


def pixel_of(browser: Browser, selector: str) -> tuple[float, float]:
    """The middle of what is drawn there, in pixels of the scene."""
    x, y = browser.run(
        "const b = $(arguments[0]).getBoundingClientRect(), s = $('#dp').getBoundingClientRect();"
        "return [b.x + b.width / 2 - s.x, b.y + b.height / 2 - s.y]",
        selector,
    )
    return float(x), float(y)


def per_metre(browser: Browser) -> float:
    """Pixels a metre, by the scale bar as it is drawn."""
    box = browser.run("const b = $('#dp-scale').getBBox(); return [b.width, Number($('#dp-scale').dataset.m)]")
    return float(box[0] / box[1])


def test_a_log_is_drawn_where_it_says(browser: Browser, tmp_path: Path) -> None:
    log = write_log(tmp_path / "log")
    with console(str(log)) as page:
        browser.open(page.url)
        browser.wait("window.usvConsole?.model.tick", "the first tick")
        seek(browser, 20.0)
        k = per_metre(browser)
        yaw = math.radians(20.0)
        check_hull(browser, k, yaw)
        check_thrust(browser, yaw)
        check_ellipses(browser, k)
        check_values(browser)
        check_sail(browser)
        check_rudder(browser)
        browser.click("#tabs [data-view=chart]")
        browser.wait("$('#chart-hull').getAttribute('points')", "the boat on the chart")
        check_chart(browser)
        check_breach(browser)
        check_long_name(browser)
        check_many_waypoints(browser)
        check_fit(browser)
        check_traffic(browser)
        check_old_sense(browser)
        check_large_forces(browser)
        browser.click("#tabs [data-view=strips]")
        browser.wait("document.querySelectorAll('#strips section:not([hidden]) canvas').length >= 4", "the strips")
        error = browser.text('[data-strip="Position error"] .head')
        assert f"position error {math.hypot(1.0, 4.0):.2f}" in error
        events = browser.run("return [...$('#jump').options].map((o) => o.textContent)")
        assert len(events) == 5 and "Hold: off at 25" in events[3]
        browser.run("$('#jump').selectedIndex = 3; $('#jump').dispatchEvent(new Event('change'))")
        browser.wait("usvConsole.model.tick.row.t_s === 25", "the event's time")
        browser.click("#play")
        browser.wait("usvConsole.model.tick.row.t_s > 25.3", "that it plays")
        assert not browser.complaints()
        browser.open("about:blank")


def test_the_views_have_their_whole_names_on_a_phone(browser: Browser, tmp_path: Path) -> None:
    """Of *Command* the last letter was cut off."""
    with console(str(write_log(tmp_path / "log", seconds=2))) as page:
        browser.open(page.url)
        browser.wait("window.usvConsole?.model.tick", "the first tick")
        browser.run("$('#tab-command').hidden = false")
        cut = []
        for width in (360, 320):
            browser.resize(width, 740)
            cut += browser.run(
                "return [...$('#tabs').children].filter((b) => b.scrollWidth > b.clientWidth).map((b) => b.textContent)"
            )
        browser.resize(1280, 800)
        browser.open("about:blank")
    assert cut == []


def check_chart(browser: Browser) -> None:
    """The boat is where the chart has (2, 2), and the trail behind it is as long as the way it came."""
    drawn = browser.run(
        "usvConsole.redraw(); const b = $('#chart-hull').getBBox(), s = $('#chart-scale').getBBox(),"
        "t = $('#chart-trail-line').getTotalLength();"
        "return [b.x + b.width / 2, b.y + b.height / 2, ...usvConsole.chartPixel(2, 2), t, s.width / $('#chart-scale').dataset.m]"
    )
    x, y, u, v, trail, k = drawn
    assert (x, y) == pytest.approx((u, v), abs=6.0)  # a bow is sharper than a stern
    assert trail == pytest.approx(2.0 * math.sqrt(2.0) * k, abs=4.0)


def check_breach(browser: Browser) -> None:
    """A boat outside its fence is told so for as long as it is there, is in the picture, and the line is as an alarm."""
    alarm = "(await import('/static/state.js')).alarm"
    told = browser.driver.execute_async_script(
        f"const done = arguments[0]; (async () => {{ const alarm = {alarm}; done(["
        "alarm('', null), alarm('fence', null), alarm('fence;sticks_lost', { breached: false }),"
        "alarm('sticks_lost;fence', { breached: true }), alarm('', { breached: true })]); })()"
    )
    assert told == [
        "",
        "Failsafe: fence",
        "Failsafe: fence ahead, sticks lost",
        "Failsafe: sticks lost, outside the fence",
        "Outside the fence",
    ]
    colours, (x, y), (width, height) = browser.run(
        "const model = usvConsole.model, kept = [model.boat, model.tick];"
        "model.boat = { ...model.boat, fence: [{ points: [[9, 9]], radius_m: 5, inclusion: true }] };"
        "const colour = (breached, north_m) => { model.tick = { ...kept[1], row: { ...kept[1].row, north_m },"
        " more: { ...kept[1].more, fence: { breached } } }; usvConsole.redraw();"
        " return getComputedStyle($('#chart-fence').firstChild).stroke; };"
        "const drawn = [colour(false, 2), colour(true, 900)], b = $('#chart-hull').getBBox();"
        "const s = $('#chart').getBoundingClientRect(), found = [drawn, [b.x, b.y], [s.width, s.height]];"
        "[model.boat, model.tick] = kept; usvConsole.redraw(); return found;"
    )
    assert colours[0] != colours[1]
    assert 0.0 < x < width and 0.0 < y < height


def check_long_name(browser: Browser) -> None:
    """A long name makes room for a failsafe, which is read whole, and pushes nothing out of the bar."""
    name = browser.text("#vessel")
    browser.run("$('#vessel').textContent = arguments[0]", "Rowing boat with two trolling motors, " * 4)
    for width in (1280, 900):
        browser.resize(width, 800)
        cut, boxes = browser.run(
            "const f = $('#failsafes'); f.hidden = false;"
            "f.textContent = 'Failsafe: position lost, battery critical, battery low';"
            "const b = (s) => { const r = $(s).getBoundingClientRect(); return [r.left, r.right]; };"
            "return [f.scrollWidth > f.clientWidth || f.scrollHeight > f.clientHeight,"
            " ['#vessel', '#mode', '#armed', '#failsafes', '#clock', '#age', '#palette'].map(b)]"
        )
        assert not cut
        edges = [edge for box in boxes for edge in box]
        assert edges == sorted(edges) and edges[-1] <= width, f"{width}: {boxes}"
    browser.resize(1280, 800)
    browser.run("$('#vessel').textContent = arguments[0]; usvConsole.redraw()", name)


def check_many_waypoints(browser: Browser) -> None:
    """Of 200 waypoints that lie close together no two numbers cover each other, and the one ahead has its number."""
    numbers = browser.run(
        "const model = usvConsole.model, kept = [model.boat, model.tick];"
        "const mission = [...Array(200).keys()].map((i) => ({ number: i + 1, seq: i, north_m: 6 * (i % 10), east_m: 5 * Math.floor(i / 10) }));"
        "model.boat = { ...kept[0], mission };"
        "model.tick = { ...kept[1], row: { ...kept[1].row, mode: 'Mission', mission_seq: 87, north_m: 300 } };"
        "$('#chart-tools [data-do=fit]').click(); usvConsole.redraw();"
        "const shown = [...document.querySelectorAll('#chart-places [data-item]')].filter((m) => m.lastChild.getClientRects().length);"
        "const found = shown.map((m) => { const r = m.firstChild.getBoundingClientRect();"
        " return [Number(m.dataset.item), r.x + r.width / 2, r.y + r.height / 2]; });"
        "[model.boat, model.tick] = kept; $('#chart-tools [data-do=fit]').click(); return found;"
    )
    assert 10 < len(numbers) < 200 and 88 in [number for number, _, _ in numbers]
    least = min(math.dist(a[1:], b[1:]) for i, a in enumerate(numbers) for b in numbers[:i])
    assert least >= 19.0, least  # the diameter of a mark


def check_fit(browser: Browser) -> None:
    """Fit shows the berth and the leader, too. Both were out of the picture."""
    places, (width, height) = browser.run(
        "const model = usvConsole.model, kept = [model.boat, model.tick];"
        "model.boat = { ...kept[0], berth: { boat: [-70, -80, 0] } };"
        "const leader = { north_m: 150, east_m: 60, north_mps: 0, east_mps: 0, yaw_rad: 0 };"
        "model.tick = { ...kept[1], more: { ...kept[1].more, leader } };"
        "$('#chart-tools [data-do=fit]').click();"
        "const s = $('#chart').getBoundingClientRect(), found = [[usvConsole.chartPixel(-70, -80), usvConsole.chartPixel(150, 60)], [s.width, s.height]];"
        "[model.boat, model.tick] = kept; $('#chart-tools [data-do=fit]').click(); return found;"
    )
    assert all(0.0 < x < width and 0.0 < y < height for x, y in places), places


def check_old_sense(browser: Browser) -> None:
    """A sense that has been silent is not told as taken."""
    browser.click("#tabs [data-view=state]")
    words = browser.run(
        "const model = usvConsole.model, kept = [model.boat, model.tick];"
        "model.boat = { ...kept[0], sources: { position: 'gnss', heading: 'imu' } };"
        "const judged = [['position', 14.2], ['heading', 0.1]].map(([sense, age_s]) => ({ sense, age_s, accepted: true, square: 4, limit: 16 }));"
        "model.tick = { ...kept[1], more: { ...kept[1].more, judged } }; usvConsole.redraw();"
        "const found = [...document.querySelectorAll('#s-senses tr')].map((r) => r.lastChild.textContent);"
        "[model.boat, model.tick] = kept; usvConsole.redraw(); return found;"
    )
    assert words == ["the last one 14\xa0s ago", "taken, 0.5 of its gate"]
    rates = browser.run(
        "const model = usvConsole.model, kept = model.tick; for (const [s, n] of [[0, 0], [9, 99], [18, 198]]) {"
        " const health = [{ name: 'gnss', ok: true, age_s: null, text: `${n} NMEA sentences` }], row = { ...kept.row, t_s: kept.row.t_s + s };"
        " model.tick = { ...kept, row, more: { ...kept.more, health } }; usvConsole.redraw(); }"
        "const found = [...document.querySelectorAll('#s-devices td:nth-child(4)')].map((c) => c.textContent);"
        "model.tick = kept; usvConsole.redraw(); return found;"
    )
    assert rates == [""], "a log has not the words of each moment, of which a rate could be made"
    browser.click("#tabs [data-view=chart]")


def check_traffic(browser: Browser) -> None:
    """A vessel that sends neither speed nor course has dashes, and no closest approach; its label is not under the
    buttons. It was shown as if it stood still with its bow north."""
    labels = browser.run(
        "const model = usvConsole.model, kept = model.tick, f = kept.more, far = (x, y) => {"
        " const v = usvConsole.chartView; return [v.centre[0] - (y - v.h / 2) / v.perM, v.centre[1] + (x - v.w / 2) / v.perM]; };"
        "const tools = $('#chart-tools').getBoundingClientRect(), s = $('#chart').getBoundingClientRect();"
        "const [n, e] = far(tools.left - s.left + 20, tools.bottom - s.top + 4);"
        "const home = model.boat.frame ?? model.hello.configuration.home, lat_deg = home.lat_deg + n / 111400,"
        " lon_deg = home.lon_deg + e / (111400 * Math.cos(home.lat_deg * Math.PI / 180));"
        "const traffic = [{ mmsi: 1, name: 'A', lat_deg, lon_deg, course_rad: null, speed_mps: null, heading_rad: null, length_m: null, age_s: 1 }];"
        "model.tick = { ...kept, more: { ...f, traffic } }; usvConsole.redraw();"
        "const texts = [...document.querySelectorAll('#chart-labels text')].slice(-2);"
        "const found = texts.map((t) => { const r = t.getBoundingClientRect(); return [t.textContent, r.left < tools.right && r.right > tools.left && r.top < tools.bottom - 2]; });"
        "model.tick = kept; usvConsole.redraw(); return found;"
    )
    assert [text for text, _ in labels] == ["A – –", labels[1][0]]
    assert labels[1][0].endswith("off, course not known")
    assert not any(under for _, under in labels), labels


def check_large_forces(browser: Browser) -> None:
    """The forces of a strong boat fit; a sideways force of a boat that has none to give is no full bar."""
    overfull, share = browser.run(
        "const model = usvConsole.model, kept = [model.hello, model.tick], c = kept[0].configuration;"
        "model.hello = { ...kept[0], configuration: { ...c, limits: { surge_n: 2000, sway_n: 0, yaw_nm: 2000 } } };"
        "const forces = {}; for (const of of ['achieved', 'demanded'])"
        " Object.assign(forces, { [`${of}_surge_n`]: -1234.5, [`${of}_sway_n`]: 134.2, [`${of}_yaw_nm`]: -1234.5 });"
        "model.tick = { ...kept[1], row: { ...kept[1].row, ...forces } }; usvConsole.redraw();"
        "const bars = [...document.querySelectorAll('#values .bar')];"
        "const found = [bars.map((b) => b.lastChild).filter((v) => v.scrollWidth > v.clientWidth).map((v) => v.textContent),"
        " Number(bars[1].querySelector('.given').getAttribute('width'))];"
        "[model.hello, model.tick] = kept; usvConsole.redraw(); return found;"
    )
    assert not overfull
    assert share == pytest.approx(100.0 * 134.2 / 2000.0, abs=0.1)


def check_sail(browser: Browser) -> None:
    """Of a sailing rig the page shows sheet and rudder. It showed the square of the sheet as newtons, and sectors around
    the mast in which the rudder cannot stand."""
    words, label, sectors, blade, centre, k = browser.run(
        "const model = usvConsole.model, kept = [model.hello, model.tick], c = kept[0].configuration;"
        "const rig = { ...c.thrusters[0], name: 'rig', kind: 'sail', x_m: 0, azimuth_min_rad: -0.7, azimuth_max_rad: 0.7,"
        " sail: { attack_max_rad: null }, rudder: { x_m: -1 } };"
        "model.hello = { ...kept[0], configuration: { ...c, thrusters: [rig] } };"
        "const row = { ...kept[1].row, yaw_rad: 0, rig_throttle: 0.5, rig_force_n: 2, rig_azimuth_rad: 0.5 * Math.PI, rig_condition: 'ready' };"
        "model.tick = { ...kept[1], row, more: { ...kept[1].more, feedback: [null] } }; usvConsole.redraw();"
        "const bar = document.querySelectorAll('#values .bar')[3], l = $('#dp-blade-0');"
        "const found = [bar.lastChild.textContent, bar.firstChild.textContent, $('#dp-sectors').children.length,"
        " [l.x1, l.y1, l.x2, l.y2].map((v) => v.baseVal.value), usvConsole.pixel(row.north_m, row.east_m), usvConsole.dpView.perM];"
        "[model.hello, model.tick] = kept; usvConsole.redraw(); return found;"
    )
    assert (words, label, sectors) == ("50\xa0%  90°", "rig: sheet, rudder", 0)
    x1, y1, x2, y2 = blade
    assert (x1, y1) == pytest.approx((centre[0], centre[1] + k), abs=0.5)  # a metre astern
    assert x2 < x1 and y2 == pytest.approx(y1, abs=0.5)  # the blade to port, which pushes the stern to starboard


def check_rudder(browser: Browser) -> None:
    """Of a propeller with a rudder the page shows the blade as it stands, and its stops. It showed a red disc around the
    stern: the part of a whole turn that the blade does not reach."""
    sectors, blade, stops, centre, k = browser.run(
        "const model = usvConsole.model, kept = [model.hello, model.tick], c = kept[0].configuration;"
        "const screw = { ...c.thrusters[0], name: 'screw', kind: 'rudder', sail: null, x_m: -1, y_m: 0.2, forbidden_rad: [],"
        " azimuth_min_rad: -0.5, azimuth_max_rad: 0.5 };"
        "model.hello = { ...kept[0], configuration: { ...c, thrusters: [screw] } };"
        "const row = { ...kept[1].row, yaw_rad: 0, screw_throttle: 0.5, screw_force_n: 2, screw_azimuth_rad: 0.5, screw_condition: 'ready' };"
        "model.tick = { ...kept[1], row, more: { ...kept[1].more, feedback: [null] } }; usvConsole.redraw();"
        "const l = $('#dp-blade-0'), found = [document.querySelectorAll('#dp-sectors .forbidden').length,"
        " [l.x1, l.y1, l.x2, l.y2].map((v) => v.baseVal.value), $('#dp-sectors .stops').getAttribute('d'),"
        " usvConsole.pixel(row.north_m, row.east_m), usvConsole.dpView.perM];"
        "[model.hello, model.tick] = kept; usvConsole.redraw(); return found;"
    )
    assert sectors == 0
    x1, y1, x2, y2 = blade
    assert (x1, y1) == pytest.approx((centre[0] + 0.2 * k, centre[1] + k), abs=0.5)
    assert math.atan2(x1 - x2, y2 - y1) == pytest.approx(0.5, abs=0.02)  # astern, to port: it pushes the stern away
    rays = [tuple(map(float, part.replace("L", " ").split())) for part in stops.split("M")[1:]]
    assert [math.atan2(x - u, v - y) for x, y, u, v in rays] == pytest.approx([-0.5, 0.5], abs=0.02)


def seek(browser: Browser, t_s: float) -> None:
    """Stop a log there, drawn."""
    browser.run("if ($('#play').textContent === 'Pause') $('#play').click()")
    browser.wait("usvConsole.model.tick.replay.playing === false", "that it stands")
    browser.run(
        "const s = $('#slide'); s.value = arguments[0]; s.dispatchEvent(new Event('input'));"
        "s.dispatchEvent(new Event('change'))",
        t_s,
    )
    browser.wait(f"usvConsole.model.tick.row.t_s === {t_s}", "the time")
    browser.run("usvConsole.redraw()")


def check_hull(browser: Browser, k: float, yaw: float) -> None:
    """The boat is at (2, 2), its reference at (1, −2), to scale, and turned."""
    x, y = pixel_of(browser, "#dp-origin")
    width, height = browser.run("const b = $('#dp').getBoundingClientRect(); return [b.width, b.height]")
    assert (x, y) == pytest.approx((width / 2, height / 2), abs=1.0)  # centred on the boat
    u, v = browser.run("return usvConsole.pixel(1, -2)")
    tx, ty = pixel_of(browser, "#dp-target")
    assert (tx, ty) == pytest.approx((u, v), abs=1.5)
    assert (tx - x, ty - y) == pytest.approx((-4.0 * k, 1.0 * k), abs=2.0)  # 4 m west and 1 m south
    corners = [
        tuple(map(float, p.split(",")))
        for p in browser.run("return $('#dp-hull-outline').getAttribute('points')").split()
    ]
    bow = max(corners, key=lambda p: (p[0] - x) * math.sin(yaw) - (p[1] - y) * math.cos(yaw))
    half = 0.5 * REVOLT.length_m * k
    assert (bow[0] - x, bow[1] - y) == pytest.approx((half * math.sin(yaw), -half * math.cos(yaw)), abs=1.0)
    beams = [(px - x) * math.cos(yaw) + (py - y) * math.sin(yaw) for px, py in corners]
    assert max(beams) - min(beams) == pytest.approx(REVOLT.beam_m * k, abs=1.0)


def check_thrust(browser: Browser, yaw: float) -> None:
    """Vectors begin at their thrusters, and are as long and as turned as the commands."""
    scale = float(browser.run("return $('#dp-thrusters').dataset.pxPerN"))
    commands = ((20.0, math.radians(30.0)), (-10.0, math.radians(-60.0)), (7.0, 0.5 * math.pi))
    for i, (force, azimuth) in enumerate(commands):
        tail = browser.run(
            "const l = $(`#dp-thrust-${arguments[0]}`), h = l.nextElementSibling;"
            "const [x, y] = h.getAttribute('points').split(' ')[0].split(',').map(Number);"
            "return [x - l.x1.baseVal.value, y - l.y1.baseVal.value]",
            i,
        )
        angle = yaw + azimuth
        assert tail == pytest.approx([scale * force * math.sin(angle), -scale * force * math.cos(angle)], abs=0.5)


def check_ellipses(browser: Browser, k: float) -> None:
    """One sigma and 95 % of 0.25 m on both axes."""
    for name, times in (("sigma1", 1.0), ("sigma95", _SIGMA_95)):
        axes = browser.run("const e = $(arguments[0]); return [e.rx.baseVal.value, e.ry.baseVal.value]", f"#dp-{name}")
        assert axes == pytest.approx([times * 0.25 * k] * 2, rel=0.01)


def check_values(browser: Browser) -> None:
    assert browser.text("#mode") == "Hold" and browser.text("#armed") == "Armed"
    assert browser.text("#v-error") == "4.12\xa0m"
    assert browser.text("#v-heading") == "020.0°"
    assert browser.text("#v-turn") == f"{20.0 - math.degrees(0.3):.1f}°"


def test_what_a_page_orders_the_boat_does(browser: Browser, tmp_path: Path) -> None:
    links = (f"tcpin:127.0.0.1:{free()}",)
    with Companion(tmp_path, links=links) as boat, console(f"--state={tmp_path / 'state'}", "--control") as page:
        browser.open(page.url)
        browser.wait("window.usvConsole?.model.boat && !$('#tab-command').hidden", "the boat")
        browser.click("#tab-command")
        wait_until(lambda: any(row["position_valid"] == row["heading_valid"] == "1" for row in boat.rows()), "a fix")
        ordered(browser, '#modes [data-mode="Hold"]', "Hold: done")
        ordered(browser, "#o-arm", "Arm: done")
        wait_until(lambda: last(boat)["armed"] == "1" and last(boat)["mode"] == "Hold", "the boat's own log")
        go_to(browser, boat)
        check_live_views(browser)
        upright = (
            "return [...document.querySelectorAll('#dial text')].every((t) => Math.abs(t.getScreenCTM().b) < 1e-6)"
        )
        assert browser.run(upright)
        check_anew(browser)
        trim(browser)
        check_operator_control(browser, boat, int(links[0].rpartition(":")[2]))
        check_catamaran(browser)
        check_phone(browser)
        browser.resize(1280, 800)
        assert boat.process is not None
        boat.process.send_signal(signal.SIGSTOP)
        browser.wait("document.body.classList.contains('stale')", "that silence shows")
        crossed = browser.run("return getComputedStyle($('#mode')).textDecorationLine")
        browser.click("#tabs [data-view=state]")
        words = browser.run(
            "return [...document.querySelectorAll('#s-words li, #s-devices td, #s-arming p')]"
            ".filter((e) => getComputedStyle(e).textDecorationLine !== 'line-through').map((e) => e.textContent)"
        )
        assert not words
        boat.process.send_signal(signal.SIGCONT)
        assert crossed == "line-through"
        browser.wait("!document.body.classList.contains('stale')", "that it lives again")
        complaints = [text for text in browser.complaints() if "409" not in text]  # refused orders, on purpose
        assert not complaints
        browser.open("about:blank")


def free() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def last(boat: Companion) -> dict[str, str]:
    return boat.rows()[-1]


def ordered(browser: Browser, selector: str, answer: str) -> None:
    """Press a button once it is there, and wait for the answer on the page."""
    browser.wait(f"$({selector!r})", selector)
    browser.click(selector)
    browser.wait(f"$('#said').textContent.startsWith({answer.partition(':')[0]!r}) && $('#said').className", answer)
    assert browser.text("#said").startswith(answer)


def go_to(browser: Browser, boat: Companion) -> None:
    """A click into the picture, 60 pixels right of the boat, becomes the boat's target."""
    browser.click("#o-pick")
    x, y = pixel_of(browser, "#dp-origin")
    browser.run(
        "const s = $('#dp'), b = s.getBoundingClientRect();"
        "for (const kind of ['pointerdown', 'pointerup']) s.dispatchEvent(new PointerEvent(kind, "
        "{ pointerId: 1, clientX: b.x + arguments[0], clientY: b.y + arguments[1], bubbles: true }))",
        x + 60.0,
        y,
    )
    browser.wait("$('#dp-ghost-hull').style.display !== 'none' && !$('#o-go').disabled", "the ghost")
    east_m = 60.0 / per_metre(browser)
    ordered(browser, "#o-go", "Go to: done")
    far = f"Math.abs(usvConsole.more().progress.target?.[1] - {east_m}) < 0.15 && usvConsole.more().progress.target"
    target = browser.wait(far, "the target")
    assert target[1] == pytest.approx(east_m, abs=0.15) and abs(target[0]) < 0.15
    wait_until(lambda: float(last(boat)["desired_east_m"] or 0.0) > 0.02, "that the reference moves")


def check_anew(browser: Browser) -> None:
    """A point that was picked before the boat began anew is forgotten: its metres may count from elsewhere now."""
    browser.click("#o-pick")
    browser.run(
        "const s = $('#dp'), b = s.getBoundingClientRect();"
        "for (const kind of ['pointerdown', 'pointerup']) s.dispatchEvent(new PointerEvent(kind, "
        "{ pointerId: 1, clientX: b.x + 200, clientY: b.y + 200, bubbles: true }))"
    )
    browser.wait("!$('#o-go').disabled", "the ghost")
    left = browser.run(
        "usvConsole.model.hello = { ...usvConsole.model.hello }; usvConsole.redraw(); usvConsole.redraw();"
        "return [$('#o-go').disabled, $('#dp-ghost-hull').style.display, $('#o-pick').className]"
    )
    assert left == [True, "none", ""]
    browser.wait("$('#modes [data-mode=\"Hold\"]')", "the modes")


def trim(browser: Browser) -> None:
    """A bandwidth that is set on the page is the boat's parameter."""
    browser.run("$('[data-trim=DP_BW_SWAY]').value = '0.33'; $('[data-trim=DP_BW_SWAY] + button').click()")
    browser.wait("Math.abs(usvConsole.model.boat.parameters.DP_BW_SWAY - 0.33) < 1e-6", "the parameter")


def check_live_views(browser: Browser) -> None:
    """What a log has not: the covariance, feedback, devices, arming, the polar."""
    axes = browser.run(
        "usvConsole.redraw(); const e = $('#dp-sigma1'), [a, b, c] = usvConsole.more().covariance_m2;"
        "return [Number(e.dataset.majorM), Number(e.dataset.minorM), a, b, c, e.ry.baseVal.value / usvConsole.dpView.perM]"
    )
    major, minor, nn, ne, ee, drawn = axes
    assert major * major + minor * minor == pytest.approx(nn + ee) and (major * minor) ** 2 == pytest.approx(
        nn * ee - ne * ne, rel=1e-6
    )
    assert drawn == pytest.approx(major, rel=1e-6)
    browser.click("#tabs [data-view=dp]")
    browser.wait("$('#polar-holds')", "the capability polar")
    without = browser.run(
        "const model = usvConsole.model, kept = model.capability, found = [];"
        "for (const told of [null, { from_rad: null }]) {"
        " model.capability = told; usvConsole.redraw(); found.push($('#polar').textContent); }"
        "model.capability = kept; usvConsole.redraw(); return found;"
    )
    assert without == ["–", "The vessel’s file has no wind areas."]  # not told yet, and told that there is none
    browser.click("#tabs [data-view=state]")
    browser.wait("$('#s-words')?.textContent.includes('Mode Hold: a ground station asked for it')", "the words")
    assert "gnss" in browser.text("#s-devices") and "imu" in browser.text("#s-senses")
    assert "no mission loaded" in browser.text("#s-arming") and "Draw a plan" in browser.text("#s-arming")
    assert "Armed" in browser.text("#event-list")
    browser.run("const f = $('#state input[type=search]'); f.value = 'armed'; f.dispatchEvent(new Event('input'))")
    rows: Any = browser.run("return [...document.querySelectorAll('#event-list tr')].map((r) => r.textContent)")
    assert rows and all("armed" in row.lower() for row in rows)
    browser.click("#tab-command")


def check_operator_control(browser: Browser, boat: Companion, port: int) -> None:
    """While another ground station has control nothing moves."""
    other = OtherStation(port)
    assert other.command(32100, 1.0, 0.0) == 0
    ordered(browser, '#modes [data-mode="Manual"]', "Manual: ")
    assert "system 200" in browser.text("#said") and browser.run("return $('#said').className") == "bad"
    ordered(browser, "#o-hold", "Hold here: ")
    assert browser.run("return $('#said').className") == "bad"
    assert last(boat)["mode"] == "Hold" and last(boat)["armed"] == "1"
    browser.wait("$('#control').textContent === 'Control: system 200'", "who has control")
    assert other.command(32100, 0.0) == 0
    other.close()


@pytest.mark.sweep
def test_only_a_console_with_the_key_commands_a_boat_that_asks_for_signatures(tmp_path: Path) -> None:
    state = tmp_path / "state"
    state.mkdir()
    write_signing(state, bytes(range(32)), 0)
    links = (f"tcpin:127.0.0.1:{free()}?signing=require",)
    with Companion(tmp_path, links=links) as boat, console(f"--state={state}", "--control") as page:
        wait_until(lambda: order(page.url, order="mode", mode="Heading") == 200, "the order")
        wait_until(lambda: last(boat)["mode"] == "Heading", "the boat's own log")
        (state / "signing.json").rename(tmp_path / "kept")
        with console(f"--state={state}", "--control") as keyless:
            wait_until(lambda: order(keyless.url, order="mode", mode="Hold") == 409, "that it knows the boat")
        (tmp_path / "kept").rename(state / "signing.json")
        assert last(boat)["mode"] == "Heading"


def order(url: str, **asked: str) -> int:
    """Ask a console for something; the status."""
    headers = {"Origin": url.rstrip("/"), "Content-Type": "application/json"}
    request = Request(f"{url}api/order", json.dumps(asked).encode(), headers)
    try:
        with urlopen(request, timeout=CAP_S) as answer:
            return int(answer.status)
    except HTTPError as error:
        error.close()
        return error.code


def check_catamaran(browser: Browser) -> None:
    """Two hulls as wide and as far apart as the file says, and all within length and beam."""
    boat = {"length_m": 4.0, "beam_m": 2.4, "hull": {"form": "catamaran", "hull_beam_m": 0.4, "hull_spacing_m": 2.0}}
    browser.run("import('/static/draw.js').then((draw) => { window.drawn = draw.outline(arguments[0]); })", boat)
    browser.wait("window.drawn", "the outline")
    line = browser.run("return window.drawn")
    assert max(abs(y) for _, y in line) == pytest.approx(1.2) and max(abs(x) for x, _ in line) == pytest.approx(2.0)
    assert {round(abs(y), 3) for x, y in line if x > 1.9999} == {1.0}  # the tips of the bows
    assert min(abs(y) for _, y in line) == pytest.approx(0.8)  # the inner sides, which the deck joins


def check_phone(browser: Browser) -> None:
    """On 390 by 844 pixels nothing is wider than the page, in any view, and no failsafe is cut off."""
    browser.resize(390, 844)
    assert browser.run(
        "const f = $('#failsafes'); f.hidden = false; f.textContent = 'Failsafe: position lost, heading lost, battery low';"
        "return f.scrollWidth <= f.clientWidth"
    )
    for view in ("dp", "chart", "strips", "state", "command"):
        browser.click(f"#tabs [data-view={view}]")
        browser.run("usvConsole.redraw()")
        wide = browser.run(
            "return [...document.querySelectorAll('body *')].filter((e) => e.getClientRects().length && "
            "!e.closest('svg, select, #news') && e.getBoundingClientRect().right > innerWidth + 0.5).map((e) => e.outerHTML.slice(0, 80))"
        )
        assert not wide, f"{view}: {wide}"
        assert browser.run("return document.scrollingElement.scrollWidth") <= 390
