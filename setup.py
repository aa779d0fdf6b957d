"""The two compiled parts; everything else is in pyproject.toml."""

from setuptools import setup

setup(
    cffi_modules=[
        "motorid/sim/plant_build.py:ffi",  # the simulated rig's physics
        "motorid/motor/response_build.py:ffi",  # the fit's motor model
    ]
)
