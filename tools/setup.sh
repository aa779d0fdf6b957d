#!/bin/sh
# Makes .venv ready: tools/setup.sh run | test
#   run    what motorid needs, with its compiled parts
#   test   after it, what its tests and checks need
# Asks apt-get only for what is missing, and only as root or with password-free sudo;
# otherwise it says which command to give. Where there is no C compiler, the compiled parts are
# built with ziglang from the package index, as locked in locks/zig.txt.
# FOR=test: what is made ready is for tests, which need the machine's own compiler anyway.
set -eu
cd "$(dirname "$0")/.."
what=${1:-run}
for=${FOR:-$what}
venv=.venv
zig=build/zig

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
    [ "$for" != test ] || has_compiler "$1" || ! may_install || echo gcc libc6-dev python3-dev
}

# Whether a C compiler and the headers of this Python are there.
has_compiler() { "$1" tools/building/zig_build.py; }

# Those without which some tests skip: a browser, the boards' compiler and emulator, second opinions.
wanted_packages() {
    has chromium || has google-chrome || echo chromium
    has make || echo make
    has avr-gcc || echo gcc-avr avr-libc
    [ -e /usr/include/simavr/sim_avr.h ] || echo libsimavr-dev libelf-dev
    [ -d /usr/share/arduino/hardware/arduino/avr/bootloaders ] || echo arduino-core-avr
    has arm-none-eabi-gcc || echo gcc-arm-none-eabi libnewlib-arm-none-eabi
    has node || echo nodejs
    has npm || echo npm
    has avrdude || echo avrdude
    has cppcheck || echo cppcheck
    has clang-tidy || echo clang-tidy
    has clang || echo clang "libclang-rt-$(clang_version)-dev"
    has ngspice || echo ngspice
    has tmux || echo tmux
    has mosquitto || [ -x /usr/sbin/mosquitto ] || echo mosquitto
    ls /usr/lib/postgresql/*/bin/initdb >/dev/null 2>&1 || has initdb || echo postgresql
}

has() { command -v "$1" >/dev/null 2>&1; }

# The version that Debian's package clang stands for.
clang_version() {
    apt-cache depends clang 2>/dev/null | sed -n 's/.*Depends: clang-\([0-9]*\)$/\1/p' | head -n 1
}

may_install() { has apt-get && { [ "$(id -u)" = 0 ] || sudo -n true 2>/dev/null; }; }

update_lists() { $(as_root) apt-get update -qq; }

as_root() { [ "$(id -u)" = 0 ] || echo sudo -n; }

install_packages() {
    command="apt-get install -y --no-install-recommends $*"
    if ! has apt-get; then
        say "please install what these Debian packages hold: $*"
        return 1
    fi
    if ! may_install; then
        say "these system packages are missing; please give: sudo $command"
        return 1
    fi
    say "$command"
    # shellcheck disable=SC2046,SC2086 # a command and its words
    DEBIAN_FRONTEND=noninteractive $(as_root) $command >/dev/null
}

python=$(find_python)
# shellcheck disable=SC2046 # one word a package
set -- $(missing_packages "$python")
[ $# = 0 ] || { update_lists; install_packages "$@"; } || exit 1
if [ "$what" = test ] && [ -n "$(wanted_packages)" ]; then
    may_install && update_lists  # also tells which clang there is
    # shellcheck disable=SC2046
    install_packages $(wanted_packages) || say "going on without: the tests that need them skip"
fi

pip() { $venv/bin/python -m pip "$@"; }
export PIP_DISABLE_PIP_VERSION_CHECK=1

# What motorid needs, and motorid with its compiled parts. Each file must have a hash of the lock.
make_run() {
    [ -x $venv/bin/python ] || { say "creating $venv with $python"; "$python" -m venv $venv; }
    install run
    if ! has_compiler $venv/bin/python && [ ! -e $zig/ziglang/__main__.py ]; then
        say "no C compiler with Python's headers is here: installing ziglang, as locked in locks/zig.txt"
        pip install -q --require-hashes --no-deps --target $zig -r locks/zig.txt
    fi
    PYTHONPATH=$zig${PYTHONPATH:+:$PYTHONPATH} \
        pip install -q --no-deps --no-index --no-build-isolation -e .
}

# What its tests and checks need. Sources are built with the setuptools that make_run installed.
make_test() {
    if has npm; then
        say "installing the emulator of the Pico's processor, as locked in firmware/emulator/pico"
        npm ci --silent --no-audit --no-fund --prefix firmware/emulator/pico ||
            say "going on without: the tests that need it skip"
    fi
    install test --no-build-isolation --no-compile
    compile_all
}

# What locks/$1.txt names; the rest of the words are for the installer.
install() {
    lock=locks/$1.txt
    say "installing what is locked in $lock"
    shift
    if [ "$for" = test ] && fast_install "$lock"; then return; fi
    pip install -q --require-hashes "$@" -r "$lock"
}

# By uv, in a tenth of pip's time: the same files, held against the same hashes. The tests' lock has
# it. Where uv cannot, as behind an index that only pip is told of, pip goes on.
fast_install() {
    mkdir -p build
    awk '/^uv==/ { on = 1 } on { print } on && !/\\$/ { exit }' locks/test.txt >build/uv.txt
    [ -x $venv/bin/uv ] || pip install -q --require-hashes --no-deps -r build/uv.txt || return 1
    index=${PIP_INDEX_URL:-$(pip config get global.index-url 2>/dev/null || :)}
    [ -z "${PIP_CERT:-}" ] || export SSL_CERT_FILE="${SSL_CERT_FILE:-$PIP_CERT}"
    VIRTUAL_ENV=$PWD/$venv $venv/bin/uv pip install -q ${index:+--index-url "$index"} \
        --require-hashes --no-build-isolation -r "$1" || { say "uv cannot: going on with pip"; return 1; }
}

# Byte code, on all cores: otherwise each worker of the tests compiles every module for itself.
compile_all() {
    export PYTHONDONTWRITEBYTECODE=''
    cores=$(nproc 2>/dev/null || echo 2)
    find tests -name 'test_*.py' | sort |
        xargs -P "$cores" -n 170 $venv/bin/python -m pytest -q --collect-only >/dev/null 2>&1 || :
}

make_"$what"
