"""The review's tables, rebuilt: nominal motors, excitation, noise and budgets (``tables``).

Source: "Parameters Identification of a Permanent Magnet DC Motor: A Review", Electronics 2023,
12(12), 2559. Set-ups that it does not print were recovered from its numbers or are our proposal;
``docs/review.md`` says which.
"""
