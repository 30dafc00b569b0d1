"""The types and the instructions of vectors, for numba: what `vector` names, and arithmetic and comparisons.

Imported only where something is compiled.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any, TypeVar

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.typing.templates import AbstractTemplate, infer_global, make_intrinsic_template, signature
from numba.extending import lower_builtin, models, register_model

from ridedown.solver import vector
from ridedown.solver.vector import WIDTH

F = TypeVar("F", bound=Callable[..., Any])

_DOUBLES = ir.VectorType(ir.DoubleType(), WIDTH)
_WHOLE = ir.VectorType(ir.IntType(64), WIDTH)
_BOOLS = ir.VectorType(ir.IntType(1), WIDTH)


class _Vector(types.Type):
    """Eight numbers."""

    def __init__(self) -> None:
        super().__init__(name="vector")


class _Mask(types.Type):
    """Eight truths."""

    def __init__(self) -> None:
        super().__init__(name="mask")


_vector, _mask = _Vector(), _Mask()
_number = (types.Float, types.Integer)


@register_model(_Vector)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, _DOUBLES)


@register_model(_Mask)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, _BOOLS)


def _eight(builder: Any, value: Any) -> Any:
    """One number as eight."""
    first = builder.insert_element(ir.Constant(_DOUBLES, ir.Undefined), value, ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(first, first, ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH))


def _call(builder: Any, name: str, value: Any) -> Any:
    function = cgutils.get_or_insert_function(builder.module, ir.FunctionType(_DOUBLES, [_DOUBLES]), name)
    return builder.call(function, [value])


def _as_vector(context: Any, builder: Any, value: Any, kind: Any) -> Any:
    if isinstance(kind, _Vector):
        return value
    return _eight(builder, context.cast(builder, value, kind, types.float64))


def _define(functions: tuple[Any, ...], result: Any, emit: Any) -> None:
    """Give operators of two vectors, or of a vector and a number, their type and their instructions."""

    def generic(self: Any, args: Any, kws: Any) -> Any:  # noqa: ARG001
        known = len(args) == 2 and all(isinstance(a, (_Vector, *_number)) for a in args)
        return signature(result, *args) if known and any(isinstance(a, _Vector) for a in args) else None

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        a, b = (_as_vector(context, builder, value, kind) for value, kind in zip(args, sig.args, strict=True))
        return emit(builder, a, b)

    for function in functions:
        infer_global(function)(type("_Template", (AbstractTemplate,), {"generic": generic}))
        for pair in ((_Vector, _Vector), *((_Vector, n) for n in _number), *((n, _Vector) for n in _number)):
            lower_builtin(function, *pair)(lower)


def _compare(sign: str) -> Any:
    return lambda builder, a, b: builder.fcmp_ordered(sign, a, b)


_define((operator.add, operator.iadd), _vector, lambda builder, a, b: builder.fadd(a, b))
_define((operator.sub, operator.isub), _vector, lambda builder, a, b: builder.fsub(a, b))
_define((operator.mul, operator.imul), _vector, lambda builder, a, b: builder.fmul(a, b))
_define((operator.truediv,), _vector, lambda builder, a, b: builder.fdiv(a, b))
# as for plain numbers, what is no number stays so where it comes first
_define((min,), _vector, lambda builder, a, b: builder.select(builder.fcmp_ordered("<", b, a), b, a))
_define((max,), _vector, lambda builder, a, b: builder.select(builder.fcmp_ordered(">", b, a), b, a))
for _function, _sign in ((operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"), (operator.ge, ">="), (operator.eq, "==")):
    _define((_function,), _mask, _compare(_sign))


def _define_logic(functions: tuple[Any, ...], emit: Any) -> None:
    def generic(self: Any, args: Any, kws: Any) -> Any:  # noqa: ARG001
        return signature(_mask, *args) if len(args) == 2 and all(isinstance(a, _Mask) for a in args) else None

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
        return emit(builder, *args)

    for function in functions:
        infer_global(function)(type("_Template", (AbstractTemplate,), {"generic": generic}))
        lower_builtin(function, _Mask, _Mask)(lower)


_define_logic((operator.and_, operator.iand), lambda builder, a, b: builder.and_(a, b))
_define_logic((operator.or_, operator.ior), lambda builder, a, b: builder.or_(a, b))


@infer_global(abs)
class _Abs(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:  # noqa: ARG002
        return signature(_vector, *args) if len(args) == 1 and isinstance(args[0], _Vector) else None


@lower_builtin(abs, _Vector)
def _lower_abs(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    return _call(builder, "llvm.fabs.v8f64", args[0])


@infer_global(operator.neg)
class _Neg(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:  # noqa: ARG002
        return signature(_vector, *args) if len(args) == 1 and isinstance(args[0], _Vector) else None


@lower_builtin(operator.neg, _Vector)
def _lower_neg(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    return builder.fneg(args[0])


def _instructions_of(function: Callable[..., Any]) -> Callable[[F], F]:
    """Give a function of `vector` its type and its instructions, in the form that `numba.extending.intrinsic` takes."""

    def give(definition: F) -> F:
        infer_global(function, types.Function(make_intrinsic_template(function, definition, function.__name__)))
        return definition

    return give


def _address(context: Any, builder: Any, kind: Any, array: Any, index: Any) -> Any:
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), _DOUBLES.as_pointer())


@_instructions_of(vector.load)
def _load(typingctx, array, index):  # noqa: ARG001
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.load(_address(context, builder, sig.args[0], *args), align=8)

    return _vector(array, index), codegen


@_instructions_of(vector.store)
def _store(typingctx, array, index, value):  # noqa: ARG001
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        value = _as_vector(context, builder, args[2], sig.args[2])
        builder.store(value, _address(context, builder, sig.args[0], *args[:2]), align=8)
        return context.get_dummy_value()

    return types.void(array, index, value), codegen


@_instructions_of(vector.pick)
def _pick(typingctx, table, rows, index, column):  # noqa: ARG001
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        table, rows = (
            context.make_array(kind)(context, builder, array) for kind, array in zip(sig.args[:2], args[:2], strict=True)
        )
        _height, width = cgutils.unpack_tuple(builder, table.shape)
        first, picked = builder.gep(table.data, [args[3]]), ir.Constant(_DOUBLES, ir.Undefined)
        for n in range(WIDTH):
            lane = ir.Constant(ir.IntType(64), n)
            number = builder.load(builder.gep(rows.data, [builder.add(args[2], lane)]))
            value = builder.load(builder.gep(first, [builder.mul(number, width)]))
            picked = builder.insert_element(picked, value, ir.Constant(ir.IntType(32), n))
        return picked

    return _vector(table, rows, index, column), codegen


@_instructions_of(vector.spread)
def _spread(typingctx, number):  # noqa: ARG001
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _as_vector(context, builder, args[0], sig.args[0])

    return _vector(number), codegen


@_instructions_of(vector.where)
def _where(typingctx, mask, yes, no):  # noqa: ARG001
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        yes, no = (_as_vector(context, builder, value, kind) for value, kind in zip(args[1:], sig.args[1:], strict=True))
        return builder.select(args[0], yes, no)

    return _vector(mask, yes, no), codegen


@_instructions_of(vector.lanes_of)
def _lanes_of(typingctx, mask):  # noqa: ARG001
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
        return builder.zext(builder.bitcast(args[0], ir.IntType(WIDTH)), ir.IntType(64))

    return types.int64(mask), codegen


@_instructions_of(vector.union)
def _union(typingctx, array, index):  # noqa: ARG001
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = context.make_array(sig.args[0])(context, builder, args[0]).data
        eight = builder.load(builder.bitcast(builder.gep(data, [args[1]]), _WHOLE.as_pointer()), align=8)
        kind = ir.FunctionType(ir.IntType(64), [_WHOLE])
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, "llvm.vector.reduce.or.v8i64"), [eight])

    return types.int64(array, index), codegen


@_instructions_of(vector.first_lane)
def _first_lane(typingctx, bits):  # noqa: ARG001
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
        return builder.cttz(args[0], ir.Constant(ir.IntType(1), 1))

    return types.int64(bits), codegen


@_instructions_of(vector.binary_exponent)
def _binary_exponent(typingctx, value):  # noqa: ARG001
    pair = types.UniTuple(_vector, 2)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        bits = builder.bitcast(args[0], _WHOLE)
        exponent = builder.sub(builder.lshr(bits, _whole(52)), _whole(1023))
        fraction = builder.or_(builder.and_(bits, _whole((1 << 52) - 1)), _whole(1023 << 52))
        parts = [builder.sitofp(exponent, _DOUBLES), builder.bitcast(fraction, _DOUBLES)]
        return context.make_tuple(builder, sig.return_type, parts)

    return pair(value), codegen


@_instructions_of(vector.power_of_two)
def _power_of_two(typingctx, exponent):  # noqa: ARG001
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
        whole = builder.add(builder.fptosi(args[0], _WHOLE), _whole(1023))
        return builder.bitcast(builder.shl(whole, _whole(52)), _DOUBLES)

    return _vector(exponent), codegen


@_instructions_of(vector.floor)
def _floor(typingctx, value):  # noqa: ARG001
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
        return _call(builder, "llvm.floor.v8f64", args[0])

    return _vector(value), codegen


@_instructions_of(vector.count_up)
def _count_up(typingctx, counter):  # noqa: ARG001
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = context.make_array(sig.args[0])(context, builder, args[0]).data
        return builder.atomic_rmw("add", data, ir.Constant(ir.IntType(64), 1), "monotonic")

    return types.int64(counter), codegen


def _whole(number: int) -> Any:
    return ir.Constant(_WHOLE, [number] * WIDTH)
