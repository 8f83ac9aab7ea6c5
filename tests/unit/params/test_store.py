"""The one table of parameters."""

import math
import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.params.spec import ParamRefusal, ParamSpec, ParamType
from companion.params.store import Parameters
from companion.params.table import TABLE


@pytest.mark.parametrize("spec", TABLE, ids=lambda spec: spec.name)
def test_every_row_is_well_formed(spec: ParamSpec) -> None:
    assert 1 <= len(spec.name) <= 16 and spec.name == spec.name.upper() and spec.name.isascii()
    assert spec.minimum <= spec.default <= spec.maximum
    assert spec.text and spec.group
    if spec.choices:
        assert spec.default in spec.choices and {spec.minimum, spec.maximum} <= set(spec.choices)
    if spec.type is ParamType.INT32:
        assert abs(spec.minimum) <= 2**24 and abs(spec.maximum) <= 2**24, "must survive a float32"


@pytest.mark.parametrize("spec", [spec for spec in TABLE if not spec.read_only], ids=lambda spec: spec.name)
def test_the_ends_of_the_range_belong_to_it(spec: ParamSpec) -> None:
    parameters = Parameters()
    assert parameters.set(spec.name, spec.minimum) is None
    if not spec.choices:
        assert parameters.set(spec.name, spec.maximum) is None


def test_names_are_unique() -> None:
    assert len({spec.name for spec in TABLE}) == len(TABLE)


def test_names_that_ground_stations_look_up_exist() -> None:
    parameters = Parameters()
    for name, value in {
        "SYS_AUTOSTART": 50000,
        "CAL_GYRO0_ID": 1,
        "CAL_ACC0_ID": 1,
        "SYS_HAS_MAG": 0,
        "COM_RC_IN_MODE": 1,
    }.items():
        assert parameters[name] == value
    assert parameters["MPC_XY_VEL_MAX"] > 0


def test_refusals_leave_everything_as_it_was() -> None:
    parameters = Parameters()
    before = {spec.name: parameters[spec.name] for spec in parameters.specs}
    assert parameters.set("NO_SUCH", 1.0) is ParamRefusal.DOES_NOT_EXIST
    assert parameters.set("DP_BW_SURGE", 1e9) is ParamRefusal.VALUE_OUT_OF_RANGE
    assert parameters.set("DP_BW_SURGE", math.nan) is ParamRefusal.VALUE_OUT_OF_RANGE
    assert parameters.set("MAN_RC_SAFE_CH", 3) is ParamRefusal.VALUE_OUT_OF_RANGE
    assert parameters.set("SYS_AUTOSTART", 1) is ParamRefusal.READ_ONLY
    assert before == {spec.name: parameters[spec.name] for spec in parameters.specs}
    assert parameters.changed() == {}


def test_a_change_calls_listeners_and_can_be_reset() -> None:
    parameters = Parameters({"DP_BW_SURGE": 0.5})
    told: list[tuple[str, float]] = []
    parameters.on_change(lambda name, value: told.append((name, value)))
    assert parameters.set("DP_BW_SURGE", 0.25) is None
    assert told == [("DP_BW_SURGE", 0.25)] and parameters.changed() == {"DP_BW_SURGE": 0.25}
    parameters.reset()
    assert parameters["DP_BW_SURGE"] == 0.5 and parameters.changed() == {}


def test_a_wrong_default_of_a_vessel_is_refused() -> None:
    with pytest.raises(ValueError, match="DP_BW_SURGE"):
        Parameters({"DP_BW_SURGE": -1.0})


@settings(deadline=None, derandomize=True, max_examples=100)
@given(st.floats(0.05, 2.0))
def test_a_value_reads_back_as_float32(value: float) -> None:
    parameters = Parameters()
    parameters.set("DP_BW_SURGE", value)
    assert struct.unpack("<f", struct.pack("<f", value))[0] == pytest.approx(parameters["DP_BW_SURGE"], rel=1e-12)
