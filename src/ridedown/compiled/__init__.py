"""Kernels: functions that are compiled once, kept, and from then on loaded without the compiler.

A *kernel* is compiled on its own, for the types that its annotations say, and kept. Python calls it, and so do other kernels,
by its address: its code is not compiled again in those that call it, and kernels can be compiled side by side, in processes
of their own. A *part* is compiled into each kernel that calls it; what is *inlined*, into each place. What numba does not
know, such as vectors, is said in a module named by *instructions*.

    declaring.py   what is a kernel and what a part: the decorators; types, read from the annotations
    compiling.py   from a kernel to machine code, by numba; the only module that imports it
    keeping.py     the folder that machine code is kept in
    loading.py     machine code made callable, by llvmlite
    kernels.py     the kernel that Python calls: loaded, or compiled first, when it is called
"""

from ridedown.compiled.declaring import inlined, instructions, part
from ridedown.compiled.kernels import build, can_be_kept, kernel, unkept

__all__ = ["build", "can_be_kept", "inlined", "instructions", "kernel", "part", "unkept"]
