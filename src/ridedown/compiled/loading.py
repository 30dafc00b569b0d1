"""Machine code made callable."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any

from llvmlite import binding

ENTRY, KERNEL = "ridedown_entry", "ridedown_kernel"
"""What an entry's machine code defines: the function that Python calls, and a pointer to the one that kernels call."""

Entry = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_char_p, ctypes.c_void_p)
"""Takes packed arguments, and room for what is returned, packed likewise; gives whether it failed."""

_ENGINES: list[Any] = []
"""Machine code is gone with what it was loaded by."""


def name_address(name: str, address: int) -> None:
    """Let machine code refer to what lies at an address by a name."""
    binding.add_symbol(name, address)


def load(code: bytes, entry: bytes) -> tuple[int, int]:
    """Load a kernel's machine code and its entry's; give the addresses of the two functions.

    Each kernel is loaded apart: the parts in it have names that numba numbers anew in every process.
    """
    engine = binding.create_mcjit_compiler(binding.parse_assembly(""), _machine())
    for object_code in (code, entry):
        engine.add_object_file(binding.ObjectFileRef.from_data(object_code))
    engine.finalize_object()
    _ENGINES.append(engine)
    pointer = ctypes.c_size_t.from_address(engine.get_global_value_address(KERNEL))
    return pointer.value, engine.get_function_address(ENTRY)


@cache
def _machine() -> Any:
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    return binding.Target.from_default_triple().create_target_machine(jit=True)
