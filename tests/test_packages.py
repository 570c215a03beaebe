"""The package descriptions agree with the tree and its version, and what they name builds.

Zephyr's and ESP-IDF's CMake functions are stand-ins here; test_packages_tools.py uses the real
programs where they can be had.
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
import zipfile

ROOT = pathlib.Path(os.environ.get("LODE_SOURCE_DIR") or pathlib.Path(__file__).parents[1])
SOURCES = sorted(str(path.relative_to(ROOT)) for path in (ROOT / "src").glob("*.c"))
PRIVATE = sorted(str(path.relative_to(ROOT)) for folder, ending in (("include/lodestar", "def"), ("src", "h"))
                 for path in (ROOT / folder).glob(f"*.{ending}"))
HEADERS = sorted(str(path.relative_to(ROOT)) for path in (ROOT / "include/lodestar").glob("*.h"))
CONSUMER = ROOT / "port/packages/conan/test_package/main.c"
FLAGS = ["-ffp-contract=off", "-fno-math-errno"]
# The keys of library.json, and of its "build", that PlatformIO documents and that are used here.
LIBRARY_KEYS = {"name", "version", "description", "keywords", "license", "frameworks", "platforms",
                "headers", "build"}
BUILD_KEYS = {"includeDir", "srcDir", "flags"}

ZEPHYR = """
macro(zephyr_library_named name)
  add_library(${name} STATIC)
  set(ZEPHYR_CURRENT_LIBRARY ${name})
endmacro()
function(zephyr_library_sources)
  target_sources(${ZEPHYR_CURRENT_LIBRARY} PRIVATE ${ARGN})
endfunction()
function(zephyr_library_compile_options)
  target_compile_options(${ZEPHYR_CURRENT_LIBRARY} PRIVATE ${ARGN})
endfunction()
function(zephyr_include_directories)
  include_directories(${ARGN})
  set_property(GLOBAL PROPERTY folders ${ARGN})
endfunction()
set(CONFIG_LODESTAR y)
"""
ESP_IDF = """
macro(idf_component_register)
  cmake_parse_arguments(idf "" "" "SRCS;INCLUDE_DIRS" ${ARGN})
  set(COMPONENT_LIB lodestar)
  add_library(lodestar STATIC ${idf_SRCS})
  target_include_directories(lodestar PUBLIC ${idf_INCLUDE_DIRS})
  set_property(GLOBAL PROPERTY folders ${idf_INCLUDE_DIRS})
endmacro()
"""
PROJECT = """
cmake_minimum_required(VERSION 3.18)
project(user C CXX)
{functions}
add_subdirectory("{folder}" lodestar)
get_property(folders GLOBAL PROPERTY folders)
get_target_property(sources lodestar SOURCES)
get_target_property(options lodestar COMPILE_OPTIONS)
file(WRITE "${{CMAKE_BINARY_DIR}}/seen.txt" "${{sources}}\\n${{folders}}\\n${{options}}\\n")
foreach(language c cpp)
  add_executable(user_${{language}} main.${{language}})
  set_target_properties(user_${{language}} PROPERTIES CXX_STANDARD 17 CXX_STANDARD_REQUIRED ON)
  target_include_directories(user_${{language}} PRIVATE ${{folders}})
  target_link_libraries(user_${{language}} lodestar m)
endforeach()
"""

failed = 0


def expect(condition, text):
    global failed
    if not condition:
        failed += 1
        print(f"FAILED: {text}")


def run(*command, cwd=None, code=0):
    result = subprocess.run([str(word) for word in command], cwd=cwd, text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if code is not None and result.returncode != code:
        sys.exit(f"{' '.join(map(str, command))}: code {result.returncode}\n{result.stdout[-3000:]}")
    return result


def relative(paths, base=ROOT):
    return sorted(os.path.relpath(os.path.realpath(path), base) for path in paths)


def copy_tree(target):
    """What the package descriptions speak of, to be damaged."""
    for name in ("include", "src", "docs", "port/packages"):
        shutil.copytree(ROOT / name, target / name)
    for name in ("CMakeLists.txt", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, target / name)


def check_sync(work):
    """Everything agrees; and one wrong version or one wrong file is seen, at its place."""
    result = run(sys.executable, ROOT / "port/packages/sync.py", "--check", code=None)
    expect(result.returncode == 0, f"run port/packages/sync.py:\n{result.stdout}")
    tree = work / "tree"
    copy_tree(tree)
    sync = [sys.executable, tree / "port/packages/sync.py"]
    run(*sync, "--check")

    version_h = tree / "include/lodestar/version.h"
    version_h.write_text(re.sub(r"(VERSION_PATCH )\d+", r"\g<1>99", version_h.read_text()))
    (tree / "src/added.c").write_text("")
    (tree / SOURCES[0]).unlink()
    text = run(*sync, "--check", code=1).stdout
    for name in ("CMakeLists.txt", "port/packages/platformio/library.json",
                 "port/packages/esp-idf/lodestar/idf_component.yml",
                 "port/packages/cmsis/Lodestar.Lodestar.pdsc", "docs/changelog.md"):
        expect(re.search(rf"^{re.escape(name)}:\d+: version .*; expected .*\.99$", text, re.MULTILINE),
               f"another version in {name} is not seen:\n{text}")
    expect("missing: <file category=\"sourceC\" name=\"src/added.c\"/>" in text, "an added file")
    expect(f"no such file: <file category=\"sourceC\" name=\"{SOURCES[0]}\"/>" in text, "a file gone")
    run(*sync)
    text = run(*sync, "--check", code=1).stdout  # the changelog is for people to write
    expect(text.count("\n") == 2 and text.startswith("docs/changelog.md:"), f"not mended:\n{text}")
    version_h.write_text("nothing\n")
    expect("version.h:1: expected" in run(*sync, code=1).stdout, "a version.h without a version")


def check_platformio():
    folder = ROOT / "port/packages/platformio"
    library = json.loads((folder / "library.json").read_text())
    expect(set(library) <= LIBRARY_KEYS, f"library.json: unknown keys {set(library) - LIBRARY_KEYS}")
    build = library["build"]
    expect(set(build) <= BUILD_KEYS, f"library.json: unknown keys {set(build) - BUILD_KEYS}")
    expect(relative([folder / build["srcDir"], folder / build["includeDir"]]) == ["include", "src"],
           "library.json: folders")
    expect((folder / build["includeDir"] / library["headers"]).is_file(), "library.json: headers")
    expect(build["flags"] == FLAGS, "library.json: flags")


def check_cmsis(work):
    pdsc = ROOT / "port/packages/cmsis/Lodestar.Lodestar.pdsc"
    package = ET.parse(pdsc).getroot()
    expect(package.tag == "package" and package.get("schemaVersion"), "pdsc: root element")
    for element in ("vendor", "name", "description", "url", "license", "releases", "components"):
        expect(package.find(element) is not None, f"pdsc: no <{element}>")
    expect(f"{package.findtext('vendor')}.{package.findtext('name')}.pdsc" == pdsc.name, "pdsc: name")
    for category, wanted in (("header", HEADERS), ("sourceC", SOURCES), ("other", PRIVATE)):
        names = [f.get("name") for f in package.iter("file") if f.get("category") == category]
        expect(names == wanted, f"pdsc: {category}: {sorted(set(names) ^ set(wanted))}")

    text = run(sys.executable, pdsc.with_name("pack.py"), work).stdout
    packs = list(work.glob("*.pack"))
    expect(len(packs) == 1 and str(packs[0]) in text, f"pack.py: {text}")
    pack = work / "pack"
    with zipfile.ZipFile(packs[0]) as archive:
        names = set(archive.namelist())
        archive.extractall(pack)
    expect(names == {pdsc.name, "LICENSE", "README.md", *HEADERS, *SOURCES, *PRIVATE}, "files of the pack")
    run("cc", "-std=c99", *FLAGS, f"-I{pack / 'include'}", CONSUMER, *sorted(pack.glob("src/*.c")),
        "-o", work / "from_pack", "-lm")
    run(work / "from_pack")


def check_cmake(work, name, functions, folder):
    """The package's CMakeLists.txt with stand-ins of the system's functions: what it names, built."""
    project = work / name
    project.mkdir()
    (project / "CMakeLists.txt").write_text(PROJECT.format(functions=functions, folder=folder))
    for language in ("c", "cpp"):
        shutil.copy(CONSUMER, project / f"main.{language}")
    build = project / "build"
    run("cmake", "-S", project, "-B", build)
    sources, folders, options = (line.split(";") for line in
                                 (build / "seen.txt").read_text().splitlines())
    expect(relative(sources) == SOURCES, f"{name}: sources {relative(sources)}")
    expect(relative(folders) == ["include"], f"{name}: include folders {folders}")
    expect(options == FLAGS, f"{name}: options {options}")
    run("cmake", "--build", build, "-j", "2")
    for language in ("c", "cpp"):
        run(build / f"user_{language}")


def check_zephyr_module():
    text = (ROOT / "port/packages/zephyr/module.yml").read_text()
    keys = dict(re.findall(r"^ *(name|cmake|kconfig): (\S+)$", text, re.MULTILINE))
    expect(set(keys) == {"name", "cmake", "kconfig"}, f"module.yml: {keys}")
    module = ROOT / "port/packages"
    expect((module / keys["cmake"] / "CMakeLists.txt").is_file(), "module.yml: cmake")
    expect("config LODESTAR\n" in (module / keys["kconfig"]).read_text(), "module.yml: kconfig")


def main():
    for program in ("cmake", "cc", "c++"):
        if not shutil.which(program):
            print(f"skipped: no {program}")
            return 77
    if shutil.which("ninja"):
        os.environ.setdefault("CMAKE_GENERATOR", "Ninja")
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        check_sync(work)
        check_platformio()
        check_cmsis(work)
        check_zephyr_module()
        packages = ROOT / "port/packages"
        check_cmake(work, "zephyr", ZEPHYR, packages / "zephyr")
        check_cmake(work, "esp_idf", ESP_IDF, packages / "esp-idf/lodestar")
    print(f"{len(SOURCES)} sources, {len(HEADERS)} headers, {failed} failures")
    return 1 if failed else 0


sys.exit(main())
