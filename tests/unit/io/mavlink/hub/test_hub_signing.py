"""Keys by SETUP_SIGNING: on a trusted link, for us by name, and into no log."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from companion.io.mavlink.assembly import connect
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import frame, pack
from companion.io.mavlink.wire.hub import Copies
from companion.io.mavlink.wire.signing import Signing, SigningState, unsigned
from companion.record.state_file import StateFile

KEY, OTHER_KEY = bytes(range(32)), bytes(range(1, 33))
NOW_NS = 1_780_000_000_000_000_000
STAMP = (NOW_NS - 1_420_070_400_000_000_000) // 10_000


def setup(key: bytes, stamp: int = STAMP, target: int = 1) -> Any:
    return mavlink.MAVLink_setup_signing_message(target, 1, list(key), stamp)


class Signed:
    """A vessel's hub with signing on one link, and what its logs were given."""

    def __init__(self, rig: Any, key: bytes | None = None) -> None:
        self.rig, self.tapped, self.heard, self.kept = rig, bytearray(), bytearray(), []
        self.signing = Signing(lambda: NOW_NS, SigningState(key, 0), self.kept.append)
        rig.hub = connect(
            rig.vessel,
            [desk.link for desk in rig.desks],
            "0.1.0",
            signing=self.signing,
            copies=Copies(
                lambda packets: self.tapped.extend(b"".join(packets)),
                lambda persona, endpoint, now_s, data: self.heard.extend(data),
            ),
        )

    @property
    def texts(self) -> list[str]:
        return [event.text for event in self.rig.vessel.events.drain()]


def test_a_key_is_set_and_ended_on_a_trusted_link_and_stands_in_no_log(make_rig: Any) -> None:
    signed = Signed(make_rig(["memory:?trusted=yes&signing=accept"]))
    signed.rig.ask(setup(KEY))
    assert signed.kept[-1].key == KEY and signed.texts == ["signing key set by system 255"]
    signed.rig.run(0.5)
    signed.rig.ask(setup(bytes(32), 0))
    assert signed.kept[-1].key is None and signed.texts == ["signing key removed by system 255"]
    assert (
        KEY not in signed.tapped
        and KEY not in signed.heard
        and KEY[:12] not in signed.tapped
        and len(signed.tapped) > 0
    )


@pytest.mark.parametrize("url", ["memory:", "memory:?signing=accept"])
def test_elsewhere_it_is_refused_with_the_reason(make_rig: Any, url: str, named: Any) -> None:
    signed = Signed(make_rig([url]))
    (text,) = named(signed.rig.ask(setup(KEY)), "STATUSTEXT")
    assert "without ?trusted=yes" in text.text and not signed.signing.has_key and signed.kept == []
    assert KEY[:12] not in signed.tapped and KEY[:12] not in signed.heard


def test_a_key_for_another_or_for_all_is_not_ours(make_rig: Any) -> None:
    signed = Signed(make_rig(["memory:?trusted=yes"]))
    assert signed.rig.ask(setup(KEY, target=2)) == [] and signed.rig.ask(setup(KEY, target=0)) == []
    assert not signed.signing.has_key
    signed.rig.ask(setup(bytes(32), STAMP))
    assert not signed.signing.has_key


def test_logs_keep_the_packets_and_not_their_signatures(make_rig: Any) -> None:
    """From the signature of a packet that is known, a weak passphrase could be guessed at home."""
    signed = Signed(make_rig(["memory:?signing=require"]), KEY)
    peer = Signing(lambda: NOW_NS, SigningState(KEY, 0), lambda state: None)
    packed = pack(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
    plain = frame(packed, 9, 255, 190)
    data = peer.sign(plain, packed.crc_extra, 3)
    signed.rig.desk.link.to_vessel(data)
    signed.rig.serve()
    assert data[-6:] not in signed.tapped and plain in signed.tapped and plain in signed.heard
    assert unsigned(data, packed.crc_extra[0]) == plain
    body = bytearray(frame(packed, 10, 255, 190))
    body[7:10] = (60_000).to_bytes(3, "little")  # of a message that nobody here knows
    stranger = peer.sign(bytes(body), packed.crc_extra, 3)
    signed.rig.desk.link.to_vessel(stranger)
    signed.rig.serve()
    assert signed.rig.desk.link.guard.refused == {} and stranger[-6:] not in signed.tapped


def test_radio_status_does_not_stand_for_a_station(make_rig: Any) -> None:
    """Its sender's number may be anybody's, and it bears no signature: it must not keep the loss of the ground station
    unseen."""
    rig = make_rig(["memory:"])
    rig.ask(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
    before = rig.supervisor.heard
    assert before
    rig.ask(mavlink.MAVLink_radio_status_message(200, 190, 90, 20, 20, 0, 0))
    assert rig.supervisor.heard == before


def test_a_restarted_vessel_knows_the_key_that_it_was_given(make_rig: Any, tmp_path: Path) -> None:
    state = StateFile(tmp_path)
    signed = Signed(make_rig(["memory:?trusted=yes&signing=accept"]))
    signed.rig.ask(setup(KEY))
    state.save_signing(signed.kept[-1].key, signed.kept[-1].horizon)
    state.close()
    again = StateFile(tmp_path)
    (key, horizon), warnings = again.load_signing()
    assert key == KEY and horizon > STAMP and warnings == []
    again.close()
