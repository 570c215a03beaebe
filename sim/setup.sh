# Shared by sim/run and tests/run: what a fresh Debian machine needs. Source it, do not run it.
# shellcheck shell=bash

say() { printf 'lodestar: %s\n' "$*" >&2; }
die() { say "$*"; exit 1; }

have_command() { command -v "$1" >/dev/null 2>&1; }
have_header() { printf '#include <%s>\n' "$1" | cc -E -x c - >/dev/null 2>&1; }
have_package() { dpkg-query -W -f '${Status}' "$1" 2>/dev/null | grep -q 'ok installed'; }

# The packages of the list that are not there, from lines "package probe argument".
missing_of() {
    local package probe argument
    while read -r package probe argument; do
        [ -n "$package" ] || continue
        "$probe" "$argument" || printf '%s\n' "$package"
    done <<<"$1" | sort -u
}

# Installs the packages given; one attempt for all, then one by one. The caller probes afterwards.
install_packages() {
    local sudo=() package
    have_command apt-get || { say "no apt-get here; install by hand: $*"; return 1; }
    if [ "$(id -u)" != 0 ]; then
        have_command sudo || { say "neither root nor sudo; install by hand: $*"; return 1; }
        sudo=(sudo)
        # Without a terminal nobody could type a password.
        [ -t 0 ] || sudo=(sudo -n)
    fi
    local apt=("${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q
        -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3)
    local log
    log=$(mktemp)
    say "installing: $*"
    "${apt[@]}" update >"$log" 2>&1 </dev/null || true
    if ! "${apt[@]}" install -y --no-install-recommends "$@" >>"$log" 2>&1 </dev/null; then
        for package in "$@"; do
            "${apt[@]}" install -y --no-install-recommends "$package" >>"$log" 2>&1 </dev/null || {
                say "apt-get could not install $package:"
                grep -E '^(E|W):' "$log" | tail -n 3 >&2 || true
            }
        done
    fi
    rm -f "$log"
}

# A build folder of a tree that was copied or moved points at its old place: start it again.
drop_foreign_build() { # folder, source folder
    if [ -f "$1/CMakeCache.txt" ] &&
        ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$2" "$1/CMakeCache.txt"; then
        rm -rf "$1"
    fi
}

build_packages='
build-essential have_command cc
build-essential have_command make
cmake have_command cmake
ninja-build have_command ninja
libinih-dev have_header ini.h
libcjson-dev have_header cjson/cJSON.h
'
