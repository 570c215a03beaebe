#!/bin/sh
# usage: unity_from_debian.sh FOLDER
# Puts Unity's sources from Debian's source package ntpsec into FOLDER. The apt lists and the
# configuration live in a temporary folder: neither root nor a change to the system is needed.
set -eu
out=$1
command -v apt-get >/dev/null || { echo "no apt-get on this machine"; exit 1; }
codename=$(. /etc/os-release && echo "${VERSION_CODENAME:-}")
mirror=http://deb.debian.org/debian
keyring=/usr/share/keyrings/debian-archive-keyring.gpg
[ -e "$keyring" ] || { echo "no Debian archive keyring ($keyring)"; exit 1; }

tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
mkdir -p "$tmp/lists/partial" "$tmp/cache/archives/partial"
touch "$tmp/status"
echo "deb-src [signed-by=$keyring] $mirror ${codename:-stable} main" >"$tmp/sources.list"
apt() {
    apt-get -q -o Dir::Etc::SourceList="$tmp/sources.list" -o Dir::Etc::SourceParts=/dev/null \
        -o Dir::State="$tmp" -o Dir::State::Lists="$tmp/lists" -o Dir::State::status="$tmp/status" \
        -o Dir::Cache="$tmp/cache" -o APT::Sandbox::User=root -o Acquire::Languages=none \
        -o Acquire::Retries=2 -o Acquire::http::Timeout=15 "$@"
}
cd "$tmp"
apt update
apt source --download-only ntpsec
tar -xf ntpsec_*.orig.tar.* --wildcards --strip-components=3 '*/tests/unity/unity*.[ch]'
rm -rf "$out"
mkdir -p "$out"
mv unity.c unity.h unity_internals.h "$out/"
