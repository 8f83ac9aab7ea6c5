"""What compiled code calls instead of Python's functions gives the same, to the last digit."""

from __future__ import annotations

import ctypes
import math
import random
import subprocess
import sysconfig
from collections.abc import Callable, Iterator
from functools import reduce
from operator import xor
from typing import Any

import numpy as np
import pytest

from companion.io.sensors.nmea0183_fields import checksum
from companion.nav import matrix_in_place
from companion.nav.matrix_in_place import flat
from companion.record.columns import Packer, narrowed
from sitl.native.build import FLAGS
from sitl.native.operations import HEADER

_WRAPPED = """
/* of mypyc's library */
Py_ssize_t CPyLong_AsSsize_tAndOverflow_(PyObject *whole, int *over) { return PyLong_AsLongAndOverflow(whole, over); }
PyObject *CPyTagged_AsObject(CPyTagged whole) { return PyLong_FromSsize_t((Py_ssize_t)whole / 2); }
double of_one(int which, double x) {
    return which == 0 ? usv_radians(x) : which == 1 ? usv_degrees(x) : which == 2 ? usv_asin(x)
        : which == 3 ? usv_acos(x) : usv_expm1(x);
}
double of_two(int which, double x, double y) {
    return which == 0 ? usv_hypot(x, y) : which == 1 ? usv_fmod(x, y) : which == 2 ? usv_remainder(x, y)
        : usv_power(x, y);
}
double squared(double x) { return usv_power(x, 2.0); }
double hypot3(double x, double y, double z) { return usv_hypot3(x, y, z); }
int finite(double x) { return usv_isfinite(x); }
long rounded(double x) { return (long)usv_round(x) / 2; }
PyObject *formatted(double x, PyObject *text) { return usv_format_float(x, text); }
PyObject *formatted_int(long x, PyObject *text) { return usv_format_int((CPyTagged)(x * 2), text); }
int set_number(PyObject *view, long at, double x) { return usv_set_number(view, (CPyTagged)(at * 2), x); }
PyObject *get_item(PyObject *view, long at) { return usv_get_item(view, (CPyTagged)(at * 2)); }
PyObject *sum_bytes(PyObject *data) { return usv_sum_bytes(data); }
PyObject *narrowed(PyObject *packer, PyObject *rows, long tick_us) { return usv_narrowed(packer, rows, tick_us * 2); }
long checksum(PyObject *data) { return usv_checksum(data) / 2; }
int on_matrix(int which, PyObject *matrix, PyObject *other) {
    return which == 0 ? usv_add_to_diagonal(matrix, other, matrix, other)
        : which == 1 ? usv_subtract(matrix, other, matrix, other) : usv_symmetrise(matrix, matrix, other, matrix);
}
"""
_OF_ONE: tuple[Callable[[float], float], ...] = (math.radians, math.degrees, math.asin, math.acos, math.expm1)
_OF_TWO: tuple[Callable[[float, float], float], ...] = (math.hypot, math.fmod, math.remainder, lambda x, y: x**y)
_TEXTS = (".3f", ".7g", ".1f", "+.2f", "08.2f", ".12g", "")


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Any:
    from mypyc.build import include_dir

    folder = tmp_path_factory.mktemp("operations")
    (folder / "wrapped.c").write_text(f'#include "{HEADER}"\n{_WRAPPED}')
    include = [f"-I{path}" for path in (include_dir(), sysconfig.get_paths()["include"])]
    compiler = str(sysconfig.get_config_var("CC") or "cc").split()
    flags = [flag for flag in FLAGS if "visibility" not in flag]
    built = folder / "wrapped.so"
    subprocess.run([*compiler, *flags, *include, "-shared", folder / "wrapped.c", "-o", built, "-lm"], check=True)
    return _declared(ctypes.PyDLL(str(built)))


def _declared(library: Any) -> Any:
    number, whole, thing = ctypes.c_double, ctypes.c_long, ctypes.py_object
    for name, result, given in (
        ("of_one", number, (ctypes.c_int, number)),
        ("of_two", number, (ctypes.c_int, number, number)),
        ("squared", number, (number,)),
        ("hypot3", number, (number, number, number)),
        ("finite", ctypes.c_int, (number,)),
        ("rounded", whole, (number,)),
        ("formatted", thing, (number, thing)),
        ("formatted_int", thing, (whole, thing)),
        ("set_number", ctypes.c_int, (thing, whole, number)),
        ("get_item", thing, (thing, whole)),
        ("sum_bytes", thing, (thing,)),
        ("narrowed", thing, (thing, thing, whole)),
        ("checksum", whole, (thing,)),
        ("on_matrix", ctypes.c_int, (ctypes.c_int, thing, thing)),
    ):
        function = getattr(library, name)
        function.restype, function.argtypes = result, given
    return library


def _numbers(count: int) -> list[float]:
    rng = random.Random(1)
    edges = [0.0, -0.0, 1.0, -1.0, 0.5, 2.5, math.pi, 5e-324, 1e-300, 1e300, math.inf, -math.inf, math.nan]
    scaled = [rng.uniform(-1.0, 1.0) * 10.0 ** rng.randint(-20, 20) for _ in range(count)]
    return edges + scaled + [rng.gauss(0.0, 30.0) for _ in range(count)]


def _same(ours: Callable[[], float], pythons: Callable[[], Any]) -> bool:
    try:
        expected = pythons()
    except (ValueError, OverflowError, ZeroDivisionError) as error:
        with pytest.raises(type(error)):
            ours()
        return True
    if isinstance(expected, complex):
        with pytest.raises(TypeError):
            ours()
        return True
    found = ours()
    return (found == expected or found != found) and math.copysign(1.0, found) == math.copysign(1.0, expected)


def test_of_one_number(library: Any) -> None:
    for which, function in enumerate(_OF_ONE):
        for x in _numbers(500):
            assert _same(lambda: library.of_one(which, x), lambda: function(x)), (function, x)  # noqa: B023


def test_of_two_numbers(library: Any) -> None:
    numbers = _numbers(30)
    for which, function in enumerate(_OF_TWO):
        for x in numbers:
            for y in numbers:
                assert _same(lambda: library.of_two(which, x, y), lambda: function(x, y)), (function, x, y)  # noqa: B023


def test_squares_are_those_of_the_c_library(library: Any) -> None:
    rng = random.Random(3)
    numbers = [rng.uniform(0.0, 1.0) * 10.0 ** rng.uniform(-8.0, 4.0) for _ in range(20_000)]
    assert [x for x in numbers if library.squared(x) != x**2] == []


def test_hypotenuse_is_rounded_as_pythons(library: Any) -> None:
    rng = random.Random(2)
    for _ in range(20_000):
        x, y = rng.gauss(0.0, 10.0), rng.gauss(0.0, 10.0 ** rng.randint(-9, 3))
        assert library.of_two(0, x, y) == math.hypot(x, y)
        z = rng.gauss(0.0, 10.0)
        assert library.hypot3(x, y, z) == math.hypot(x, y, z)
        assert library.hypot3(z, x, y) == math.hypot(z, x, y)
    for x in (0.0, -3.0, 1e-200, 1e200, math.inf, math.nan):
        for y in (0.0, 4.0, 1e-300, -math.inf):
            assert _same(lambda: library.hypot3(x, y, 5.0), lambda: math.hypot(x, y, 5.0))  # noqa: B023


def test_kinds_and_whole_numbers(library: Any) -> None:
    for x in _numbers(500):
        assert library.finite(x) == math.isfinite(x)
        if abs(x) < 1e15:
            assert library.rounded(x) == round(x)
            assert library.rounded(round(2.0 * x) / 2.0) == round(round(2.0 * x) / 2.0)


def test_texts(library: Any) -> None:
    for x in _numbers(100):
        for text in _TEXTS:
            assert library.formatted(x, text) == format(x, text)
    for decimals, x in _ties(300):
        assert library.formatted(x, f".{decimals}f") == format(x, f".{decimals}f")
    for whole in (0, 1, 7, 10, 99, 123, 123456789, -3):
        for text in ("02d", "07d", "02X", "04X", "d", "5d", "+d"):
            assert library.formatted_int(whole, text) == format(whole, text)


def _ties(count: int) -> Iterator[tuple[int, float]]:
    """Decimals, and numbers halfway between two of that many decimals or as near to that as a float can be; and the
    ends of what the quick way takes."""
    rng = random.Random(3)
    for _ in range(count):
        decimals = rng.randint(1, 9)
        halfway = rng.choice([rng.randint(-(2**20), 2**20) / 2 ** rng.randint(1, 12), rng.gauss(0.0, 1e4)])
        near = (math.floor(halfway * 10**decimals) + 0.5) / 10**decimals
        for x in (halfway, near, math.nextafter(near, 0.0), math.nextafter(near, math.inf)):
            yield decimals, x
        for x in (8e9, 1e-30, 5e-324, 0.0):
            yield decimals, rng.choice([-1.0, 1.0]) * math.nextafter(x, rng.choice([0.0, math.inf]))


@pytest.mark.parametrize("ten", [10.0**power for power in range(-6, 9)])
def test_seven_digits_near_a_power_of_ten(library: Any, ten: float) -> None:
    rng, packer = random.Random(1), Packer(b"\x0a\x03imu", "ds", 1)
    for _ in range(400):
        exact = ctypes.c_float(ten * rng.choice([1.0, 1.0 + rng.gauss(0.0, 1e-7), rng.uniform(0.9, 1.1)])).value
        for x in (float(f"{exact:.7g}"), exact, -float(f"{exact:.7g}")):
            rows: list[Any] = [(0.0, x)]
            assert library.narrowed(packer, rows, 0) == narrowed(packer, rows, 0)


def test_items_of_flat_views(library: Any) -> None:
    from array import array

    numbers = array("d", [0.0, 1.0, 2.0])
    view = memoryview(numbers)
    assert library.set_number(view, 1, 5.0) == 0
    assert (numbers[1], library.get_item(view, 1), library.get_item([7, 8], 1)) == (5.0, 5.0, 8)
    for other in (view.toreadonly(), view):
        with pytest.raises((TypeError, IndexError)):
            library.set_number(other, 3 if other is view else 0, 1.0)
    with pytest.raises(IndexError):
        library.get_item(view, 3)
    halves = memoryview(numbers)[::2]
    assert library.set_number(halves, 1, 9.0) == 0
    assert list(numbers) == [0.0, 5.0, 9.0]
    bytes_of = memoryview(numbers).cast("B")
    assert library.get_item(bytes_of, 0) == 0


def test_matrices(library: Any) -> None:
    rng = np.random.default_rng(3)
    for size in (1, 2, 18):
        matrix, other = rng.normal(size=(size, size)), rng.normal(size=(size, size))
        row, work = rng.normal(size=size), np.zeros((size, size))
        for which, added in enumerate((row, other, work)):
            theirs = matrix.copy()
            if which == 0:
                matrix_in_place.add_to_diagonal(theirs.reshape(-1)[:: size + 1], row, flat(theirs), flat(row))
            elif which == 1:
                matrix_in_place.subtract(theirs, other, flat(theirs), flat(other))
            else:
                matrix_in_place.symmetrise(theirs, theirs.T, work, flat(theirs))
            assert library.on_matrix(which, flat(matrix), flat(added)) == 1
            assert matrix.tobytes() == theirs.tobytes()


def test_matrices_of_other_sizes_are_refused(library: Any) -> None:
    for which, size in ((0, 3), (1, 5)):
        with pytest.raises(TypeError):
            library.on_matrix(which, flat(np.zeros((2, 2))), flat(np.zeros(size)))


def test_bytes(library: Any) -> None:
    for data in (b"", b"a", bytes(range(256)), b"GNGGA,120000.00,5900.0"):
        assert library.sum_bytes(data) == sum(data)
        assert library.checksum(data) == reduce(xor, data, 0)
        if len(data) <= 128:
            assert library.checksum(data) == checksum(data)


def _value(rng: random.Random, form: str, tick_us: int) -> Any:
    """A number that the form mostly holds."""
    if rng.random() < 0.02:
        return rng.choice([None, math.nan, math.inf, -math.inf, 1e300, 0.1, -0.0, 3])
    if form == "u":
        return (tick_us - rng.randint(-200_000, 3_000_000)) / 1e6
    if form == "q":
        return rng.choice([math.nan, 0, -5, 2**62, 1_780_315_200_000_000_000])
    exact: float = ctypes.c_float(rng.gauss(0.0, 100.0)).value
    return float(f"{exact:.7g}") if form == "s" else exact


@pytest.mark.parametrize("forms", ["uffff", "dq", "usfd", "us", "fqs"])
def test_columns(library: Any, forms: str) -> None:
    rng, held = random.Random(forms), 0
    for n in range(2000):
        count, tick_us = rng.randint(1, 10), rng.randint(0, 10**10)
        rows: list[Any] = [tuple(_value(rng, form, tick_us) for form in forms) for _ in range(count)]
        if n % 7 == 0:
            rows = [list(row) for row in rows]
        packer = Packer(b"\x0a\x03imu", forms, count)
        try:
            expected = narrowed(packer, rows, tick_us)
        except TypeError:  # an infinity for a whole number
            continue
        assert library.narrowed(packer, rows, tick_us) == expected
        held += expected is not None
    assert held > 200
