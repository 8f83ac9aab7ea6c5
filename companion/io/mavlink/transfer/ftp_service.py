"""MAVLink FTP, read-only: lists, opens, reads and streams the files of a `FileTree` to several clients.

Source: MAVLink guide, "File Transfer Protocol". Every request is answered at once, or when the work for it is done:
silence costs a client seconds of retries (MAVProxy waits 11 s before it requests parameters one by one). Clients differ
from the guide: QGroundControl repeats a request with the same number, MAVSDK with a new one, and pymavlink ignores
answers with another session than its own.
"""

from __future__ import annotations

import contextlib
import struct
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from companion.io.mavlink.transfer.disk_files import Entry, abandon
from companion.io.mavlink.transfer.file_tree import FileTree, OpenFile
from companion.io.mavlink.transfer.ftp_codec import LARGEST_DATA, FtpError, FtpRequest, Opcode, ack, nak, parse
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.hub import Handler, Hub, Peer
from companion.io.mavlink.wire.yielding import to_yield

_MOST_CLIENTS, _MOST_SESSIONS, _SESSIONS_OF_ONE = 16, 16, 4
_IDLE_S = 60.0
_YIELD_S = 5.0  # a file of which nothing was read for so long makes room for another client's
_BURST_CHUNKS = 256  # after them the client has to ask for more: it may be gone
_SHARE = 0.5  # of the line, for bursts; the rest is for telemetry
_FRAME_BYTES = 263 + 14  # of one answer on the line
_SAVED_S = 0.25  # for which an unused share is saved up
_U32 = struct.Struct("<I")

_WRITING = frozenset(
    {
        Opcode.CREATE_FILE,
        Opcode.WRITE_FILE,
        Opcode.REMOVE_FILE,
        Opcode.CREATE_DIRECTORY,
        Opcode.REMOVE_DIRECTORY,
        Opcode.OPEN_FILE_WO,
        Opcode.TRUNCATE_FILE,
        Opcode.RENAME,
    }
)


@dataclass(slots=True)
class _Burst:
    """A file that is streamed to a client: number and offset of the next answer, and how many answers are left."""

    request: FtpRequest
    seq: int
    offset: int
    left: int = _BURST_CHUNKS


@dataclass(slots=True)
class _Session:
    """An open file of a client."""

    file: OpenFile
    used_s: float  # when it was opened, or last delivered something
    burst: _Burst | None = None


@dataclass(frozen=True, slots=True)
class _Waiting:
    """A request that waits for the disk or for long work: how to see that it is ready, how to answer it then, and what
    to do if nobody wants the answer any more."""

    request: FtpRequest
    ready: Callable[[], bool]
    answer: Callable[[], bytes]
    drop: Callable[[], object]


@dataclass(slots=True)
class _FtpClient:
    """`last`: number, opcode and answer of its last request; a repeated request gets the same answer."""

    used_s: float
    sessions: dict[int, _Session] = field(default_factory=dict)
    last: tuple[int, int, bytes] | None = None
    waiting: _Waiting | None = None
    allowance: float = 0.0
    allowed_s: float | None = None


class FtpService:
    """Answers FILE_TRANSFER_PROTOCOL requests. Remembers each client's open files and the bursts to it."""

    def __init__(self, hub: Hub, tree: FileTree) -> None:
        self._hub = hub
        self._tree = tree
        self._clients: dict[Peer, _FtpClient] = {}
        self.handles: Mapping[int, Handler] = {mavlink.MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL: self._on_request}

    def answer(self, now_s: float) -> None:
        """Answer requests whose work is done."""
        for peer, client in list(self._clients.items()):
            self._answer_waiting(peer, client)

    def update(self, now_s: float) -> None:
        """Answer requests that waited for the disk, continue the bursts, forget clients that are gone."""
        for peer, client in list(self._clients.items()):
            if peer.endpoint.gone or now_s - client.used_s > _IDLE_S * self._hub.patience:
                self._forget(peer)
                continue
            self._answer_waiting(peer, client)
            self._stream(peer, client, now_s)

    def close(self) -> None:
        """Close all open files."""
        for peer in list(self._clients):
            self._forget(peer)

    # --- requests --------------------------------------------------------------------------------------------------

    def _on_request(self, message: Any, peer: Peer, now_s: float) -> None:
        request = parse(bytes(message.payload))
        if request is None:
            return
        client = self._client(peer, now_s)
        if client is None:
            self._send(peer, nak(request, FtpError.NO_SESSIONS_AVAILABLE))
            return
        client.used_s = now_s
        if client.last is not None and client.last[:2] == (request.seq, request.opcode):
            self._send(peer, client.last[2])
            return
        if client.waiting is not None and client.waiting.request == request:
            return
        self._drop_waiting(client)
        client.last = None
        for session in client.sessions.values():
            session.burst = None
        self._carry_out(peer, client, request)
        self._stream(peer, client, now_s)

    def _carry_out(self, peer: Peer, client: _FtpClient, request: FtpRequest) -> None:
        """Answer a request, or begin to wait for the disk."""
        path, persona = request.path or "", peer.endpoint.persona
        error = _refusal(request)
        if error is not None:
            self._reply(peer, client, request, nak(request, error))
            return
        match request.opcode:
            case Opcode.TERMINATE_SESSION:
                self._end(client, request.session)
                self._reply(peer, client, request, ack(request))
            case Opcode.RESET_SESSIONS:
                for number in list(client.sessions):
                    self._end(client, number)
                self._reply(peer, client, request, ack(request))
            case Opcode.LIST_DIRECTORY:
                self._after(peer, client, request, self._tree.entries(path, persona), _listing)
            case Opcode.OPEN_FILE_RO | Opcode.CALC_FILE_CRC32:
                opens = request.opcode == Opcode.OPEN_FILE_RO
                answer = self._opened(peer, client) if opens else self._summed(peer, client)
                opening = self._tree.open(path, persona)
                self._after(peer, client, request, opening, answer, partial(abandon, opening))
            case Opcode.READ_FILE | Opcode.BURST_READ_FILE:
                self._read(peer, client, request)
            case _:
                self._reply(peer, client, request, ack(request))

    def _read(self, peer: Peer, client: _FtpClient, request: FtpRequest) -> None:
        """READ_FILE, or the begin of a burst."""
        session = client.sessions.get(request.session)
        if session is None:
            self._reply(peer, client, request, nak(request, FtpError.INVALID_SESSION))
        elif request.offset >= session.file.size:
            self._reply(peer, client, request, nak(request, FtpError.EOF))
        elif request.opcode == Opcode.BURST_READ_FILE:
            session.burst = _Burst(request, request.seq + 1, request.offset)
        else:
            file, count = session.file, min(request.size, LARGEST_DATA)
            session.used_s = client.used_s
            waiting = _Waiting(
                request,
                lambda: file.read(request.offset, count) is not None,
                lambda: ack(request, file.read(request.offset, count) or b""),
                lambda: None,
            )
            self._wait(peer, client, waiting)

    def _opened(self, peer: Peer, client: _FtpClient) -> Callable[[FtpRequest, OpenFile | None], bytes | None]:
        """The answer to an open. A session already in use is opened again: the client may have missed the first
        answer."""

        def answer(request: FtpRequest, file: OpenFile | None) -> bytes | None:
            if file is None:
                return nak(request, FtpError.FILE_NOT_FOUND)
            self._end(client, request.session)
            if len(client.sessions) >= _SESSIONS_OF_ONE or not self._has_room(peer, client.used_s):
                file.close()
                return nak(request, FtpError.NO_SESSIONS_AVAILABLE)
            client.sessions[request.session] = _Session(file, client.used_s)
            return ack(request, _U32.pack(min(file.size, 0xFFFFFFFF)))

        return answer

    def _summed(self, peer: Peer, client: _FtpClient) -> Callable[[FtpRequest, OpenFile | None], bytes | None]:
        """The answer to a checksum request. Computing it takes time, so a second wait begins."""

        def answer(request: FtpRequest, file: OpenFile | None) -> bytes | None:
            if file is None:
                return nak(request, FtpError.FILE_NOT_FOUND)
            crc = file.crc32()
            file.close()
            self._after(peer, client, request, crc, lambda asked, value: ack(asked, _U32.pack(value)))
            return None

        return answer

    # --- waiting for the disk --------------------------------------------------------------------------------------

    def _after(
        self,
        peer: Peer,
        client: _FtpClient,
        request: FtpRequest,
        future: Future[Any],
        answer: Callable[[FtpRequest, Any], bytes | None],
        drop: Callable[[], object] | None = None,
    ) -> None:
        """Answer with the result of `future` as soon as it is there."""
        self._wait(
            peer,
            client,
            _Waiting(request, future.done, lambda: answer(request, future.result()) or b"", drop or future.cancel),
        )

    def _wait(self, peer: Peer, client: _FtpClient, waiting: _Waiting) -> None:
        """Answer as soon as it is ready: now, or in one of the next updates. A fault is answered with FAIL."""
        client.waiting = waiting
        self._answer_waiting(peer, client)

    @staticmethod
    def _drop_waiting(client: _FtpClient) -> None:
        waiting, client.waiting = client.waiting, None
        if waiting is not None:
            waiting.drop()

    def _answer_waiting(self, peer: Peer, client: _FtpClient) -> None:
        waiting = client.waiting
        if waiting is None:
            return
        try:
            if not waiting.ready():
                return
            client.waiting = None
            payload = waiting.answer()
        except Exception:  # noqa: BLE001  whatever is wrong with one file, the client gets an answer
            client.waiting = None
            payload = nak(waiting.request, FtpError.FAIL)
        if payload:
            self._reply(peer, client, waiting.request, payload)

    # --- bursts ----------------------------------------------------------------------------------------------------

    def _stream(self, peer: Peer, client: _FtpClient, now_s: float) -> None:
        """Send as many answers of the client's bursts as the line has room for."""
        rate = _SHARE * peer.endpoint.bytes_per_s
        elapsed_s = _SAVED_S if client.allowed_s is None else max(0.0, now_s - client.allowed_s)
        client.allowed_s = now_s
        client.allowance = min(max(_SAVED_S * rate, 2.0 * _FRAME_BYTES), client.allowance + elapsed_s * rate)
        for session in client.sessions.values():
            while session.burst is not None and client.allowance >= _FRAME_BYTES and not peer.endpoint.busy:
                if not self._send_chunk(peer, session, session.burst):
                    return
                client.allowance -= _FRAME_BYTES
                client.used_s = session.used_s = now_s

    def _send_chunk(self, peer: Peer, session: _Session, burst: _Burst) -> bool:
        """Send the next answer of a burst. False while the disk has not delivered it yet."""
        request, size = burst.request, session.file.size
        try:
            data = session.file.read(burst.offset, min(request.size or LARGEST_DATA, LARGEST_DATA))
        except OSError:
            session.burst = None
            self._send(peer, nak(request, FtpError.FAIL, seq=burst.seq, offset=burst.offset))
            return True
        if data is None:
            return False
        burst.left -= 1
        end = burst.offset + len(data) >= size or not data
        complete = end or burst.left <= 0
        self._send(peer, ack(request, data, seq=burst.seq, offset=burst.offset, burst_complete=complete))
        burst.seq += 1
        burst.offset += len(data)
        if complete:
            session.burst = None
        return True

    # --- clients ---------------------------------------------------------------------------------------------------

    def _client(self, peer: Peer, now_s: float) -> _FtpClient | None:
        """The client, added where it is new; None where there are too many that use their files."""
        client = self._clients.get(peer)
        if client is None:
            if len(self._clients) >= _MOST_CLIENTS:
                idle = [other for other, known in self._clients.items() if not known.sessions and known.waiting is None]
                leaves = idle[0] if idle else self._to_leave(peer, now_s)
                if leaves is None:
                    return None
                self._forget(leaves)
            client = self._clients[peer] = _FtpClient(now_s)
        return client

    def _to_leave(self, newcomer: Peer, now_s: float) -> Peer | None:
        """The client that makes room for another one, if one does."""
        used_s = {
            peer: (peer.endpoint, max((session.used_s for session in client.sessions.values()), default=client.used_s))
            for peer, client in self._clients.items()
        }
        return to_yield(used_s, newcomer.endpoint, now_s, _YIELD_S * self._hub.patience)

    def _has_room(self, newcomer: Peer, now_s: float) -> bool:
        """Whether one more file may be opened, in place of another where there are too many."""
        held = {
            (peer, number): (peer.endpoint, session.used_s)
            for peer, client in self._clients.items()
            for number, session in client.sessions.items()
        }
        if len(held) < _MOST_SESSIONS:
            return True
        leaves = to_yield(held, newcomer.endpoint, now_s, _YIELD_S * self._hub.patience)
        if leaves is None:
            return False
        self._end(self._clients[leaves[0]], leaves[1])
        return True

    def _forget(self, peer: Peer) -> None:
        client = self._clients.pop(peer)
        self._drop_waiting(client)
        for number in list(client.sessions):
            self._end(client, number)

    @staticmethod
    def _end(client: _FtpClient, number: int) -> None:
        session = client.sessions.pop(number, None)
        if session is not None:
            session.file.close()

    def _reply(self, peer: Peer, client: _FtpClient, request: FtpRequest, payload: bytes) -> None:
        client.last = (request.seq, request.opcode, payload)
        self._send(peer, payload)

    def _send(self, peer: Peer, payload: bytes) -> None:
        self._hub.send(peer, mavlink.MAVLink_file_transfer_protocol_message(0, peer.system, peer.component, payload))


def _refusal(request: FtpRequest) -> FtpError | None:
    """Why the request is refused whatever files there are; None where it is not."""
    try:
        opcode = Opcode(request.opcode)
    except ValueError:
        return FtpError.UNKNOWN_COMMAND
    if opcode in _WRITING:
        return FtpError.FILE_PROTECTED
    reads = opcode in (Opcode.READ_FILE, Opcode.BURST_READ_FILE)
    if request.size > LARGEST_DATA and not reads:
        return FtpError.INVALID_DATA_SIZE
    if opcode in (Opcode.OPEN_FILE_RO, Opcode.CALC_FILE_CRC32) and not request.data.strip(b"\0/"):
        return FtpError.INVALID_DATA_SIZE
    if opcode in (Opcode.OPEN_FILE_RO, Opcode.CALC_FILE_CRC32, Opcode.LIST_DIRECTORY) and request.path is None:
        return FtpError.FILE_NOT_FOUND
    return None


def _listing(request: FtpRequest, entries: Sequence[Entry] | None) -> bytes:
    """The answer to a listing: entries from number `offset` on, as many as fit. A name that no request could ask for,
    too long or not UTF-8, is left out."""
    if entries is None:
        return nak(request, FtpError.FILE_NOT_FOUND)
    data = b""
    rows = [row for entry in entries if (row := _row(entry)) is not None]
    for row in rows[request.offset :]:
        if len(data) + len(row) > LARGEST_DATA:
            break
        data += row
    return ack(request, data) if data else nak(request, FtpError.EOF)


def _row(entry: Entry) -> bytes | None:
    """The entry as a client gets it; None where that is impossible."""
    with contextlib.suppress(UnicodeEncodeError):
        row = (f"D{entry.name}" if entry.size is None else f"F{entry.name}\t{entry.size}").encode() + b"\0"
        return row if len(row) <= LARGEST_DATA else None
    return None
