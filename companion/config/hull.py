"""The controller's model of the hull, as a vessel's file gives it."""

from __future__ import annotations

from dataclasses import dataclass, field

from companion.config.fields import STRICT, NonNegative, Positive


@dataclass(frozen=True, slots=True)
class DampingConfig:
    """Hydrodynamic damping in Fossen's derivatives, positive where it resists: X = −(x_u u + x_uu |u|u + x_uuu u³) and so on.

    Y = −(y_v v + y_vv |v|v + y_rv |r|v + y_r r + y_vr |v|r + y_rr |r|r), N likewise with n_.
    """

    __pydantic_config__ = STRICT
    x_u: float = 0.0
    x_uu: float = 0.0
    x_uuu: float = 0.0
    y_v: float = 0.0
    y_vv: float = 0.0
    y_rv: float = 0.0
    y_r: float = 0.0
    y_vr: float = 0.0
    y_rr: float = 0.0
    n_v: float = 0.0
    n_vv: float = 0.0
    n_rv: float = 0.0
    n_r: float = 0.0
    n_vr: float = 0.0
    n_rr: float = 0.0


@dataclass(frozen=True, slots=True)
class HullConfig:
    """Inertia with added mass, and damping: M = [[m11, 0, 0], [0, m22, m23], [0, m32, m33]]."""

    __pydantic_config__ = STRICT
    m11_kg: Positive
    m22_kg: Positive
    m33_kgm2: Positive
    m23_kgm: float = 0.0
    m32_kgm: float | None = None  # None: as m23
    damping: DampingConfig = field(default_factory=DampingConfig)


@dataclass(frozen=True, slots=True)
class WindageConfig:
    """Wind areas and coefficients (Fossen 2011, 8.1.3), with (ax, ay) the velocity of the air relative to the boat in body axes:

    X = ½ρ cx A_F V ax, Y = ½ρ cy A_L V ay, N = −ρ cn A_L L ax ay (½ρ cn A_L L V² sin 2γ: the bow turns away from the wind).
    """

    __pydantic_config__ = STRICT
    frontal_m2: NonNegative = 0.0
    lateral_m2: NonNegative = 0.0
    cx: float = 0.7
    cy: float = 0.9
    cn: float = 0.1


@dataclass(frozen=True, slots=True)
class ThesisModelConfig:
    """What the thesis's own feed-forward believes beside `hull`'s inertia: the bare hull's mass, and damping as printed."""

    __pydantic_config__ = STRICT
    mass_kg: Positive
    damping: DampingConfig
