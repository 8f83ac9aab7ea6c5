"""A page is sent no more than its network carries: three batches that it has not answered."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from aiohttp import ClientSession, ClientWebSocketResponse, web

from companion.console.pace import Pace
from companion.console.server import Console, Settings
from tests.unit.console.test_board import HELLO, ticked


def test_three_batches_are_under_way_at_most() -> None:
    async def paced() -> None:
        pace = Pace(0.0)
        beats = [pace.beat(float(n)) for n in range(3)]
        waiting = asyncio.create_task(pace.room())
        await asyncio.sleep(0)
        assert not waiting.done()
        pace.take({"beat": beats[0]["number"]}, 2.5)
        await waiting
        assert pace.beat(3.0)["round_s"] == 2.5

    asyncio.run(paced())


@pytest.mark.parametrize("answer", [{}, {"beat": 99}, {"beat": "1"}, {"beat": None}])
def test_what_is_no_answer_counts_for_nothing(answer: dict[str, Any]) -> None:
    pace = Pace(0.0)
    pace.beat(0.0)
    pace.take(answer, 5.0)
    assert pace.round_s == 0.0 and pace.lives(9.0) and not pace.lives(10.0)


def test_a_page_that_answers_lives() -> None:
    pace = Pace(0.0)
    number = pace.beat(0.0)["number"]
    pace.take({"beat": number}, 8.0)
    assert pace.lives(17.0)


async def _beats(stream: ClientWebSocketResponse, count: int) -> list[int]:
    found = []
    while len(found) < count:
        message = await stream.receive_json()
        if message["kind"] == "beat":
            found.append(message["number"])
    return found


def test_a_slow_page_gets_the_newest_tick_and_not_all_that_came_meanwhile() -> None:
    """Through 2.5 kB/s the page showed, as live, what was 12 s old, and later still."""

    async def talk() -> float:
        console = Console(Settings())
        runner = web.AppRunner(console.application(), access_log=None)
        await runner.setup()
        await web.TCPSite(runner, "127.0.0.1", 0).start()
        host, port = runner.addresses[0][:2]
        url = f"http://{host}:{port}"
        console.board.take(dict(HELLO))
        async with ClientSession() as session, session.ws_connect(url + "/api/stream", headers={"Origin": url}) as page:
            numbers: list[int] = []
            for n in range(3):
                console.board.take(ticked(float(n)))
                numbers += await _beats(page, 1)
            for n in range(3, 50):
                console.board.take(ticked(float(n)))
                await asyncio.sleep(0)
            await page.send_json({"beat": numbers[0]})
            while (message := await page.receive_json())["kind"] != "tick":
                pass
        await runner.cleanup()
        return float(message["row"]["t_s"])

    assert asyncio.run(talk()) == 49.0
