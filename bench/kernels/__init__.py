"""Whether another processor gives another answer: the kernels of the linear algebra, one by one.

OpenBLAS, which numpy and scipy bring along, holds a kernel for each generation of processors; they
differ in the order of their additions. ``choice`` finds those that run here, ``subjects`` says what
is fitted, ``child`` fits it under one kernel, ``moved`` compares. ``bench/bench_kernels.py`` is the
command.
"""
