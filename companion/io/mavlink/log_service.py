"""LOG_REQUEST_*: the list of runs, and one file of each: its ULog, or where a run has none its .tlog.

Numbers run from 0, on links of the ardupilot dialect from 1, as their clients expect; they stay what they are until the list is asked for again.
Source: MAVLink guide, log messages; QGroundControl asks for 512 blocks of 90 bytes at a time and again for what is missing, MAVSDK for
128, MAVProxy for all and wants an empty block behind a file that ends on a block's border.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any

from companion.core.types import Severity
from companion.io.mavlink import messages as mavlink
from companion.io.mavlink.disk_files import DiskFile, Run, Shelf
from companion.io.mavlink.hub import Handler, Hub, Peer

BLOCK = 90
_ALL = 0xFFFFFFFF
_MOST_CLIENTS = 8
_SHARE = 0.5  # of the line
_FRAME_BYTES = 97 + 14
_SAVED_S = 0.25
_IDLE_S = 60.0
_MOST_RUNS = 1000  # the newest of them


@dataclass(slots=True)
class _Client:
    """`runs`: as they were last listed. `sending`: (next offset, end) of what was asked for."""

    used_s: float
    runs: list[Run] | None = None
    asked: tuple[int, int] | None = None  # a listing that waits for the disk
    listing: Future[list[Run]] | None = None
    number: int | None = None
    file: DiskFile | None = None
    opening: Future[DiskFile | None] | None = None
    sending: tuple[int, int] | None = None
    to_the_end: bool = False  # all was asked for: an empty block says where a file ends that fills its last one
    allowance: float = 0.0
    allowed_s: float | None = None


class LogService:
    """In: LOG_REQUEST_LIST, LOG_REQUEST_DATA, LOG_REQUEST_END, LOG_ERASE (refused). Out: LOG_ENTRY, LOG_DATA, to who asked.

    Remembers each client's list, its open file, and how far that has been sent.
    """

    def __init__(self, hub: Hub, shelf: Shelf | None) -> None:
        """`shelf` None: nothing is logged."""
        self._hub = hub
        self._shelf = shelf
        self._clients: dict[Peer, _Client] = {}
        self.handles: Mapping[int, Handler] = {
            mavlink.MAVLINK_MSG_ID_LOG_REQUEST_LIST: self._on_list,
            mavlink.MAVLINK_MSG_ID_LOG_REQUEST_DATA: self._on_data,
            mavlink.MAVLINK_MSG_ID_LOG_REQUEST_END: self._on_end,
            mavlink.MAVLINK_MSG_ID_LOG_ERASE: self._on_erase,
        }

    def update(self, now_s: float) -> None:
        """Send what has been waited for, and what is due."""
        for peer, client in list(self._clients.items()):
            if peer.endpoint.gone or now_s - client.used_s > _IDLE_S * self._hub.patience:
                self._forget(peer)
                continue
            self._advance(peer, client, now_s)

    def close(self) -> None:
        for peer in list(self._clients):
            self._forget(peer)
        if self._shelf is not None:
            self._shelf.close()

    def _on_list(self, message: Any, peer: Peer, now_s: float) -> None:
        client = self._client(peer, now_s)
        if client is None:
            return
        client.asked = (message.start, message.end)
        client.sending = None
        if self._shelf is not None:
            client.listing = self._shelf.runs(_MOST_RUNS)
        else:
            client.runs = []
        self._advance(peer, client, now_s)

    def _on_data(self, message: Any, peer: Peer, now_s: float) -> None:
        client = self._client(peer, now_s)
        if client is None or self._shelf is None:
            return
        if client.runs is None:
            if client.listing is None:
                client.listing = self._shelf.runs(_MOST_RUNS)
            return  # it will ask again
        index = message.id - peer.endpoint.dialect.first_item
        if not 0 <= index < len(client.runs):
            self._hub.say(peer, Severity.WARNING, f"No log {message.id}: ask for the list again")
            return
        if client.number != message.id:
            self._shut(client)
            client.number = message.id
            client.opening = self._shelf.open(client.runs[index].path)
        size = client.runs[index].size
        end = size if message.count == _ALL else min(size, message.ofs + message.count)
        client.to_the_end = message.count == _ALL
        client.sending = (message.ofs, end) if message.ofs < size else None
        if client.sending is None and client.to_the_end:
            self._send(peer, client, message.ofs, b"")
        self._advance(peer, client, now_s)

    def _on_end(self, message: Any, peer: Peer, now_s: float) -> None:
        client = self._clients.get(peer)
        if client is not None:
            client.sending = None
            self._shut(client)

    def _on_erase(self, message: Any, peer: Peer, now_s: float) -> None:
        self._hub.say(peer, Severity.WARNING, "Logs are not erased over a link; the oldest go by themselves with --log-limit")

    # --- steps -----------------------------------------------------------------------------------------------------

    def _advance(self, peer: Peer, client: _Client, now_s: float) -> None:
        if client.listing is not None and client.listing.done():
            client.runs, client.listing = client.listing.result(), None
        if client.asked is not None and client.runs is not None and client.listing is None:
            self._send_list(peer, client.runs, *client.asked)
            client.asked = None
        if client.opening is not None and client.opening.done():
            client.file, client.opening = client.opening.result(), None
            if client.file is None:
                client.sending = client.number = None
                self._hub.say(peer, Severity.WARNING, "That log is not there any more: ask for the list again")
        if client.file is not None and client.sending is not None:
            self._stream(peer, client, client.file, now_s)

    def _send_list(self, peer: Peer, runs: list[Run], start: int, end: int) -> None:
        """One entry a run, or a single empty one where there is none."""
        first = peer.endpoint.dialect.first_item
        if not runs:
            self._hub.send(peer, mavlink.MAVLink_log_entry_message(0, 0, 0, 0, 0))
        last = first + len(runs) - 1
        for number, run in enumerate(runs, first):
            if start <= number <= end:
                self._hub.send(peer, mavlink.MAVLink_log_entry_message(number, len(runs), last, run.begun_unix_s, min(run.size, _ALL)))

    def _stream(self, peer: Peer, client: _Client, file: DiskFile, now_s: float) -> None:
        rate = _SHARE * peer.endpoint.bytes_per_s
        elapsed_s = _SAVED_S if client.allowed_s is None else max(0.0, now_s - client.allowed_s)
        client.allowed_s = now_s
        client.allowance = min(max(_SAVED_S * rate, 2.0 * _FRAME_BYTES), client.allowance + elapsed_s * rate)
        while client.sending is not None and client.allowance >= _FRAME_BYTES and not peer.endpoint.busy:
            offset, end = client.sending
            try:
                data = file.read(offset, min(BLOCK, end - offset))
            except OSError as error:
                client.sending = None
                self._hub.say(peer, Severity.WARNING, f"Log not readable: {error.strerror or error}")
                return
            if data is None:
                return
            self._send(peer, client, offset, data)
            client.used_s = now_s
            client.allowance -= _FRAME_BYTES
            offset += len(data)
            client.sending = (offset, end) if data and offset < end else None
            if client.sending is None and client.to_the_end and len(data) == BLOCK:
                self._send(peer, client, offset, b"")

    def _send(self, peer: Peer, client: _Client, offset: int, data: bytes) -> None:
        number = client.number if client.number is not None else 0
        self._hub.send(peer, mavlink.MAVLink_log_data_message(number, offset, len(data), data.ljust(BLOCK, b"\0")))

    # --- clients ---------------------------------------------------------------------------------------------------

    def _client(self, peer: Peer, now_s: float) -> _Client | None:
        client = self._clients.get(peer)
        if client is None:
            if len(self._clients) >= _MOST_CLIENTS:
                self._hub.say(peer, Severity.WARNING, "Too many clients fetch logs now")
                return None
            client = self._clients[peer] = _Client(now_s)
        client.used_s = now_s
        return client

    def _forget(self, peer: Peer) -> None:
        self._shut(self._clients.pop(peer))

    @staticmethod
    def _shut(client: _Client) -> None:
        if client.file is not None:
            client.file.close()
        client.file = client.opening = client.number = None
