"""Who is let in: hosts, origins, tokens, and the headers of every answer; over real requests."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest
from aiohttp import ClientSession, TCPConnector, web
from aiohttp.client_exceptions import WSServerHandshakeError

from companion.console.doors import POLICY
from companion.console.replay import Recording
from companion.console.server import STATIC, Console, Settings
from companion.console.tiles import open_tiles
from tests.unit.console.recorded import write_log
from tests.unit.console.test_tiles import tiles_file

TOKEN = "a token of the test"
Talk = Callable[[ClientSession, str], Awaitable[Any]]


def asked(settings: Settings, talk: Talk) -> Any:
    """What `talk(session, address)` returns, with a console on a free port."""

    async def served() -> Any:
        runner = web.AppRunner(Console(settings).application(), access_log=None)
        await runner.setup()
        site = web.TCPSite(runner, "127.0.0.1", 0)
        await site.start()
        host, port = runner.addresses[0][:2]
        try:
            async with ClientSession(cookie_jar=None) as session:
                return await talk(session, f"http://{host}:{port}")
        finally:
            await runner.cleanup()

    return asyncio.run(served())


def statuses(settings: Settings, *requests: tuple[str, str, dict[str, Any]]) -> list[int]:
    async def talk(session: ClientSession, url: str) -> list[int]:
        found = []
        for method, path, more in requests:
            more = {**more, "headers": {k: v.format(own=url) for k, v in more.get("headers", {}).items()}}
            async with session.request(method, url + path, **more) as answer:
                found.append(answer.status)
        return found

    return asked(settings, talk)  # type: ignore[no-any-return]


OWN = {"Origin": "{own}"}
HOLD = {"json": {"order": "hold"}}
NETWORK = Settings(control=True, host="0.0.0.0", token=TOKEN)
HERE = Settings(control=True)


def test_another_site_in_the_same_browser_commands_nothing() -> None:
    assert (
        statuses(
            HERE,
            ("POST", "/api/order", {**HOLD, "headers": {"Origin": "http://evil.example"}}),
            ("POST", "/api/order", HOLD),  # no origin at all
            ("POST", "/api/order", {**HOLD, "headers": {"Origin": "null"}}),
            ("GET", "/api/stream", {"headers": {"Origin": "http://evil.example"}}),
            ("GET", "/api/stream", {}),
        )
        == [403] * 5
    )


def test_a_name_bent_to_this_address_opens_nothing() -> None:
    bent = {"Host": "evil.example", "Origin": "http://evil.example"}
    assert statuses(HERE, ("POST", "/api/order", {**HOLD, "headers": bent}), ("GET", "/", {"headers": bent})) == [
        403,
        403,
    ]


def test_an_order_is_json_and_in_the_table() -> None:
    assert statuses(
        HERE,
        ("POST", "/api/order", {"data": '{"order": "hold"}', "headers": {**OWN, "Content-Type": "text/plain"}}),
        ("POST", "/api/order", {"json": {"order": "terminate"}, "headers": OWN}),
        ("POST", "/api/order", {"data": "{", "headers": {**OWN, "Content-Type": "application/json"}}),
        ("POST", "/api/order", {"json": [1], "headers": OWN}),
    ) == [415, 400, 400, 400]


def test_without_a_boat_an_order_says_so_and_without_control_it_is_refused() -> None:
    own = {**HOLD, "headers": OWN}
    assert statuses(HERE, ("POST", "/api/order", own)) == [409]
    assert statuses(Settings(), ("POST", "/api/order", own)) == [403]


def test_an_order_that_was_long_under_way_is_not_sent_unless_it_stops_the_boat() -> None:
    """The network held it for a minute, and then the boat moved."""

    async def texts(session: ClientSession, url: str) -> list[str]:
        found = []
        for order in ("arm", "disarm", "hold"):
            asked_s = asyncio.get_running_loop().time() - 60.0
            order_json = {"order": order, "at_s": asked_s}
            async with session.post(url + "/api/order", json=order_json, headers={"Origin": url}) as answer:
                found.append((await answer.json())["text"].partition(":")[0])
        return found

    assert asked(HERE, texts) == ["came too late, and was not sent", "no link to the boat", "no link to the boat"]


def test_a_page_that_must_log_in_can_tell() -> None:
    assert statuses(NETWORK, ("HEAD", "/", {}), ("GET", "/", {})) == [401, 401]
    assert statuses(HERE, ("HEAD", "/", {}), ("GET", "/", {})) == [200, 200]


def test_beyond_this_computer_nothing_goes_without_the_token() -> None:
    own = {**HOLD, "headers": OWN}
    login = ("POST", "/api/login", {"json": {"token": TOKEN}, "headers": OWN})
    wrong = ("POST", "/api/login", {"json": {"token": "guess"}, "headers": OWN})
    from_afar = ("POST", "/api/login", {"json": {"token": TOKEN}, "headers": {"Origin": "http://evil.example"}})
    forged = {**own, "headers": {**OWN, "Cookie": "usv_console_80=forged; usv_console=forged"}}
    assert statuses(
        NETWORK,
        ("POST", "/api/order", own),
        ("GET", "/api/stream", {"headers": OWN}),
        ("GET", "/tiles/1/0/0", {}),
        ("POST", "/api/order", forged),
        wrong,
        from_afar,
        ("POST", "/api/order", own),
    ) == [401, 401, 401, 401, 401, 403, 401]

    async def logged_in(session: ClientSession, url: str) -> tuple[int, str, int]:
        method, path, more = login
        async with session.request(method, url + path, json=more["json"], headers={"Origin": url}) as answer:
            status, cookie = answer.status, answer.headers["Set-Cookie"]
        headers = {"Origin": url, "Cookie": cookie.partition(";")[0]}
        async with session.post(url + "/api/order", json={"order": "hold"}, headers=headers) as answer:
            return status, cookie, answer.status

    status, cookie, order = asked(NETWORK, logged_in)
    assert status == 200 and "HttpOnly" in cookie and "SameSite=Strict" in cookie
    assert order == 409  # let in; there is no boat


async def _login(session: ClientSession, url: str, token: str, **more: Any) -> tuple[int, str]:
    """Status, and the cookie."""
    async with session.post(url + "/api/login", json={"token": token}, headers={"Origin": url}, **more) as answer:
        return answer.status, answer.headers.get("Set-Cookie", "").partition(";")[0]


def test_two_consoles_on_one_computer_keep_their_logins() -> None:
    """A browser sends the cookies of both to each, whatever the port: the one logged the other out."""

    async def talk(session: ClientSession, url: str) -> None:
        own = f"http://127.0.0.1:{int(url.rpartition(':')[2])}"
        other = "http://127.0.0.1:8081"
        _, cookie = await _login(session, own, TOKEN)
        async with session.post(
            own + "/api/login", json={"token": TOKEN}, headers={"Origin": other, "Host": "127.0.0.1:8081"}
        ) as answer:
            beside = answer.headers["Set-Cookie"].partition(";")[0]
        assert beside.partition("=")[0] == "usv_console_8081" != cookie.partition("=")[0]
        jar = dict([cookie.split("="), (beside.partition("=")[0], "of the other console")])
        headers = {"Cookie": "; ".join(f"{name}={value}" for name, value in jar.items())}
        async with session.get(own + "/", headers=headers) as answer:
            assert answer.status == 200

    asked(NETWORK, talk)


def test_wrong_tokens_at_once_do_not_share_one_wait() -> None:
    """64 guesses took the half second of one; and another address is not made to wait for them."""

    async def talk(session: ClientSession, url: str) -> None:
        guesses = await asyncio.gather(*(_login(session, url, f"guess {n}") for n in range(8)))
        assert sorted(status for status, _ in guesses) == [401, *[429] * 7]
        wrong = asyncio.create_task(_login(session, url, "guess"))
        async with ClientSession(connector=TCPConnector(local_addr=("127.0.0.2", 0))) as elsewhere:
            while (await _login(session, url, TOKEN))[0] != 429:
                pass
            assert (await _login(elsewhere, url, TOKEN))[0] == 200
        assert (await wrong)[0] == 401
        assert (await _login(session, url, TOKEN))[0] == 200

    asked(NETWORK, talk)


def test_every_answer_has_the_policy_and_no_door_for_other_sites() -> None:
    async def headers(session: ClientSession, url: str) -> list[Any]:
        found = []
        for path in ("/", "/static/main.js", "/static/../server.py", "/api/stream", "/nothing"):
            async with session.get(url + path) as answer:
                found.append(answer.headers)
        async with session.options(url + "/api/order", headers={"Origin": "http://evil.example"}) as answer:
            found.append(answer.headers)
        return found

    for found in asked(HERE, headers):
        assert found["Content-Security-Policy"] == POLICY
        assert "Access-Control-Allow-Origin" not in found
    assert "unsafe" not in POLICY and "http" not in POLICY


def test_tiles_come_from_the_file(tmp_path: Path) -> None:
    tiles = open_tiles(tiles_file(tmp_path / "chart.mbtiles"))

    async def tile(session: ClientSession, url: str) -> Any:
        async with session.get(f"{url}/tiles/3/4/6") as found, session.get(f"{url}/tiles/3/4/5") as missing:
            return found.status, found.content_type, await found.read(), missing.status

    assert asked(Settings(tiles=tiles), tile) == (200, "image/png", b"\x89PNG tile", 404)


def test_a_page_gets_its_stream(tmp_path: Path) -> None:
    settings = Settings(log=Recording(write_log(tmp_path / "log", seconds=2)))

    async def first(session: ClientSession, url: str) -> Any:
        async with session.ws_connect(url + "/api/stream", headers={"Origin": url}) as stream:
            return await stream.receive_json()

    assert asked(settings, first)["kind"] == "hello"

    async def foreign(session: ClientSession, url: str) -> Any:
        async with session.ws_connect(url + "/api/stream", headers={"Origin": "http://evil.example"}) as stream:
            return await stream.receive_json()

    with pytest.raises(WSServerHandshakeError, match="403"):
        asked(settings, foreign)


def test_no_file_of_the_page_names_an_address_elsewhere() -> None:
    for path in STATIC.iterdir():
        text = path.read_text(encoding="utf-8").replace("http://www.w3.org/2000/svg", "")
        for forbidden in ("http://", "https://", "//cdn", "@import", "eval(", "innerHTML", "style="):
            assert forbidden not in text, f"{path.name}: {forbidden}"
