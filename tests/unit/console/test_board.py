"""What pages get: every event, and of all else the newest."""

from __future__ import annotations

import asyncio
import json
from typing import Any

import pytest

from companion.app import load_vessel
from companion.config.vessel import as_dict
from companion.console.board import Board, Page
from companion.record.feed_schema import TickEncoder
from tests.unit.record.ticks import tick

HELLO = {"kind": "hello", "configuration": as_dict(load_vessel("revolt"))}


def ticked(t_s: float) -> dict[str, Any]:
    message = TickEncoder(("port", "bow"), ("gnss", "imu")).message(tick(t_s), 1, 0)
    return {**message, "row": {**message["row"], "t_s": t_s}}


def taken(page: Page) -> list[dict[str, Any]]:
    return [json.loads(text) for text in asyncio.run(page.take())]


def test_a_page_that_stalls_gets_the_newest_tick_and_every_event() -> None:
    board, page = Board({}), Page()
    board.take(dict(HELLO))
    board.welcome(page)
    taken(page)
    for n in range(5):
        board.take(ticked(float(n)))
        board.take({"kind": "event", "text": f"event {n}", "t_s": float(n)})
    got = taken(page)
    assert [m["text"] for m in got if m["kind"] == "event"] == [f"event {n}" for n in range(5)]
    assert [m["row"]["t_s"] for m in got if m["kind"] == "tick"] == [4.0]


def test_a_new_page_gets_what_is_known_in_the_order_in_which_it_can_use_it() -> None:
    board = Board({"control": False})
    board.take(dict(HELLO))
    board.take({"kind": "boat", "parameters": {}})
    board.take(ticked(1.0))
    board.tell("capability", {"from_rad": None})
    page = Page()
    board.welcome(page)
    assert [m["kind"] for m in taken(page)] == ["hello", "boat", "history", "tick", "capability"]


def test_a_boat_that_begins_anew_has_no_past() -> None:
    board, page = Board({}), Page()
    board.take(dict(HELLO))
    board.take(ticked(100.0))
    board.take(ticked(1.0))
    board.welcome(page)
    history = next(m for m in taken(page) if m["kind"] == "history")
    assert history["t_s"] == [1.0]


def test_a_page_that_opens_after_the_boat_has_ended_is_told_how_old_the_tick_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It showed the tick as live, and counted its age from when the page was opened."""
    now_s = 50.0
    monkeypatch.setattr("companion.console.board.time.monotonic", lambda: now_s)
    board, page = Board({}), Page()
    board.take(dict(HELLO))
    board.take(ticked(1.0))
    now_s = 3650.0
    board.welcome(page)
    assert next(m for m in taken(page) if m["kind"] == "tick")["age_s"] == 3600.0


def test_a_page_for_which_nothing_comes_takes_nothing() -> None:
    assert asyncio.run(Page().take(0.0)) == []
