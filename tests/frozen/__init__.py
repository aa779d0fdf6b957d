"""Frozen results: every number of every estimate of a fixed corpus, held to what was recorded.

``cases`` lists the corpus, ``corpus`` makes its files, ``flat`` lays an estimate out as path and
value, ``compare`` judges two of them, ``perturb`` disturbs readings as rounding would, ``against``
compares with another commit bit for bit. ``python -m tests.frozen --help`` is the command.
"""
