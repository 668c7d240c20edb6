"""Several sensors side by side in one register of the machine, for compiled filters.

A `Lanes` holds `LANES` numbers that one instruction adds or multiplies, a `Mask` as many truth values. What happens
in a lane is the IEEE arithmetic of a lone number and does not depend on its neighbours, so neither does a result.
Branches become `chosen`.

To Python a lane is what it holds, a float or a bool: the same steps run uncompiled for one sensor (`of_one`).
"""

import math
import operator
from collections.abc import Callable, Iterator
from typing import Any, Final, TypeVar, cast

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, ConcreteTemplate, infer_global, signature
from numba.extending import lower_builtin, models, register_model

from estimators.compiling import compiled
from estimators.recording import Float

F = TypeVar("F", bound=Callable[..., Any])

LANES: Final = 4
"""Seventeen sensors fill five groups of four better than three of eight, which measured slower as well."""


class LanesType(types.Type):  # type: ignore[misc]
    """Numba's type of as many numbers as there are lanes."""

    def __init__(self) -> None:
        super().__init__(name=f"Lanes{LANES}")


class MaskType(types.Type):  # type: ignore[misc]
    """Numba's type of as many truth values as there are lanes."""

    def __init__(self) -> None:
        super().__init__(name=f"Mask{LANES}")


LANES_TYPE, MASK_TYPE = LanesType(), MaskType()
QUATERNION_TYPE, VECTOR_TYPE = types.UniTuple(LANES_TYPE, 4), types.UniTuple(LANES_TYPE, 3)

_NUMBERS, _TRUTHS = ir.VectorType(ir.DoubleType(), LANES), ir.VectorType(ir.IntType(1), LANES)
_NOTHING = ir.Constant(_NUMBERS, ir.Undefined)
_FIRST_EVERYWHERE = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
_SLOT = ir.IntType(32)
_EITHER = (LANES_TYPE, types.float64)


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _NUMBERS)


@register_model(MaskType)
class _MaskModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _TRUTHS)


def in_lanes(signature_: Any, *, inlined: bool = True) -> Callable[[F], F]:
    """Compile a step of a filter over lanes, for compiled callers only; as `kernel`, with a type as the signature."""
    return compiled(signature_, forceinline=inlined, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def of_one(step: F) -> F:
    """Return the uncompiled form of a step, which works on plain numbers."""
    return cast(F, cast(Any, step).py_func)


def chosen(mask: bool, yes: float, no: float) -> float:
    """Return `yes` where the mask is true and `no` elsewhere."""
    return yes if mask else no


def anywhere(mask: bool) -> bool:
    """Say whether the mask is true in any lane."""
    return mask


def at_least(value: float, least: float) -> float:
    """Return the larger of a value and a bound."""
    return value if value > least else least


def at_most(value: float, most: float) -> float:
    """Return the smaller of a value and a bound."""
    return value if value < most else most


def spread(value: float) -> float:
    """Return the same number in every lane."""
    return value


def column(array: Float, at: tuple[int, ...]) -> float:
    """Return array[row, ...] of the rows side by side, `at` = (row, last, ...); beyond the last row that again."""
    return float(array[(at[0], *at[2:])])


def put_column(array: Float, at: tuple[int, ...], value: float) -> None:
    """Write array[row, ...] of the rows side by side, `at` = (row, last, ...), up to the last."""
    array[(at[0], *at[2:])] = value


def _spread(builder: Any, value: Any) -> Any:
    if value.type == _NUMBERS:
        return value
    return builder.shuffle_vector(
        builder.insert_element(_NOTHING, value, _SLOT(0)), _NOTHING, _FIRST_EVERYWHERE
    )


def _teach(function: Any, result: Any, kinds: list[tuple[Any, ...]], build: Callable[..., Any]) -> None:
    """Let compiled code call a function or operator; `build(builder, *values)` makes its instructions."""
    cases = [signature(result, *kind) for kind in kinds]
    infer_global(function)(type("_", (ConcreteTemplate,), {"cases": cases}))
    for kind in kinds:
        lower_builtin(function, *kind)(lambda context, builder, sig, args: build(builder, *args))


def _teach_pair(function: Any, result: Any, instruction: str, *first: str) -> None:
    """Let compiled code use an operator of two lanes, or of one and the same number for all."""
    kinds = [(a, b) for a in _EITHER for b in _EITHER if LANES_TYPE in (a, b)]

    def build(builder: Any, a: Any, b: Any) -> Any:
        return getattr(builder, instruction)(*first, _spread(builder, a), _spread(builder, b))

    _teach(function, result, kinds, build)


def _bounded(sign: str) -> Callable[..., Any]:
    def build(builder: Any, value: Any, bound: Any) -> Any:
        bounds = _spread(builder, bound)
        return builder.select(builder.fcmp_ordered(sign, value, bounds), value, bounds)

    return build


def _teach_call(function: Any, name: str) -> None:
    def build(builder: Any, value: Any) -> Any:
        kind = ir.FunctionType(_NUMBERS, [_NUMBERS])
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), [value])

    _teach(function, LANES_TYPE, [(LANES_TYPE,)], build)


def _teach_lane_by_lane(function: Any) -> None:
    """Let compiled code call a function that the machine has for one number only."""
    alone = signature(types.float64, types.float64)
    cases = [signature(LANES_TYPE, LANES_TYPE)]
    infer_global(function)(type("_", (ConcreteTemplate,), {"cases": cases}))

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        call = context.get_function(function, alone)
        found = _NOTHING
        for lane in range(LANES):
            value = call(builder, [builder.extract_element(args[0], _SLOT(lane))])
            found = builder.insert_element(found, value, _SLOT(lane))
        return found

    lower_builtin(function, LANES_TYPE)(lower)


for _operators, _instruction in (
    ((operator.add, operator.iadd), "fadd"),
    ((operator.sub, operator.isub), "fsub"),
    ((operator.mul, operator.imul), "fmul"),
    ((operator.truediv,), "fdiv"),
):
    for _operator in _operators:
        _teach_pair(_operator, LANES_TYPE, _instruction)
for _operator, _sign in ((operator.lt, "<"), (operator.gt, ">"), (operator.le, "<="), (operator.ge, ">=")):
    _teach_pair(_operator, MASK_TYPE, "fcmp_ordered", _sign)
_teach(operator.neg, LANES_TYPE, [(LANES_TYPE,)], lambda builder, value: builder.fneg(value))
_teach_call(math.sqrt, f"llvm.sqrt.v{LANES}f64")
_teach_call(abs, f"llvm.fabs.v{LANES}f64")
_teach_lane_by_lane(math.sin)
_teach_lane_by_lane(math.cos)
_MASKS = [(MASK_TYPE, MASK_TYPE)]
_teach(operator.and_, MASK_TYPE, _MASKS, lambda builder, a, b: builder.and_(a, b))
_teach(operator.or_, MASK_TYPE, _MASKS, lambda builder, a, b: builder.or_(a, b))
_teach(operator.invert, MASK_TYPE, [(MASK_TYPE,)], lambda builder, mask: builder.not_(mask))
_teach(spread, LANES_TYPE, [(types.float64,)], _spread)
_teach(
    chosen,
    LANES_TYPE,
    [(MASK_TYPE, a, b) for a in _EITHER for b in _EITHER],
    lambda builder, mask, a, b: builder.select(mask, _spread(builder, a), _spread(builder, b)),
)
_BOUND = [(LANES_TYPE, types.float64)]
for _function, _sign in ((at_least, ">"), (at_most, "<")):
    _teach(_function, LANES_TYPE, _BOUND, _bounded(_sign))
_teach(
    anywhere,
    types.boolean,
    [(MASK_TYPE,)],
    lambda builder, mask: builder.icmp_unsigned(
        "!=", builder.bitcast(mask, ir.IntType(LANES)), ir.IntType(LANES)(0)
    ),
)


def _places(context: Any, builder: Any, sig: Any, args: Any) -> Iterator[Any]:
    """Where the numbers of the lanes are: rows from `at[0]` to at most `at[1]`, the rest of `at` in each."""
    view = context.make_array(sig.args[0])(context, builder, args[0])
    row, last, *inner = cgutils.unpack_tuple(builder, args[1])
    for lane in range(LANES):
        wanted = builder.add(row, row.type(lane))
        place = builder.select(builder.icmp_signed("<", wanted, last), wanted, last) if lane else row
        for axis, number in enumerate(inner, 1):
            place = builder.add(builder.mul(place, builder.extract_value(view.shape, axis)), number)
        yield builder.gep(view.data, [place])


@infer_global(column)
class _ColumnTemplate(AbstractTemplate):  # type: ignore[misc]
    def generic(self, args: Any, kws: Any) -> Any:
        return signature(LANES_TYPE, *args)


@infer_global(put_column)
class _PutColumnTemplate(AbstractTemplate):  # type: ignore[misc]
    def generic(self, args: Any, kws: Any) -> Any:
        return signature(types.void, *args)


@lower_builtin(column, types.Array, types.BaseTuple)  # type: ignore[untyped-decorator]
def _lower_column(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    found = _NOTHING
    for lane, place in enumerate(_places(context, builder, sig, args)):
        found = builder.insert_element(found, builder.load(place), _SLOT(lane))
    return found


@lower_builtin(put_column, types.Array, types.BaseTuple, LanesType)  # type: ignore[untyped-decorator]
def _lower_put_column(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    # From behind, so that the last row keeps what belongs to it.
    for lane, place in reversed(list(enumerate(_places(context, builder, sig, args)))):
        builder.store(builder.extract_element(args[2], _SLOT(lane)), place)
    return context.get_dummy_value()


__all__ = [
    "LANES",
    "LANES_TYPE",
    "MASK_TYPE",
    "QUATERNION_TYPE",
    "VECTOR_TYPE",
    "anywhere",
    "at_least",
    "at_most",
    "chosen",
    "column",
    "in_lanes",
    "of_one",
    "put_column",
    "spread",
]
