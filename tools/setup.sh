#!/bin/sh
# Makes .venv with shadowatmo (editable) and what the demo and the tests need; run by `make setup`.
#
# What is missing from the system (Python >= 3.11, its venv module, the EGL and GL libraries, a GL driver) is
# installed by apt-get when we are root; otherwise the one line to run is printed and the exit status is 1.
# PYTHON=/path/to/python chooses an interpreter. A second run with nothing changed takes a moment only.
set -eu
cd "$(dirname "$0")/.."

VENV=.venv
VENV_PYTHON=$VENV/bin/python
STAMP=$VENV/.shadowatmo-setup
EXTRAS=demo,dev,report,sky

say() { printf 'setup: %s\n' "$*"; }
fail() { printf 'setup: %s\n' "$*" >&2; exit 1; }
have() { command -v "$1" >/dev/null 2>&1; }

is_recent_python() {
    "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1
}

# Prints the interpreter to use: $PYTHON, then the plain names, then the versioned ones, newest first.
find_python() {
    for candidate in ${PYTHON:+"$PYTHON"} python3 python python3.14 python3.13 python3.12 python3.11; do
        if is_recent_python "$candidate"; then
            command -v "$candidate"
            return
        fi
    done
}

# The loader's cache first, because Python may still be missing; then the loader itself, because a library may
# come from LD_LIBRARY_PATH.
has_library() {
    PATH=$PATH:/sbin:/usr/sbin ldconfig -p 2>/dev/null | grep -q "[[:space:]]$1 " && return
    [ -n "$python" ] && "$python" -c "import ctypes; ctypes.CDLL('$1')" >/dev/null 2>&1
}

# Mesa's drivers, in either of their layouts, or another vendor's EGL library.
has_gl_driver() {
    [ -z "${__EGL_VENDOR_LIBRARY_FILENAMES:-}${__EGL_VENDOR_LIBRARY_DIRS:-}${LIBGL_DRIVERS_PATH:-}" ] || return 0
    for file in /usr/lib*/dri/*_dri.so /usr/lib/*/dri/*_dri.so /usr/lib*/libgallium-*.so /usr/lib/*/libgallium-*.so \
        /usr/share/glvnd/egl_vendor.d/*.json /etc/glvnd/egl_vendor.d/*.json; do
        case $file in
            *mesa.json) ;;
            *) [ ! -e "$file" ] || return 0 ;;
        esac
    done
    return 1
}

apt_version() { apt-cache policy "$1" 2>/dev/null | sed -n 's/^ *Candidate: \([0-9][0-9.]*\).*/\1/p'; }

# Prints the packages of a recent Python: the release's own, else the newest that the release offers beside it.
apt_python_packages() {
    case $(apt_version python3) in
        3.[0-9] | 3.[0-9].* | 3.10 | 3.10.*) ;;
        *) echo "python3 python3-venv"; return ;;
    esac
    for minor in 14 13 12 11; do
        if [ -n "$(apt_version python3.$minor-venv)" ]; then
            echo "python3.$minor python3.$minor-venv"
            return
        fi
    done
}

find_missing_gl() {
    [ "$(uname -s)" = Linux ] || return 0
    has_library libEGL.so.1 || echo libegl1
    has_library libGL.so.1 || echo libgl1
    has_gl_driver || echo libgl1-mesa-dri
}

# uv makes environments without ensurepip, and fetches a Python where there is none.
can_make_environment() {
    have uv || { [ -n "$python" ] && "$python" -c 'import venv, ensurepip' >/dev/null 2>&1; }
}

# A system Python of Debian has its venv module in a package apart.
find_missing_python() {
    if can_make_environment; then
        return
    elif [ -n "$python" ]; then
        "$python" -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])'
    else
        apt_python_packages
    fi
}

install_by_apt() {
    [ $# -gt 0 ] || return 0
    if [ "$(id -u)" -ne 0 ]; then
        say "the system lacks: $*" >&2
        say "run this line, then the same command again:" >&2
        printf '    sudo apt-get update && sudo apt-get install -y --no-install-recommends %s\n' "$*" >&2
        exit 1
    fi
    say "installing $*"
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >/dev/null
}

install_system_packages() {
    if have apt-get; then
        # A fresh container has no package lists, and the choice of a Python looks into them.
        [ "$(id -u)" -ne 0 ] || apt-get update -qq
        # shellcheck disable=SC2046  # lists of words
        install_by_apt $(find_missing_python) $missing_gl
        python=$(find_python)
    elif [ -n "$missing_gl" ]; then
        say "no libEGL, libGL or GL driver was found; Debian has them in" $missing_gl >&2
    fi
    can_make_environment || fail "needs Python >= 3.11 with its venv module, or uv: install either, then run this" \
        "again (PYTHON=/path/to/python chooses an interpreter)"
}

fingerprint() { { pwd; cat pyproject.toml tools/setup.sh; } | cksum; }

make_environment() {
    if have uv; then
        if ! is_recent_python $VENV_PYTHON; then
            rm -rf $VENV
            uv venv --quiet --python "${python:->=3.11}" $VENV
        fi
        uv pip install --quiet --python $VENV_PYTHON -e ".[$EXTRAS]"
    else
        # An environment made by uv has no pip.
        if ! { is_recent_python $VENV_PYTHON && $VENV_PYTHON -m pip --version >/dev/null 2>&1; }; then
            "$python" -m venv --clear $VENV
        fi
        $VENV_PYTHON -m pip install --quiet --disable-pip-version-check -e ".[$EXTRAS]"
    fi
}

environment_is_current() {
    is_recent_python $VENV_PYTHON && [ "$(cat $STAMP 2>/dev/null)" = "$(fingerprint)" ]
}

python=$(find_python)
missing_gl=$(find_missing_gl)
if [ -n "$missing_gl" ] || ! { environment_is_current || can_make_environment; }; then
    install_system_packages
fi
if ! environment_is_current; then
    say "installing shadowatmo[$EXTRAS] into $VENV"
    make_environment
    fingerprint >$STAMP
    say "done: $VENV is ready"
fi
