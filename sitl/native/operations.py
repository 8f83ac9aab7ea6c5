"""Operations that mypyc gets beside its own, in `operations.h`: functions of Python's library on plain numbers, and a
few of the project's own functions that have a second form in C. The tests compare both forms.

Without them compiled code looks the function up by its name at each call, and makes objects of the numbers.
"""

from __future__ import annotations

from pathlib import Path

HEADER = Path(__file__).with_name("operations.h")

_OF_ONE = {"radians": "usv_radians", "degrees": "usv_degrees", "atan": "atan"}  # that raise nothing
_OF_ONE_RAISING = {"asin": "usv_asin", "acos": "usv_acos", "expm1": "usv_expm1"}
_OF_TWO_RAISING = {"hypot": "usv_hypot", "fmod": "usv_fmod", "remainder": "usv_remainder"}


def register() -> None:
    """Enter them into mypyc's tables; before it translates, in its process."""
    from mypyc.ir.ops import ERR_MAGIC, ERR_MAGIC_OVERLAPPING, ERR_NEVER
    from mypyc.ir.rtypes import (
        RType,
        bool_rprimitive,
        bytes_rprimitive,
        c_int_rprimitive,
        float_rprimitive,
        int_rprimitive,
        list_rprimitive,
        none_rprimitive,
        object_rprimitive,
        str_rprimitive,
    )
    from mypyc.primitives.registry import ERR_NEG_INT, binary_op, function_op, method_call_ops, method_op

    number: RType = float_rprimitive
    two = [number, number]
    for name, function in _OF_ONE.items():
        function_op(f"math.{name}", [number], number, function, ERR_NEVER)
    for name, function in _OF_ONE_RAISING.items():
        function_op(f"math.{name}", [number], number, function, ERR_MAGIC_OVERLAPPING)
    for name, function in _OF_TWO_RAISING.items():
        function_op(f"math.{name}", two, number, function, ERR_MAGIC_OVERLAPPING)
    function_op("math.hypot", [number] * 3, number, "usv_hypot3", ERR_MAGIC_OVERLAPPING)
    function_op("math.atan2", two, number, "atan2", ERR_NEVER)
    function_op("math.isfinite", [number], bool_rprimitive, "usv_isfinite", ERR_NEVER)
    function_op("builtins.round", [number], int_rprimitive, "usv_round", ERR_MAGIC)
    formats: list[tuple[RType, str, int]] = [
        (number, "usv_format_float", 2),
        (int_rprimitive, "usv_format_int", 2),
        (object_rprimitive, "PyObject_Format", 1),
    ]
    for kind, function, priority in formats:
        given: list[RType] = [kind, str_rprimitive]
        function_op("builtins.format", given, str_rprimitive, function, ERR_MAGIC, priority=priority)
    binary_op("**", two, number, ERR_MAGIC_OVERLAPPING, "usv_power")
    anything: RType = object_rprimitive
    for name, count in (("__getitem__", 2), ("__setitem__", 3)):  # mypyc's own come after these, and after its others
        own = next(op for op in method_call_ops[name] if op.arg_types == [anything] * count)
        method_call_ops[name].remove(own)
        method_op(name, own.arg_types, own.return_type, str(own.c_function_name), own.error_kind, priority=-1)
    view = [anything, int_rprimitive]
    method_op("__setitem__", [*view, number], c_int_rprimitive, "usv_set_number", ERR_NEG_INT, priority=0)
    method_op("__getitem__", view, anything, "usv_get_item", ERR_MAGIC, priority=0)
    function_op("builtins.sum", [bytes_rprimitive], object_rprimitive, "usv_sum_bytes", ERR_MAGIC)
    rows: list[RType] = [anything, list_rprimitive, int_rprimitive]
    function_op("companion.record.columns.narrowed", rows, anything, "usv_narrowed", ERR_MAGIC)
    for name in ("add_to_diagonal", "subtract", "symmetrise"):
        function_op(f"companion.nav.matrix_in_place.{name}", [anything] * 4, none_rprimitive, f"usv_{name}", ERR_MAGIC)
    for name in ("companion.io.sensors.nmea0183_fields.checksum", "sitl.emulators.nmea.exclusive_or"):
        function_op(name, [bytes_rprimitive], int_rprimitive, "usv_checksum", ERR_MAGIC)
