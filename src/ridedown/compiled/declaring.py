"""What is compiled: kernels, their parts, and the types that a kernel's annotations say."""

from __future__ import annotations

import ctypes
import functools
import typing
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar, cast

import numpy as np

F = TypeVar("F", bound=Callable[..., Any])

INSTRUCTIONS: list[str] = []
"""Modules to import before anything is compiled."""


def instructions(module: str) -> None:
    """Name a module that teaches numba types and functions; it is imported when something has to be compiled, and only then."""
    INSTRUCTIONS.append(module)


def part(function: F) -> F:
    """Compile `function` into the kernels that call it; Python cannot."""
    return cast("F", Part(function, inline=False))


def inlined(function: F) -> F:
    """Put `function`, a few lines, into every place that calls it; Python cannot."""
    return cast("F", Part(function, inline=True))


class Part:
    """A function compiled into the kernels that call it."""

    def __init__(self, function: Callable[..., Any], *, inline: bool) -> None:
        functools.update_wrapper(cast("Any", self), function)
        self.function = function
        self.inline = inline


@dataclass(frozen=True, slots=True)
class Leaf:
    """A number, or an array of numbers, of an argument or a result.

    code: of a number, as `struct` has it: "q" whole, "d" floating, "?" true or false. dimensions: of an array, 0 for a number.
    """

    name: str
    code: str
    dimensions: int = 0

    @property
    def layout(self) -> str:
        """How it is passed, as `struct` has it, each value in eight bytes: an array as its address and its shape."""
        return f"Q{self.dimensions}q" if self.dimensions else _WIDE[self.code]

    @property
    def dtype(self) -> np.dtype[Any]:
        """The type of an array's elements."""
        return _DTYPES[self.code]

    def __str__(self) -> str:
        kind = str(self.dtype)
        return f"{self.name} ({kind}, {self.dimensions} dimensions)" if self.dimensions else f"{self.name} ({kind})"


_CODES = {int: "q", float: "d", bool: "?"}
_WIDE = {"q": "q", "d": "d", "?": "?7x"}
_DTYPES: dict[str, np.dtype[Any]] = {"q": np.dtype(np.int64), "d": np.dtype(np.float64), "?": np.dtype(np.bool_)}


Find = ctypes.CFUNCTYPE(ctypes.c_void_p)


class Cell(ctypes.Structure):
    """Where kernels find another: its address, once there is one, and until then what to call for it."""

    _fields_ = (("address", ctypes.c_void_p), ("find", Find))


class Declared:
    """A function to be compiled on its own, for the types of its annotations."""

    def __init__(self, function: Callable[..., Any]) -> None:
        functools.update_wrapper(cast("Any", self), function)
        self.function = function
        self.name = f"{function.__module__}:{function.__name__}"

    @cached_property
    def parameters(self) -> dict[str, Any]:
        """The annotation of each parameter, in their order."""
        code = self.function.__code__
        return {name: self._hints[name] for name in code.co_varnames[: code.co_argcount]}

    @property
    def result(self) -> Any:
        """The annotation of what is returned."""
        return self._hints["return"]

    @cached_property
    def _hints(self) -> dict[str, Any]:
        return typing.get_type_hints(self.function)


def array_of(hint: Any) -> tuple[Any, int] | None:
    """What an array annotated so holds, `int` or `float`, and its number of dimensions; None where it is no array."""
    if typing.get_origin(hint) is not np.ndarray:
        return None
    shape, kind = typing.get_args(hint)
    lengths = typing.get_args(shape)
    return {np.float64: float, np.int64: int}[typing.get_args(kind)[0]], 1 if Ellipsis in lengths else len(lengths)


def fields_of(hint: Any) -> dict[str, Any]:
    """The annotations of a tuple's entries, or of a named tuple's."""
    if typing.get_origin(hint) is tuple:
        return {str(i): entry for i, entry in enumerate(typing.get_args(hint))}
    return typing.get_type_hints(hint)


def leaves(name: str, hint: Any) -> Iterator[Leaf]:
    """The numbers and arrays of what is annotated so, in their order; none for None."""
    if hint is type(None):
        return
    if hint in _CODES:
        yield Leaf(name, _CODES[hint])
    elif array := array_of(hint):
        yield Leaf(name, _CODES[array[0]], array[1])
    else:
        for field, inner in fields_of(hint).items():
            yield from leaves(f"{name}.{field}", inner)
