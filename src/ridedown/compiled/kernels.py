"""Kernels as Python calls them: loaded when they are first called, compiled before that where they are not kept."""

from __future__ import annotations

import ctypes
import importlib
import struct
import threading
from collections.abc import Callable, Iterable
from functools import cached_property
from pathlib import Path
from typing import Any, cast

from ridedown.compiled.declaring import Cell, Declared, F, Find, Leaf, leaves
from ridedown.compiled.keeping import folder_of, is_kept, keep, kept
from ridedown.compiled.loading import Entry, load, name_address

_LOADING = threading.RLock()


def kernel(function: F) -> F:
    """Compile `function` on its own, for Python and other kernels to call; kept in the folder of its package's version.

    Every parameter and what is returned is annotated: `int`, `float`, `bool`, arrays (`NDArray` of one dimension, or
    `np.ndarray` with its shape), named tuples and tuples of these. Arrays lie in C order and can be written. What is returned
    is a number, a tuple or named tuple of numbers, or None.
    """
    return cast("F", Kernel(function))


_KERNELS: list[Kernel] = []
"""Those of the modules imported so far."""


def unkept(name: str) -> list[str]:
    """The kernels whose names start so, of the modules imported so far, that have yet to be compiled: callers come first."""
    return [each.name for each in reversed(_KERNELS) if each.name.startswith(name) and not each.is_kept()]


def can_be_kept(name: str) -> bool:
    """Whether there is a folder to keep the kernel of this name in."""
    return _kernel_named(name).folder is not None


def build(name: str) -> None:
    """Compile the kernel of this name and keep it."""
    _kernel_named(name).build()


def _kernel_named(name: str) -> Kernel:
    module, function = name.split(":")
    return cast("Kernel", getattr(importlib.import_module(module), function))


class Kernel(Declared):
    """A function compiled on its own.

    Other kernels read its address from its cell, whose symbol is the kernel's name: neither waits for the other to be compiled.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        self._entry: Any = None
        self._cell = Cell(None, Find(self._found))
        name_address(self.name, ctypes.addressof(self._cell))
        _KERNELS.append(self)

    @cached_property
    def folder(self) -> Path | None:
        """Where it is kept; None where nothing can be."""
        return folder_of(Path(self.function.__code__.co_filename).resolve().parent)

    def is_kept(self) -> bool:
        """Whether it was compiled before."""
        return self.folder is not None and is_kept(self.folder, self.name)

    def build(self) -> tuple[bytes, bytes]:
        """Compile it and keep it, but none of those it calls."""
        from ridedown.compiled.compiling import machine_code  # noqa: PLC0415 - numba takes half a second

        code, entry = machine_code(self)
        if self.folder is not None:
            keep(self.folder, self.name, code, entry)
        return code, entry

    def __call__(self, *arguments: Any) -> Any:
        """Call it from Python. Raises: TypeError for arguments of other types than declared."""
        entry = self._entry or self._ready()
        results = ctypes.create_string_buffer(self._results.size)
        if entry(self._packed(arguments), results):
            raise vars(_PROBLEM).pop("found", RuntimeError(f"{self.name} failed"))
        return self._unpacked(results.raw)

    def _ready(self) -> Any:
        """Load it, so that it can be called."""
        with _LOADING:
            if self._entry is None:
                code, entry = (self.folder and kept(self.folder, self.name)) or self.build()
                self._cell.address, address = load(code, entry)
                self._entry = Entry(address)
        return self._entry

    def _found(self) -> int | None:
        """Its address, for a kernel that calls it and found none in its cell."""
        try:
            self._ready()
        except BaseException as problem:  # raised where Python called
            _PROBLEM.found = problem
            return None
        return cast("int", self._cell.address)

    @cached_property
    def _leaves(self) -> list[Leaf]:
        return [leaf for name, hint in self.parameters.items() for leaf in leaves(name, hint)]

    @cached_property
    def _kinds(self) -> list[tuple[Any, int]]:
        return [(leaf.dtype, leaf.dimensions) for leaf in self._leaves]

    @cached_property
    def _arguments(self) -> struct.Struct:
        return _layout(self._leaves)

    @cached_property
    def _results(self) -> struct.Struct:
        return _layout(leaves("result", self.result))

    def _packed(self, arguments: tuple[Any, ...]) -> bytes:
        values: list[Any] = []
        for argument in arguments:
            if isinstance(argument, tuple):
                values.extend(argument)
            else:
                values.append(argument)
        packed: list[Any] = []
        try:
            for (dtype, dimensions), value in zip(self._kinds, values, strict=True):
                if not dimensions:
                    packed.append(value)
                elif value.dtype == dtype and value.ndim == dimensions:
                    packed.append(ctypes.addressof(_view(value)))
                    packed.extend(value.shape)
                else:
                    raise TypeError(f"got {value.dtype}, {value.ndim} dimensions")
            return self._arguments.pack(*packed)
        except (AttributeError, TypeError, ValueError, BufferError, struct.error) as problem:
            takes = ", ".join(map(str, self._leaves))
            raise TypeError(f"{self.name} takes {takes}: {problem}") from problem

    def _unpacked(self, results: bytes) -> Any:
        values = self._results.unpack(results)
        hint = self.result
        if hasattr(hint, "_fields"):
            return hint(*values)
        if hint is type(None):
            return None
        return values[0] if hint in {int, float, bool} else values


_PROBLEM = threading.local()
"""What went wrong in a kernel that was called by another, in this thread."""

_view = (ctypes.c_char * 0).from_buffer
"""Refuses an array that is not in C order, or cannot be written."""


def _layout(found: Iterable[Leaf]) -> struct.Struct:
    return struct.Struct("=" + "".join(leaf.layout for leaf in found))
