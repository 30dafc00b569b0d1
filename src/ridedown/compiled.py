"""Compiling the kernels, and keeping what was compiled.

A *kernel* is compiled on its own, for the types that its annotations say, and kept. Python calls it, and so do other kernels,
by its address: its code is not compiled again in those that call it, and kernels can be compiled side by side, in processes
of their own. A *part* is compiled into each kernel that calls it; what is *inlined*, into each place.

Numba's own cache does not notice an edit in a part that another file calls, so the folder of the compiled code carries a hash
of every source of the package that a kernel is in: a changed source is a new folder. Kernels call kernels and parts of their
own package only. Where nothing can be written, kernels are compiled anew in each process; importing never fails for it.
"""

from __future__ import annotations

import ctypes
import gc
import hashlib
import importlib
import os
import sys
import typing
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, cached_property, partial
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
from llvmlite import ir
from llvmlite.binding import add_symbol, get_host_cpu_name
from numba import __version__ as numba_version
from numba.core import config, errors, registry, types
from numba.core.typing import templates
from numba.extending import lower_builtin

F = TypeVar("F", bound=Callable[..., Any])

# Numba's own annotations are too few, or too narrow, for what follows.
_settings: Any = config
_types: Any = types
_templates: Any = templates
_lower: Any = lower_builtin
_Dispatcher: Any = registry.CPUDispatcher

# `_nrt`: without reference counts, which cost more than the arithmetic; the kernels make no arrays.
_OPTIONS: dict[str, Any] = {
    "nopython": True, "nogil": True, "_nrt": False, "error_model": "numpy", "fastmath": {"contract"}, "no_cfunc_wrapper": True,
}  # fmt: skip


def _sources_hash(package: Path) -> str:
    # numba keeps what it compiled by the path of its source and by processor, so another checkout, or another machine that
    # has the same home, starts cold: its folder is another one
    digest = hashlib.sha256(f"{numba_version} {sys.version} {get_host_cpu_name()} {package}".encode())
    for source in (Path(__file__), *sorted(package.glob("*.py"))):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _user_cache() -> Path:
    root = os.environ.get("RIDEDOWN_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
    if root:
        return Path(root) / "ridedown"
    if sys.platform == "win32" and os.environ.get("LOCALAPPDATA"):
        return Path(os.environ["LOCALAPPDATA"]) / "ridedown" / "cache"
    return Path.home() / ".cache" / "ridedown"


@cache
def folder_of(package: Path) -> Path | None:
    """Where the compiled kernels of the package in this folder are kept, or None where nothing can be written."""
    try:
        folder = _user_cache() / f"{package.name}-{_sources_hash(package)}"
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):  # RuntimeError: no home directory
        return None
    return folder if os.access(folder, os.W_OK) else None


def part(function: F) -> F:
    """Compile `function` for other kernels to call; Python cannot."""
    return cast("F", _Part(function, targetoptions={**_OPTIONS, "no_cpython_wrapper": True}))


def inlined(function: F) -> F:
    """Put `function`, a few lines, into the kernels that call it."""
    return cast("F", _Part(function, targetoptions={**_OPTIONS, "no_cpython_wrapper": True, "forceinline": True}))


def kernel(function: F) -> F:
    """Compile `function` on its own, for Python and other kernels to call; kept in the folder of its package's version.

    Every parameter and what is returned is annotated: `int`, `float`, `bool`, arrays (`NDArray` of one dimension, or
    `np.ndarray` with its shape), named tuples and tuples of these. Arrays lie in C order and can be written.
    """
    return cast("F", _Kernel(function))


_KERNELS: list[_Kernel] = []
"""Those of the modules imported so far."""


def unkept(name: str) -> list[str]:
    """The kernels whose names start so, of the modules imported so far, that have yet to be compiled: callers come first."""
    return [each.name for each in reversed(_KERNELS) if each.name.startswith(name) and not each.is_kept()]


def can_be_kept(name: str) -> bool:
    """Whether there is a folder to keep the kernel of this name in."""
    return _kernel_named(name).folder is not None


def build(name: str) -> None:
    """Compile the kernel of this name and keep it, but none of those it calls."""
    _kernel_named(name).build()


class _Part(_Dispatcher):  # type: ignore[misc]
    """A function compiled into the kernels that call it."""

    def get_call_template(self, args: Any, kws: Any) -> Any:
        # a variable that starts from a constant is first taken for that constant: that would be compiled, then the rest again
        return super().get_call_template([_types.unliteral(kind) for kind in args], kws)


class _Kernel(_Dispatcher):  # type: ignore[misc]
    """A function compiled on its own, which kernels call by its address.

    They read the address from a cell at run time, so that neither waits for the other to be compiled; its symbol is the
    kernel's name. It is filled when a kernel that calls this one has been compiled or loaded, before that one can be called.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function, targetoptions=_OPTIONS)
        self.name = f"{function.__module__}:{function.__name__}"
        self._alone = False
        self._cell = ctypes.c_void_p()
        add_symbol(self.name, ctypes.addressof(self._cell))
        self._keep(function)
        _KERNELS.append(self)

    def _keep(self, function: Callable[..., Any]) -> None:
        folder = self.folder = folder_of(Path(function.__code__.co_filename).resolve().parent)
        if folder is None:
            return
        before = _settings.CACHE_DIR
        _settings.CACHE_DIR = str(folder)  # read by numba here, and only here
        try:
            self.enable_caching()
        except RuntimeError:  # no locator could use the folder
            pass
        finally:
            _settings.CACHE_DIR = before

    def is_kept(self) -> bool:
        """Whether it was compiled before."""
        module, function = self.name.rsplit(".", 1)[-1].split(":")
        return self.folder is not None and any(self.folder.rglob(f"{module}.{function}-*.nbc"))

    @cached_property
    def declared(self) -> Any:
        """Its signature, as its annotations say."""
        hints = typing.get_type_hints(self.py_func)
        code = self.py_func.__code__
        names = code.co_varnames[: code.co_argcount]
        return _templates.signature(_type_of(hints["return"]), *(_type_of(hints[name]) for name in names))

    def build(self) -> None:
        """Compile it and keep it, but none of those it calls: it cannot be called here unless they are made ready."""
        self._alone = True
        try:
            self.compile(self.declared)
        finally:
            self._alone = False

    def compile(self, sig: Any) -> Any:
        """As numba does, but for the declared types with what they say is returned: it is kept under both."""
        with _no_garbage_collected():
            return super().compile(self.declared if sig == self.declared.args else sig)

    def add_overload(self, compiled: Any) -> None:
        """As numba does once it has compiled it, or loaded it: from here on any thread may call it."""
        for make_ready in () if self._alone else compiled.reload_init:
            make_ready()
        super().add_overload(compiled)

    def ready(self) -> None:
        """Make its address known to the kernels that call it."""
        if self._cell.value is None:
            self.compile(self.declared)
            compiled = self.overloads[tuple(self.declared.args)]
            self._cell.value = compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name)

    def get_call_template(self, args: Any, kws: Any) -> Any:  # noqa: ARG002
        """How numba learns what a call of it from another kernel gives: without compiling it."""
        kinds, name = self.declared, self.name

        class Template(_templates.AbstractTemplate):  # type: ignore[misc]
            key = name

            def generic(self, given: Any, kws: Any) -> Any:  # noqa: ARG002
                pairs = zip(given, kinds.args, strict=False)
                if len(given) != len(kinds.args) or None in [self.context.can_convert(*pair) for pair in pairs]:
                    raise errors.TypingError(f"{name} takes {kinds.args}, and is given {given}")
                return kinds

        return Template, None, args, {}

    def get_overload(self, sig: Any) -> Any:  # noqa: ARG002
        """What numba finds the instructions of such a call by."""
        return _lowering_of(self)


@cache
def _lowering_of(called: _Kernel) -> str:
    name = called.name

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        convention, module = context.call_conv, builder.module
        kind = convention.get_function_type(sig.return_type, sig.args).as_pointer()
        cell = module.globals.get(name) or ir.GlobalVariable(module, kind, name)
        address = builder.load(cell)
        with builder.if_then(builder.icmp_unsigned("==", address, kind(None)), likely=False):
            convention.return_user_exc(builder, RuntimeError, (f"{name} was not made ready",))
        status, result = convention.call_function(builder, address, sig.return_type, sig.args, args)
        with builder.if_then(status.is_error, likely=False):
            convention.return_status_propagate(builder, status)
        context.active_code_library._reload_init.add(partial(_make_ready, name))  # noqa: SLF001
        return result

    _lower(name, *called.declared.args)(lower)
    return name


def _kernel_named(name: str) -> _Kernel:
    module, function = name.split(":")
    return cast("_Kernel", getattr(importlib.import_module(module), function))


def _make_ready(name: str) -> None:
    _kernel_named(name).ready()


def _type_of(hint: Any) -> Any:
    """The compiled type that an annotation stands for."""
    plain = {int: _types.int64, float: _types.float64, bool: _types.boolean, type(None): _types.none}
    if hint in plain:
        return plain[hint]
    arguments = typing.get_args(hint)
    if typing.get_origin(hint) is np.ndarray:
        shape, kind = arguments
        lengths = typing.get_args(shape)
        element = _type_of({np.float64: float, np.int64: int}[typing.get_args(kind)[0]])
        return _types.Array(element, 1 if Ellipsis in lengths else len(lengths), "C")
    if typing.get_origin(hint) is tuple:
        return _types.Tuple.from_types([_type_of(argument) for argument in arguments])
    return _types.BaseTuple.from_types([_type_of(field) for field in typing.get_type_hints(hint).values()], hint)


@contextmanager
def _no_garbage_collected() -> Iterator[None]:
    """Compiling makes millions of objects that stay: looking through them for garbage takes a fifth of the time."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()
