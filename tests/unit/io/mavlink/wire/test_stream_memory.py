"""What signatures have reached outlives a killed process, and nothing else does."""

from __future__ import annotations

import stat
from pathlib import Path

import pytest

from companion.io.mavlink.wire.signing import SignatureVerdict, Signing, SigningState
from companion.io.mavlink.wire.stream_memory import SharedStreamMemory
from tests.unit.io.mavlink.wire.test_signing import KEY, OTHER_KEY, Clock, Kept, heartbeat, station


def memory(folder: Path, boot: str = "boot 1", state: str = "state") -> SharedStreamMemory:
    return SharedStreamMemory(folder / state, folder, boot)


def started(folder: Path, clock: Clock, state: SigningState, kept: Kept, boot: str = "boot 1") -> Signing:
    return Signing(clock, state, kept, memory=memory(folder, boot))


def test_a_killed_companion_hears_at_once_and_nothing_twice(tmp_path: Path) -> None:
    """Also a station whose clock lags behind the others'."""
    clock, kept = Clock(), Kept()
    ours = started(tmp_path, clock, SigningState(KEY, 0), kept)
    lagging, exact = station(KEY, clock.stamp - 3_000_000, system=254), station(KEY, clock.stamp)
    heard = [heartbeat(one) for _ in range(5) for one in (lagging, exact)]
    assert {ours.judge(data) for data in heard} == {SignatureVerdict.GENUINE}
    clock.ns += 300_000_000  # killed, and started again 0.3 s later
    again = started(tmp_path, clock, kept.states[-1], kept)
    assert {again.judge(data) for data in heard} == {SignatureVerdict.STALE}
    for one in (lagging, exact):
        assert again.judge(heartbeat(one)) is SignatureVerdict.GENUINE


def test_our_own_time_stamps_go_on(tmp_path: Path) -> None:
    clock, kept = Clock(), Kept()
    ours = started(tmp_path, clock, SigningState(KEY, 0), kept)
    frame = bytes(mavlink_frame())
    stamps = [int.from_bytes(ours.sign(frame, b"\x32", 0)[-12:-6], "little") for _ in range(1000)]
    again = started(tmp_path, Clock(0), kept.states[-1], kept)
    assert int.from_bytes(again.sign(frame, b"\x32", 0)[-12:-6], "little") > stamps[-1]


def mavlink_frame() -> bytes:
    return b"\xfd\x09\x00\x00\x00\x01\x01\x00\x00\x00" + bytes(9) + b"\x00\x00"


@pytest.mark.parametrize("how", ["another boot", "another key", "no horizon", "gone on elsewhere", "torn", "readable"])
def test_what_does_not_belong_to_this_run_is_not_used(tmp_path: Path, how: str) -> None:
    clock, kept = Clock(), Kept()
    ours = started(tmp_path, clock, SigningState(KEY, 0), kept)
    ours.judge(heartbeat(station(KEY, clock.stamp)))
    state = kept.states[-1]
    (file,) = (path for path in tmp_path.iterdir() if path.is_file())
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    assert memory(tmp_path).recall(state) is not None
    boot = "boot 1"
    if how == "another boot":
        boot = "boot 2"
    elif how == "another key":
        state = SigningState(OTHER_KEY, state.horizon)
    elif how == "no horizon":
        state = SigningState(KEY, 0)
    elif how == "gone on elsewhere":
        state = SigningState(KEY, state.horizon + 1_000)
    elif how == "torn":
        file.write_bytes(file.read_bytes()[:-1])
    else:
        file.chmod(0o644)
    assert memory(tmp_path, boot).recall(state) is None


def test_it_is_gone_after_an_end_in_order_and_without_a_key(tmp_path: Path) -> None:
    clock, kept = Clock(), Kept()
    for end in (Signing.close, lambda ours: ours.set_key(None)):
        ours = started(tmp_path, clock, SigningState(KEY, 0), kept)
        assert list(tmp_path.iterdir())
        end(ours)
        assert not list(tmp_path.iterdir())
    started(tmp_path, clock, SigningState(None, 0), kept)
    assert not list(tmp_path.iterdir())


def test_without_the_folder_signing_works_all_the_same(tmp_path: Path) -> None:
    clock, kept = Clock(), Kept()
    ours = started(tmp_path / "missing", clock, SigningState(KEY, 0), kept)
    assert ours.judge(heartbeat(station(KEY, clock.stamp))) is SignatureVerdict.GENUINE


def test_more_streams_than_it_holds(tmp_path: Path) -> None:
    clock, kept = Clock(), Kept()
    ours = started(tmp_path, clock, SigningState(KEY, 0), kept)
    for number in range(300):
        clock.ns += 1_000_000
        ours.judge(heartbeat(station(KEY, clock.stamp, number % 256, 1 + number // 256)))
    known = memory(tmp_path).recall(kept.states[-1])
    assert known is not None and len(known.streams) == 256
    assert known.streams[2, 190, 43] > known.floor >= known.streams[1, 190, 44] - 1_000
