"""The pages by which BlueOS and Cockpit find the extension."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping
from http.server import BaseHTTPRequestHandler
from importlib.metadata import PackageNotFoundError, version

from gcs_plugins.blueos import cockpit
from gcs_plugins.commands import ACTIONS

PORT = 8095  # BlueOS itself does not use it


def pages() -> Mapping[str, tuple[str, str]]:
    """Path → media type and text."""
    rows = "".join(
        f"<tr><td>{html.escape(a.label)}<td>{html.escape(a.text)}<td>{html.escape(a.where.value)}" for a in ACTIONS
    )
    page = f"<!doctype html><meta charset=utf-8><title>USV companion</title><h1>USV companion</h1><table>{rows}</table>"
    return {
        "/": ("text/html; charset=utf-8", page),
        "/register_service": ("application/json", json.dumps(_service())),
        "/cockpit_extras.json": ("application/json", cockpit.text()),
    }


def _service() -> dict[str, object]:
    try:
        number = version("usv-companion")
    except PackageNotFoundError:
        number = "0.0.0"
    return {
        "name": "USV companion",
        "description": "Autopilot for small uncrewed boats: dynamic positioning, waypoints, leader following",
        "icon": "mdi-ferry",
        "company": "USV companion",
        "version": number,
        "webpage": "",
        "api": "",
        "works_in_relative_paths": True,
        "extras": {"cockpit": "/cockpit_extras.json"},
    }


class Handler(BaseHTTPRequestHandler):
    """Answers GET of `pages`, nothing else."""

    def do_GET(self) -> None:
        """Send the page of this path, or 404."""
        found = pages().get(self.path.partition("?")[0])
        if found is None:
            self.send_error(404)
            return
        kind, text = found
        data = text.encode()
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(data)))
        self.send_header("Access-Control-Allow-Origin", "*")  # Cockpit is a page of another origin
        self.end_headers()
        self.wfile.write(data)

    def log_message(self, format: str, *args: object) -> None:
        """Log nothing: BlueOS asks every few seconds."""
