#!/bin/sh
# Makes the environment of the archimedes peer: setup_archimedes.sh VENV
# archimedes 0.5.0 names a dependency (structree >= 1.0.0rc1) that the registry does not hold under
# that name; the same module was part of archimedes up to 0.4.4, so it is taken from that wheel.
set -eu
venv=$1
python3 -m venv "$venv"
"$venv/bin/pip" install -q --no-deps archimedes==0.5.0
"$venv/bin/pip" install -q casadi cloudpickle jinja2 joblib numpy scipy osqp pydantic
site=$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
"$venv/bin/pip" download -q --no-deps -d "$venv/wheels" archimedes==0.4.4
"$venv/bin/python" -m zipfile -e "$venv"/wheels/archimedes-0.4.4-*.whl "$venv/old"
rm "$site/archimedes/tree.py"
cp -r "$venv/old/archimedes/tree" "$site/archimedes/tree"
mkdir -p "$site/structree"
echo 'from archimedes.tree import *' > "$site/structree/__init__.py"
echo 'from archimedes.tree._flatten_util import HashablePartial' > "$site/structree/_flatten_util.py"
