"""An estimate in the form that other programs take: one module a target, listed in ``targets``."""
