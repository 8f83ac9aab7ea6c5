"""A real Chromium, headless, for tests of pages. It talks to this machine only, and its network is on record."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service

from tests.waiting import wait_until

_BROWSER, _DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
has_browser = _BROWSER is not None and _DRIVER is not None
needs_browser = pytest.mark.skipif(
    not has_browser, reason="needs Debian's chromium and chromium-driver; `.ci/run` installs them"
)
_OPTIONS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE localhost",  # the browser's own services stay at home
    "--disable-features=OptimizationHints,MediaRouter,AutofillServerCommunication",
)
_LOCAL = re.compile(r"^(127\.0\.0\.1|\[::1\]|localhost)(:\d+)?$")


class Browser:
    """One window. `run` is JavaScript in the page; `$` there is `document.querySelector`."""

    def __init__(self, folder: Path, width: int = 1280, height: int = 800) -> None:
        self._netlog = folder / "netlog.json"
        options = Options()
        options.binary_location = str(_BROWSER)
        for option in (*_OPTIONS, f"--user-data-dir={folder / 'profile'}", f"--log-net-log={self._netlog}"):
            options.add_argument(option)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=Service(str(_DRIVER)))
        self.resize(width, height)

    def resize(self, width: int, height: int) -> None:
        self.driver.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride",
            {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600},
        )

    def open(self, url: str) -> None:
        self.driver.get(url)

    def run(self, script: str, *arguments: Any) -> Any:
        return self.driver.execute_script(f"const $ = (s) => document.querySelector(s); {script}", *arguments)

    def wait(self, script: str, what: str) -> Any:
        """Until the expression is true."""
        return wait_until(lambda: self.run(f"return {script}"), what)

    def click(self, selector: str) -> None:
        self.run("$(arguments[0]).click()", selector)

    def text(self, selector: str) -> str:
        return str(self.run("return $(arguments[0]).textContent", selector))

    def complaints(self) -> Sequence[str]:
        """What the page wrote to the browser's console as errors and warnings."""
        return [row["message"] for row in self.driver.get_log("browser") if row["level"] in ("SEVERE", "WARNING")]

    def close(self) -> set[str]:
        """End the browser. Returns what lies beyond this machine: addresses to which it connected by TCP, and addresses
        that a page asked for, whether it got there or not. (What the browser asks for on its own has no initiator.)"""
        self.driver.quit()
        log = _whole(self._netlog.read_text(encoding="utf-8"))
        kinds = {number: name for name, number in log["constants"]["logEventTypes"].items()}
        asked = set()
        requests = 0
        for event in log["events"]:
            kind, params = kinds[event["type"]], event.get("params", {})
            if kind == "TCP_CONNECT_ATTEMPT" and "address" in params:
                asked.add(str(params["address"]))
            elif kind == "URL_REQUEST_START_JOB" and str(params.get("initiator", "")).startswith("http"):
                requests += 1
                asked.add(urlsplit(params["url"]).netloc)
        assert requests, "the network's record has no request of a page"
        return {address for address in asked if not _LOCAL.match(address)}


def _whole(text: str) -> dict[str, Any]:
    """A netlog, which a browser that ends in a hurry leaves open."""
    try:
        return json.loads(text)  # type: ignore[no-any-return]
    except json.JSONDecodeError:
        return json.loads(text.rstrip().rstrip(",") + "]}")  # type: ignore[no-any-return]
