"""From a kernel to machine code, by numba. Importing numba takes half a second, so nothing else does."""

from __future__ import annotations

import gc
import importlib
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache, cached_property
from typing import Any

from llvmlite import ir
from numba.core import cgutils, errors, registry, types
from numba.core.compiler_lock import global_compiler_lock
from numba.core.typing import templates
from numba.extending import lower_builtin, models, register_model, typeof_impl

from ridedown.compiled.declaring import INSTRUCTIONS, Declared, Part, array_of, fields_of
from ridedown.compiled.loading import ENTRY, KERNEL

# Numba's own annotations are too few, or too narrow, for what follows.
_types: Any = types
_templates: Any = templates
_lower: Any = lower_builtin
_typeof: Any = typeof_impl
_models: Any = models
_register_model: Any = register_model
_pack: Any = cgutils.pack_array
_Dispatcher: Any = registry.CPUDispatcher

# `_nrt`: without reference counts, which cost more than the arithmetic; the kernels make no arrays.
_OPTIONS: dict[str, Any] = {
    "nopython": True, "nogil": True, "_nrt": False, "error_model": "numpy", "fastmath": {"contract"},
    "no_cpython_wrapper": True, "no_cfunc_wrapper": True,
}  # fmt: skip

_SLOT = ir.IntType(64)
_WIDTH = 8  # bytes, of whatever is in a slot or in an array
_BYTE = ir.IntType(8)
_ADDRESS = _BYTE.as_pointer()
_STATUS = ir.IntType(32)


class _Array(_types.Array):  # type: ignore[misc]
    """An array in C order that somebody else keeps: all of it follows from its address and its shape."""

    def copy(self, *changed: Any, **changes: Any) -> Any:
        """The type of a part of it: where that is in C order too, it is one of these."""
        part = super().copy(*changed, **changes)
        return _Array(part.dtype, part.ndim, "C") if part.layout == "C" and part.mutable else part


@_register_model(_Array)
class _ArrayModel(_models.ArrayModel):  # type: ignore[misc]
    """Passed on as these two; numba passes seven values, and kernels have up to sixty arrays."""

    def get_argument_type(self) -> Any:
        data = self.get_model(self.get_field_position("data"))
        return (data.get_argument_type(), *[_SLOT] * self._fe_type.ndim)

    def as_argument(self, builder: Any, value: Any) -> Any:
        shape = self.get(builder, value, "shape")
        return (self.get(builder, value, "data"), *(builder.extract_value(shape, i) for i in range(self._fe_type.ndim)))

    def from_argument(self, builder: Any, value: Any) -> Any:
        """What numba has of an array, from these."""
        data, *shape = value
        count: Any = _SLOT(1)
        strides: list[Any] = []
        for length in reversed(shape):
            strides.insert(0, builder.mul(count, _SLOT(_WIDTH)))
            count = builder.mul(count, length)
        fields = {"nitems": count, "itemsize": _SLOT(_WIDTH), "data": data}
        fields |= {"shape": _pack(builder, shape, _SLOT), "strides": _pack(builder, strides, _SLOT)}
        made = self.get_value_type()(None)
        for name, field in fields.items():
            made = self.set(builder, made, field, name)
        return made


def machine_code(declared: Declared) -> tuple[bytes, bytes]:
    """Compile a kernel, but none of those it calls: its machine code, and that of the function by which Python calls it.

    Raises: numba's own errors, for what cannot be compiled.
    """
    for module in INSTRUCTIONS:
        importlib.import_module(module)
    kernel = _kernel_of(declared)
    with global_compiler_lock, _no_garbage_collected():
        kernel.compile(kernel.signature)
        compiled = kernel.overloads[tuple(kernel.signature.args)]
        return _object_code(compiled.library), _object_code(_entry_to(compiled))


def _object_code(library: Any) -> bytes:
    _name, _kind, (code, _bitcode) = library.serialize_using_object_code()
    return bytes(code)


class _PartCompiler(_Dispatcher):  # type: ignore[misc]
    """A function compiled into the kernels that call it."""

    def get_call_template(self, args: Any, kws: Any) -> Any:
        # a variable that starts from a constant is first taken for that constant: that would be compiled, then the rest again
        return super().get_call_template([_types.unliteral(kind) for kind in args], kws)


class _KernelCompiler(_Dispatcher):  # type: ignore[misc]
    """A function compiled on its own, which kernels call by its address."""

    def __init__(self, declared: Declared) -> None:
        super().__init__(declared.function, targetoptions=_OPTIONS)
        self.declared = declared

    @cached_property
    def signature(self) -> Any:
        """Its types, as its annotations say."""
        parameters = [_type_of(hint) for hint in self.declared.parameters.values()]
        return _templates.signature(_type_of(self.declared.result), *parameters)

    def get_call_template(self, args: Any, kws: Any) -> Any:  # noqa: ARG002
        """How numba learns what a call of it from another kernel gives: without compiling it."""
        kinds, name = self.signature, self.declared.name

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
        _say_how_to_call(self)
        return self.declared.name


@cache
def _kernel_of(declared: Declared) -> _KernelCompiler:
    return _KernelCompiler(declared)


@cache
def _part_of(part: Part) -> _PartCompiler:
    inline = {"forceinline": True} if part.inline else {}
    return _PartCompiler(part.function, targetoptions=_OPTIONS | inline)


# numba meets kernels and parts as globals of the functions it compiles
_typeof.register(Declared)(lambda declared, _context: _types.Dispatcher(_kernel_of(declared)))
_typeof.register(Part)(lambda part, _context: _types.Dispatcher(_part_of(part)))


@cache
def _say_how_to_call(kernel: _KernelCompiler) -> None:
    """Tell numba the instructions of a call of this kernel from another.

    They read its address from its cell, which bears the kernel's name; while there is none, they call the function beside it,
    which loads the kernel, or compiles it.
    """
    name = kernel.declared.name

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        convention = context.call_conv
        kind = convention.get_function_type(sig.return_type, sig.args).as_pointer()
        find = ir.FunctionType(kind, []).as_pointer()
        cell = builder.module.globals.get(name) or ir.GlobalVariable(builder.module, ir.LiteralStructType([kind, find]), name)
        address, before = builder.load(_field(builder, cell, 0)), builder.block
        with builder.if_then(_is_null(builder, address), likely=False):
            found = builder.call(builder.load(_field(builder, cell, 1)), [])
            with builder.if_then(_is_null(builder, found), likely=False):
                convention.return_user_exc(builder, RuntimeError, (f"{name} could not be made ready",))
            finding = builder.block
        ready = builder.phi(kind)
        ready.add_incoming(address, before)
        ready.add_incoming(found, finding)
        status, result = convention.call_function(builder, ready, sig.return_type, sig.args, args)
        with builder.if_then(status.is_error, likely=False):
            convention.return_status_propagate(builder, status)
        return result

    _lower(name, *kernel.signature.args)(lower)


def _field(builder: Any, structure: Any, number: int) -> Any:
    return builder.gep(structure, [ir.Constant(_STATUS, 0), ir.Constant(_STATUS, number)], inbounds=True)


def _is_null(builder: Any, pointer: Any) -> Any:
    return builder.icmp_unsigned("==", pointer, pointer.type(None))


def _entry_to(compiled: Any) -> Any:
    """The function by which Python calls a kernel: it unpacks arguments, calls, and packs what is returned (see `loading`)."""
    context, described = compiled.target_context, compiled.fndesc
    library = context.codegen().create_library(f"entry to {described.qualname}")
    library.enable_object_caching()
    module = library.create_ir_module("entry")
    kernel = context.declare_function(module, described)
    pointer = ir.GlobalVariable(module, kernel.type, KERNEL)
    pointer.initializer, pointer.global_constant = kernel, True
    function = ir.Function(module, ir.FunctionType(_STATUS, [_ADDRESS, _ADDRESS]), ENTRY)
    builder = ir.IRBuilder(function.append_basic_block())
    arguments = _Slots(context, builder, function.args[0])
    given = [arguments.next(kind) for kind in compiled.signature.args]
    status, result = context.call_conv.call_function(builder, kernel, described.restype, described.argtypes, given)
    with builder.if_then(status.is_error, likely=False):
        builder.ret(_STATUS(1))
    _Slots(context, builder, function.args[1]).put(compiled.signature.return_type, result)
    builder.ret(_STATUS(0))
    library.add_ir_module(module)
    library.finalize()
    return library


class _Slots:
    """Values in eight bytes each, one after the other, as `declaring.leaves` has them."""

    def __init__(self, context: Any, builder: Any, room: Any) -> None:
        self.context, self.builder, self.room, self.number = context, builder, room, 0

    def next(self, kind: Any) -> Any:
        """The next value, of that type."""
        if isinstance(kind, _types.Array):
            return self._array(kind)
        if isinstance(kind, _types.BaseTuple):
            return self.context.make_tuple(self.builder, kind, [self.next(inner) for inner in kind])
        if kind == _types.boolean:
            return self.builder.icmp_unsigned("!=", self.builder.load(self._slot(_BYTE)), _BYTE(0))
        return self.builder.load(self._slot(self.context.get_value_type(kind)))

    def put(self, kind: Any, value: Any) -> None:
        """Put a value of that type next."""
        if kind == _types.none:
            return
        if isinstance(kind, _types.BaseTuple):
            for i, inner in enumerate(kind):
                self.put(inner, self.builder.extract_value(value, i))
            return
        if kind == _types.boolean:
            value = self.builder.zext(value, _BYTE)
        self.builder.store(value, self._slot(value.type))

    def _array(self, kind: Any) -> Any:
        data = self.builder.load(self._slot(self.context.get_data_type(kind.dtype).as_pointer()))
        shape = [self.builder.load(self._slot(_SLOT)) for _ in range(kind.ndim)]
        return self.context.data_model_manager[kind].from_argument(self.builder, (data, *shape))

    def _slot(self, kind: Any) -> Any:
        place = self.builder.gep(self.room, [_SLOT(_WIDTH * self.number)])
        self.number += 1
        return self.builder.bitcast(place, kind.as_pointer())


def _type_of(hint: Any) -> Any:
    """The compiled type that an annotation stands for."""
    plain = {int: _types.int64, float: _types.float64, bool: _types.boolean, type(None): _types.none}
    if hint in plain:
        return plain[hint]
    if array := array_of(hint):
        return _Array(_type_of(array[0]), array[1], "C")
    inner = [_type_of(field) for field in fields_of(hint).values()]
    return _types.BaseTuple.from_types(inner, hint if hasattr(hint, "_fields") else None)


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
