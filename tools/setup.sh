#!/bin/sh
# Makes .venv ready: tools/setup.sh run | test
#   run    what motorid needs, with its compiled parts
#   test   that, and what its tests and checks need
# Asks apt-get only for what is missing, and only as root or with password-free sudo;
# otherwise it says which command to give.
set -eu
cd "$(dirname "$0")/.."
what=${1:-run}
venv=.venv

say() { printf 'setup: %s\n' "$*" >&2; }

find_python() {
    for name in ${PYTHON:-} python3 python3.14 python3.13 python3.12 python3.11; do
        command -v "$name" >/dev/null 2>&1 || continue
        "$name" -c 'import sys; sys.exit(sys.version_info < (3, 11))' && { echo "$name"; return; }
    done
    say "no Python 3.11 or newer; install one, or name it: make run PYTHON=/path/to/python3"
    exit 1
}

# Debian packages that a needed thing lives in, for what this machine lacks.
missing_packages() {
    "$1" -c 'import venv, ensurepip' 2>/dev/null || echo python3-venv
    command -v cc >/dev/null 2>&1 || echo gcc libc6-dev
    "$1" -c 'import os, sys, sysconfig
sys.exit(not os.path.exists(os.path.join(sysconfig.get_paths()["include"], "Python.h")))' ||
        echo python3-dev
    if [ "$what" = test ]; then
        command -v chromium >/dev/null 2>&1 || command -v google-chrome >/dev/null 2>&1 ||
            echo chromium
    fi
}

install_packages() {
    command="apt-get install -y --no-install-recommends $*"
    if [ "$(id -u)" = 0 ]; then as_root=
    elif sudo -n true 2>/dev/null; then as_root='sudo -n'
    else
        say "these system packages are missing; please give: sudo $command"
        exit 1
    fi
    if ! command -v apt-get >/dev/null 2>&1; then
        say "please install what these Debian packages hold: $*"
        exit 1
    fi
    say "$command"
    $as_root apt-get update -qq
    # shellcheck disable=SC2086 # a command and its words
    DEBIAN_FRONTEND=noninteractive $as_root $command >/dev/null
}

python=$(find_python)
# shellcheck disable=SC2046 # one word a package
set -- $(missing_packages "$python")
[ $# = 0 ] || install_packages "$@"

[ -x $venv/bin/python ] || { say "creating $venv with $python"; "$python" -m venv $venv; }
if [ "$what" = test ]; then extra='[dev]'; else extra=; fi
say "installing motorid$extra, pinned by constraints.txt"
export PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_CONSTRAINT="$PWD/constraints.txt"
$venv/bin/python -m pip install -q setuptools wheel cffi
$venv/bin/python -m pip install -q --no-build-isolation -e ".$extra"
