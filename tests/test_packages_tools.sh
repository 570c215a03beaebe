#!/usr/bin/env bash
# usage: test_packages_tools.sh              the packages in the hands of the real programs
#        test_packages_tools.sh --venv       prints where tests/run puts these
#        test_packages_tools.sh --packages   prints what it puts there, from PyPI
# PlatformIO builds for the host, with its own build program; Conan makes and tests its package; the
# readers of ESP-IDF's component manager and of Kconfig read. Nothing is fetched.
set -eu -o pipefail
venv=${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/lodestar/packages
case "${1:-}" in
--venv) echo "$venv" && exit ;;
--packages)
    echo platformio==6.2.0 scons==4.11.1 conan==2.34.0 idf-component-manager==3.1.2 \
        kconfiglib==14.1.0 PyYAML==6.0.3
    exit
    ;;
esac
[ -f "$venv/ready" ] || {
    echo "skipped: no pio, conan, ... (tests/run tries to install them in $venv)"
    exit 77
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
tree=$work/user/lodestar # a submodule of the user's project
mkdir -p "$tree/port"
(cd "${LODE_SOURCE_DIR:?}" && cp -r include src CMakeLists.txt LICENSE "$tree" && cp -r port/packages "$tree/port")
sed -n 's/#define LODE_VERSION_[A-Z]* //p' "$tree/include/lodestar/version.h" | paste -sd. >"$work/version"
version=$(cat "$work/version")
# What asks for the network fails at once.
export http_proxy=http://127.0.0.1:9 https_proxy=http://127.0.0.1:9 no_proxy=
fail() {
    echo "FAILED: $1"
    tail -n 20 "$work/log"
    exit 1
}

# PlatformIO knows a host that needs no download, and its build program from PyPI instead of its registry.
export PLATFORMIO_CORE_DIR=$work/pio PLATFORMIO_SETTING_ENABLE_TELEMETRY=no
tool=$PLATFORMIO_CORE_DIR/packages/tool-scons
host=$PLATFORMIO_CORE_DIR/platforms/host
mkdir -p "$tool" "$host/builder" "$work/user/src"
"$venv/bin/python" - "$tool" <<'END_PY'
import json
import pathlib
import sys

from platformio.dependencies import get_core_dependencies

folder = pathlib.Path(sys.argv[1])
version = get_core_dependencies()["tool-scons"].lstrip("~")
tool = {"name": "tool-scons", "version": version}
spec = {"owner": "platformio", "name": "tool-scons", "id": None, "requirements": None, "uri": None}
(folder / "package.json").write_text(json.dumps(tool))
(folder / ".piopm").write_text(json.dumps({**tool, "type": "tool", "spec": spec}))
(folder / "scons.py").write_text("import SCons.Script\nSCons.Script.main()\n")
END_PY
echo '{"name": "host", "version": "1.0.0", "title": "host", "packages": {}}' >"$host/platform.json"
cat >"$host/platform.py" <<'END_PY'
from platformio.public import PlatformBase


class HostPlatform(PlatformBase):
    pass
END_PY
cat >"$host/builder/main.py" <<'END_PY'
from SCons.Script import Default, DefaultEnvironment

Default(DefaultEnvironment().BuildProgram())
END_PY
cat >"$work/user/platformio.ini" <<END_INI
[env:host]
platform = host
lib_deps = symlink://lodestar/port/packages/platformio
build_flags = -lm
END_INI
cp "$tree/port/packages/conan/test_package/main.c" "$work/user/src/main.cpp"
"$venv/bin/pio" run -v -d "$work/user" >"$work/log" 2>&1 || fail "pio run"
"$work/user/.pio/build/host/program" || fail "the program that pio has built"
[ "$(grep -c -- ' -ffp-contract=off -fno-math-errno .*/src/[a-z0-9_]*\.c$' "$work/log")" = \
    "$(find "$tree/src" -name '*.c' | wc -l)" ] || fail "pio run: flags of the library's files"
echo "PlatformIO: built and run"

export CONAN_HOME=$work/conan
{ "$venv/bin/conan" profile detect && "$venv/bin/conan" create "$tree/port/packages/conan" --no-remote; } \
    >"$work/log" 2>&1 || fail "conan create"
grep -q "lodestar/$version (test package): Running test()" "$work/log" || fail "conan: its test, version $version"
echo "Conan: lodestar/$version made and tested"

"$venv/bin/python" - "$tree" "$version" >"$work/log" 2>&1 <<'END_PY' || fail "manifests"
import pathlib
import sys

import kconfiglib
import yaml
from idf_component_tools.manager import ManifestManager

packages = pathlib.Path(sys.argv[1]) / "port/packages"
component = ManifestManager(str(packages / "esp-idf/lodestar"), "lodestar").load()
assert (str(component.version), component.license) == (sys.argv[2], "MIT"), component

module = yaml.safe_load((packages / "zephyr/module.yml").read_text())
assert module == {"name": "lodestar", "build": {"cmake": "zephyr", "kconfig": "zephyr/Kconfig"}}, module
top = packages / "Kconfig"  # Zephyr's two symbols of the floating-point unit, and the module's
top.write_text("config CPU_HAS_FPU\n\tdef_bool y\nconfig FPU\n\tbool \"FPU\"\n\tdepends on CPU_HAS_FPU\n"
               f"rsource \"{module['build']['kconfig']}\"\n")
kconfig = kconfiglib.Kconfig(str(top), warn_to_stderr=False)
assert not kconfig.warnings, kconfig.warnings
fpu = [kconfig.syms["FPU"].str_value]
kconfig.syms["LODESTAR"].set_value("y")
fpu.append(kconfig.syms["FPU"].str_value)
assert fpu == ["n", "y"], fpu
END_PY
echo "ESP-IDF's and Zephyr's files: read"
