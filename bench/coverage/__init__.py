"""The coverage study: simulated rigs with everything on, fitted as an honest user would.

One module a step: ``motors`` and ``rigs`` draw, ``runs`` captures over the wire, ``bound`` says how
well the data could know, ``naive`` forgets the chain, ``score`` makes one record of a rig, and
``tables`` sums records up. ``bench/bench_coverage.py`` is the command.
"""
