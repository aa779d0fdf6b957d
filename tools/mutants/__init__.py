"""Mutants: small faults put into the code on purpose, each tried by the tests that cover its line.

A mutant is killed where a test fails. One that survives shows a behaviour that no test states.
"""
