#!/bin/sh
# mealpy 3.0.3 pins numpy <= 1.26, so it gets an environment of its own: setup_mealpy.sh VENV
set -e
python3 -m venv "$1"
"$1/bin/pip" install --quiet "mealpy==3.0.3" scipy "cffi>=1.17"
