"""The band of frequencies in which a hull is fitted to a log: below the waves, and below what a hull answers to."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from companion.analysis.disturbance import Array, Stretches

_CALM_HZ = 1.0  # above it a hull hardly answers, and the log has noise
_SHARE = 0.5  # of the waves' frequency
_LEAST_HZ = 0.1
_ORDER = 4  # of the low-pass, which runs forth and back
_NYQUIST = 1.3  # of the highest frequency
_PERIODS_S = (0.8, 6.0)  # of waves that can be told from manoeuvres
_STANDS_OUT = 2.5  # times what the spectrum has below the waves' frequency: from there on these are waves
_TRANSLATIONS = (0, 1)  # a boat that steers to and fro turns at frequencies of its own
_SEGMENT = 256  # samples of one spectrum


@dataclass(frozen=True, slots=True)
class Band:
    """Frequencies up to `highest_hz`. `waves`: whether these end it. `every`: ticks from one sample of `sampled` to
    the next, `period_s` apart; `stretches`: of samples."""

    highest_hz: float
    waves: bool
    every: int
    period_s: float
    stretches: Stretches
    _low_pass: Array = field(repr=False)
    _ticks: Stretches = field(repr=False)

    def calm(self, columns: Array) -> Array:
        """Columns over the ticks (n, any) without what is faster, without delay; outside the stretches as they are."""
        from scipy.signal import sosfiltfilt

        out, most = columns.copy(), 12 * self.every
        for first, end in self._ticks:
            out[first:end] = sosfiltfilt(self._low_pass, columns[first:end], axis=0, padlen=min(end - first - 1, most))
        return out

    def sampled(self, columns: Array) -> Array:
        """The same, (samples, any), as few as the band needs."""
        calm = self.calm(columns)
        return np.concatenate([calm[first : end : self.every] for first, end in self._ticks])


def band_of(wave_s: float | None, stretches: Stretches, period_s: float) -> Band:
    """The band for a log with waves of that period; None: without waves."""
    from scipy.signal import butter

    highest = min(_CALM_HZ if wave_s is None else max(_SHARE / wave_s, _LEAST_HZ), 0.2 / period_s)
    every = max(1, int(1.0 / (2.0 * _NYQUIST * highest * period_s)))
    found, at = [], 0
    for first, end in stretches:
        count = -(-(end - first) // every)
        found.append((at, at + count))
        at += count
    low = np.asarray(butter(_ORDER, 2.0 * highest * period_s, output="sos"), dtype=np.float64)
    return Band(highest, wave_s is not None, every, every * period_s, tuple(found), low, stretches)


def wave_period_s(velocity: Array, stretches: Stretches, period_s: float) -> float | None:
    """Period of the waves that the boat met, by velocities (n, axes); None where there were none worth the name.

    A boat under way has less of each higher frequency. Where a spectrum rises again, waves carry it to and fro.
    """
    from scipy.signal import welch

    whole = [one for one in stretches if one[1] - one[0] >= _SEGMENT]
    if not whole:
        return None
    most, found = _STANDS_OUT, None
    for axis in _TRANSLATIONS:
        total = np.zeros(_SEGMENT // 2 + 1)
        for first, end in whole:
            hertz, power = welch(velocity[first:end, axis], 1.0 / period_s, nperseg=_SEGMENT)
            total += power * (end - first)
        usual = (hertz > 1.0 / _PERIODS_S[1]) & (hertz < 1.0 / _PERIODS_S[0])
        ratio = np.where(usual, total / np.minimum.accumulate(total), 0.0)
        if ratio.max() > most:
            most, found = float(ratio.max()), 1.0 / float(hertz[np.argmax(ratio)])
    return found
