"""The console's page in a real browser, over a network that fails, and across a console that begins anew."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import threading
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from tests.browser import Browser, needs_browser
from tests.copies import Copy
from tests.unit.console.recorded import write_log
from tests.waiting import ended

pytestmark = [needs_browser, pytest.mark.process]


class Network:
    """Passes TCP connections on to a port. After `lose`, those that are open carry nothing and say nothing of it."""

    def __init__(self, port: int) -> None:
        self._port = port
        self._lost: set[int] = set()
        self._sockets: list[socket.socket] = []
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://localhost:{self._listener.getsockname()[1]}/"
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                near, _ = self._listener.accept()
                self._sockets.append(near)
                far = socket.create_connection(("127.0.0.1", self._port))
                self._sockets.append(far)
                for a, b in ((near, far), (far, near)):
                    threading.Thread(target=self._pass, args=(a, b), daemon=True).start()

    def _pass(self, source: socket.socket, sink: socket.socket) -> None:
        number = source.fileno()
        with contextlib.suppress(OSError):
            while data := source.recv(65536):
                if number not in self._lost:
                    sink.sendall(data)
            if number not in self._lost:
                sink.shutdown(socket.SHUT_WR)

    def lose(self) -> None:
        self._lost |= {one.fileno() for one in self._sockets}

    def cut(self) -> None:
        """End the connections that are open, for both ends to see."""
        for one in list(self._sockets):
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        for one in (self._listener, *self._sockets):
            one.close()


def served(*arguments: str, token: str | None = None) -> tuple[Copy, int]:
    """A console, and its port."""
    if token is not None:
        os.environ["USV_CONSOLE_TOKEN"] = token
    process = Copy(["console", *arguments])
    os.environ.pop("USV_CONSOLE_TOKEN", None)
    port = urlsplit(process.stdout.readline().split()[1]).port
    assert port is not None
    return process, port


def end(process: Copy) -> None:
    process.send_signal(signal.SIGINT)
    ended(process, "the console")


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    made = Browser(tmp_path_factory.mktemp("browser"), 400, 800)
    yield made
    assert made.close() == set()


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_log(tmp_path_factory.mktemp("log") / "log")


def test_a_page_comes_back_over_a_network_that_lost_its_connection(browser: Browser, log: Path) -> None:
    """It stayed stale until the browser found out by itself, if ever."""
    process, port = served(str(log), "--port=0")
    network = Network(port)
    browser.open(network.url)
    browser.wait("window.usvConsole?.model.tick", "the first tick")
    network.lose()
    browser.wait("document.body.classList.contains('stale')", "that the page says it is stale")
    assert browser.run("return usvConsole.model.tick !== null")
    browser.run("usvConsole.model.spoke_ms -= 60000")  # as if it had been silent for a minute
    browser.wait("!document.body.classList.contains('stale')", "that the page is back")
    browser.open("about:blank")
    network.close()
    end(process)


def test_a_page_that_was_open_when_its_files_changed_loads_them(browser: Browser, log: Path) -> None:
    process, port = served(str(log), "--port=0")
    network = Network(port)
    browser.open(network.url)
    browser.wait("window.usvConsole?.model.tick", "the first tick")
    browser.click("#tabs [data-view=strips]")
    browser.run(
        "window.old = true; const parse = JSON.parse;"
        "JSON.parse = (text) => { const m = parse(text); if (m.kind === 'hello') m.console.page = 'newer'; return m; }"
    )
    network.cut()
    browser.wait("!window.old && window.usvConsole?.model.tick", "the page anew")
    assert browser.run("return document.body.dataset.view") == "strips"
    browser.open("about:blank")
    network.close()
    end(process)


def test_a_page_whose_console_begins_anew_asks_for_the_token(browser: Browser, log: Path) -> None:
    """It tried to connect for ever, and said no more than that it was stale."""
    process, port = served(str(log), "--port=0", "--host=0.0.0.0", token="one")
    browser.open(f"http://localhost:{port}/")
    browser.run("$('#token').value = 'one'; $('#login button').click()")
    browser.wait("window.usvConsole?.model.tick", "the first tick")
    end(process)
    process, _ = served(str(log), f"--port={port}", "--host=0.0.0.0", token="two")
    browser.wait("$('#login')", "the login")
    end(process)
