"""Combines the hypotheses: which channel is used, which is not and why, and what the operator is asked."""

from __future__ import annotations

from collections.abc import Sequence

from companion.core.decision import TextKind
from companion.core.estimate import Distrust
from companion.core.events import Announce
from companion.nav.integrity.evidence import (
    INERTIAL,
    Channel,
    Evidence,
    HeadingSeen,
    LieFound,
    PositionSeen,
    Sense,
    VelocitySeen,
)
from companion.nav.integrity.table import Hypotheses
from companion.nav.outliers import Verdict
from companion.params.store import Parameters

_REACCEPTANCE_S = 5.0  # how long nothing may speak against a channel before it is used again
_PROBATION_S = 2.5  # how long the position of a receiver whose velocity lies is kept out: time to judge it, too
_ROUND_ONSET_S = 1.0  # how far the onset of an inertial sensor's lie may be off
_OFF, _REPORT, _ACT = 0, 1, 2  # of NAV_INTEG
_FOLLOW, _ASK, _ASK_ALWAYS = 0, 1, 2  # of NAV_JUMP_ACT


class _Doubted:
    """A channel that is, or lately was, found to lie. `timeless`: by what late readings do not explain."""

    def __init__(self, finding: LieFound, now_s: float, timeless: bool = False) -> None:
        self.finding, self.timeless = finding, timeless
        self.first_s = self.last_s = now_s  # when it was found, first and last


class IntegrityMonitor:
    """`screen_…` for each reading as it comes, `update` once a tick. `trusts` says whether a channel is used.

    Remembers the channels that are not, until nothing has spoken against them for some seconds. While the boat is
    disarmed all are trusted; disarming clears everything.
    """

    def __init__(self, parameters: Parameters, say: Announce) -> None:
        self._parameters = parameters
        self._say = say
        self.hypotheses = Hypotheses()
        self._doubted: dict[Channel, _Doubted] = {}
        self.untrusted: frozenset[Channel] = frozenset()
        """The channels that are not used."""
        self._take_next: set[Channel] = set()  # accepted: its next reading counts, whatever the estimate is
        self._driven = self._maybe_late = False

    # --- what the estimator asks -----------------------------------------------------------------------------------

    def trusts(self, sense: Sense, source: str) -> bool:
        """Whether that sense of that source is used."""
        return not self.untrusted or (sense, source) not in self.untrusted

    @property
    def state(self) -> tuple[Distrust, ...]:
        """What is found, for the record of the tick."""
        return tuple(
            Distrust(
                channel.sense.value,
                channel.source,
                doubted.finding.fault,
                doubted.finding.since_s,
                self._excludes(doubted.finding),
                doubted.finding.asks,
            )
            for channel, doubted in self._doubted.items()
        )

    @property
    def _acts(self) -> bool:
        return bool(self._parameters["NAV_INTEG"] == _ACT)

    def _excludes(self, finding: LieFound) -> bool:
        """Whether what is found keeps the channel out."""
        followed = finding.jump and self._parameters["NAV_JUMP_ACT"] == _FOLLOW
        return self._acts and not finding.used and not followed

    def screen_position(self, seen: PositionSeen) -> Verdict | None:
        """The verdict on a fix that is about to be used; None: the usual rule."""
        verdict = self.hypotheses.position_jump.screen(seen, self._driven, self._maybe_late)
        if verdict is None and self._on_probation(seen.source, seen.t_s):
            verdict = Verdict.REJECT
        return self._screened(Channel(Sense.POSITION, seen.source), verdict)

    def _on_probation(self, source: str, t_s: float) -> bool:
        """Whether the receiver's velocity has just been found to lie, or seems to: its position may lie with it."""
        doubted = self._doubted.get(Channel(Sense.VELOCITY, source)) if self._doubted else None
        if doubted is not None:
            return t_s - doubted.first_s <= _PROBATION_S
        return self.hypotheses.velocity_jump.suspects(source)

    def screen_velocity(self, seen: VelocitySeen) -> Verdict | None:
        """The verdict on a velocity that is about to be used; None: the usual rule."""
        verdict = self.hypotheses.velocity_jump.screen(seen, self._driven)
        return self._screened(Channel(Sense.VELOCITY, seen.source), verdict)

    def screen_heading(self, seen: HeadingSeen) -> Verdict | None:
        """The verdict on a heading that is about to be used; None: the usual rule."""
        verdict = self.hypotheses.heading_jump.screen(seen, self._driven)
        return self._screened(Channel(Sense.HEADING, seen.source), verdict)

    def _screened(self, channel: Channel, verdict: Verdict | None) -> Verdict | None:
        if self._take_next and channel in self._take_next:
            self._take_next.discard(channel)
            return Verdict.RESET
        if verdict is None or not self._acts or self._parameters["NAV_JUMP_ACT"] == _FOLLOW:
            return None
        return verdict

    def sigma_m(self, source: str, claimed_m: float) -> float:
        """One sigma of that receiver's fixes on each axis: what it claims, or worse."""
        if not self._acts:
            return claimed_m
        by_scatter = self.hypotheses.accuracy_lie.sigma_m(source, claimed_m)
        return max(by_scatter, self.hypotheses.receivers_apart.sigma_m(source, claimed_m))

    def apart_m(self, source: str | None) -> float:
        """How far another receiver is from that one, by more than both claim: nobody knows which of them is wrong."""
        return self.hypotheses.receivers_apart.sigma_m(source, 0.0) if source is not None and self._acts else 0.0

    # --- once a tick -----------------------------------------------------------------------------------------------

    def update(self, evidence: Evidence, now_s: float) -> Sequence[LieFound]:
        """Take the readings of a tick; returns what is found to lie from now on, and must not be used."""
        if self._parameters["NAV_INTEG"] == _OFF:
            evidence.driven = evidence.maybe_late = False
        if (self._driven and not evidence.driven) or (
            self._maybe_late and not (evidence.driven or evidence.maybe_late)
        ):
            self._forget(evidence.maybe_late)
        self._driven, self._maybe_late = evidence.driven, evidence.maybe_late
        evidence.distrusted = frozenset(c for c, doubted in self._doubted.items() if not doubted.finding.used)
        velocities = {Channel(Sense.VELOCITY, seen.source) for seen in evidence.velocities}
        evidence.suspected = frozenset(c for c in velocities if self.hypotheses.velocity_jump.suspects(c.source))
        found, timeless = self._find(evidence, now_s)
        self._follow_confirmed(found, now_s)
        begun = self._enter(found, now_s)
        for channel in timeless & self._doubted.keys():
            self._doubted[channel].timeless = True
        self._leave(now_s)
        self.untrusted = self._unusable()
        return [finding for finding in begun if finding.channel in self.untrusted]

    def _find(self, evidence: Evidence, now_s: float) -> tuple[dict[Channel, LieFound], set[Channel]]:
        """What lies, and of which of it the times of readings do not matter: that is judged while they are in doubt,
        too."""
        found: dict[Channel, LieFound] = {}
        timeless: set[Channel] = set()
        for hypothesis in self.hypotheses.all:
            by_times = hypothesis not in self.hypotheses.timeless
            evidence.driven = self._driven or (self._maybe_late and not by_times)
            for finding in hypothesis.update(evidence, now_s):
                known = found.get(finding.channel)
                if known is None or known.used:
                    found[finding.channel] = finding
                    if by_times:
                        timeless.discard(finding.channel)
                    else:
                        timeless.add(finding.channel)
        evidence.driven = self._driven
        return found, timeless

    def _unusable(self) -> frozenset[Channel]:
        return frozenset(channel for channel, doubted in self._doubted.items() if self._excludes(doubted.finding))

    def _follow_confirmed(self, found: dict[Channel, LieFound], now_s: float) -> None:
        """Jumps with which independent evidence agrees."""
        if not self._acts or self._parameters["NAV_JUMP_ACT"] != _ASK:
            return
        for channel, finding in list(found.items()):
            if (
                finding.jump
                and channel.sense is Sense.POSITION
                and self.hypotheses.position_jump.confirmed(channel.source, self.untrusted, now_s)
            ):
                self._take(finding, now_s, "confirmed by another")
                del found[channel]

    def _take(self, finding: LieFound, now_s: float, why: str) -> None:
        """Believe a source after all."""
        channel = finding.channel
        for hypothesis in self.hypotheses.all:
            hypothesis.accept(channel)
        self._take_next.add(channel)
        self._doubted.pop(channel, None)
        text = f"{channel.source} {channel.sense.value} followed: {why}"
        self._say(now_s, TextKind.ATTENTION, "sense_accepted", text)

    def _enter(self, found: dict[Channel, LieFound], now_s: float) -> list[LieFound]:
        begun = []
        for channel, finding in found.items():
            doubted = self._doubted.get(channel)
            if doubted is not None and (finding.used or not doubted.finding.used):
                if finding.used == doubted.finding.used:
                    doubted.last_s = now_s
                continue
            self._doubted[channel] = _Doubted(finding, now_s)
            begun.append(finding)
        lies_s = [finding.since_s for finding in begun if finding.channel.sense in INERTIAL]
        if lies_s:
            self._absolve(min(lies_s) - _ROUND_ONSET_S)
            begun = [finding for finding in begun if finding.channel in self._doubted]
        self._announce(begun, now_s)
        return begun

    def _absolve(self, from_s: float) -> None:
        """An inertial sensor has lied since then: what it has made receivers and headings look like is void."""
        for hypothesis in (self.hypotheses.position_jump, self.hypotheses.velocity_jump, self.hypotheses.heading_jump):
            hypothesis.absolve(from_s)
        for channel, doubted in list(self._doubted.items()):
            if channel.sense not in INERTIAL and doubted.finding.since_s >= from_s:
                del self._doubted[channel]

    def _announce(self, begun: Sequence[LieFound], now_s: float) -> None:
        """One text for each source and fault."""
        named: dict[tuple[str, str], list[LieFound]] = {}
        for finding in begun:
            named.setdefault((finding.channel.source, finding.fault), []).append(finding)
        for (source, fault), findings in named.items():
            sense = findings[0].channel.sense
            whole = len(findings) > 1 or sense in INERTIAL or sense.value == source
            of = "" if whole else f" {sense.value}"
            excluded = self._excludes(findings[0])
            end = "not used" if excluded else "still used"
            kind = TextKind.ALARM if excluded else TextKind.ATTENTION
            self._say(now_s, kind, "sense_distrusted", f"{source}{of} {fault}: {end}")
            if excluded and findings[0].asks:
                self._say(now_s, TextKind.ALARM, "sense_asked", f"Is {source} right? Accept or reject it")

    def _leave(self, now_s: float) -> None:
        """Channels against which nothing speaks any more."""
        for channel, doubted in list(self._doubted.items()):
            if now_s - doubted.last_s < _REACCEPTANCE_S or doubted.finding.lasting:
                continue
            del self._doubted[channel]
            of = "" if channel.sense.value == channel.source else f" {channel.sense.value}"
            text = f"{channel.source}{of} is good again"
            self._say(now_s, TextKind.ROUTINE, "sense_trusted", text)

    def begin_anew(self) -> None:
        """The estimate was wrong, against which all channels were judged: trust them, and forget what they were."""
        self.hypotheses = Hypotheses()
        self._forget()

    def _forget(self, late: bool = False) -> None:
        """Begin anew. `late`: since what seems to lie may be late, which turns no heading round, repeats nothing, and
        brings no boat far off."""
        jumps = self.hypotheses.position_jump
        if late:
            jumps.clear_late()
        kept = {channel: doubted for channel, doubted in self._doubted.items() if late and self._stands(doubted)}
        self._doubted = kept
        self._take_next.clear()
        turned = any(doubted.finding.loses for doubted in kept.values())
        for hypothesis in self.hypotheses.all:
            stands = (late and hypothesis in self.hypotheses.timeless) or (
                turned and hypothesis is self.hypotheses.heading_turned
            )
            if not stands:
                hypothesis.clear()
        self.untrusted = self._unusable()

    def _stands(self, doubted: _Doubted) -> bool:
        """Whether no latency explains what was found."""
        finding = doubted.finding
        if finding.jump:
            is_place = finding.channel.sense is Sense.POSITION
            return is_place and self.hypotheses.position_jump.suspects(finding.channel.source)
        return finding.loses or doubted.timeless

    # --- the operator's answer -------------------------------------------------------------------------------------

    def answer(self, accept: bool, now_s: float) -> str | None:
        """Believe the sources that are asked about, or not. Returns why not, or None."""
        found = [doubted.finding for doubted in self._doubted.values()]
        asked = [finding for finding in found if finding.asks and self._excludes(finding)]
        if not asked:
            return "no sensor waits for an answer"
        for finding in asked:
            if accept:
                self._take(finding, now_s, "accepted")
            else:
                self._doubted[finding.channel].finding = finding._replace(asks=False)
                text = f"{finding.channel.source} {finding.channel.sense.value} rejected"
                self._say(now_s, TextKind.ROUTINE, "sense_rejected", text)
        self.untrusted = self._unusable()
        return None
