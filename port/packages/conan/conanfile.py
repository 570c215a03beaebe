"""Conan 2 recipe, `conan create port/packages/conan`: builds and installs with the root's CMakeLists.txt."""
import pathlib
import re

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeToolchain, cmake_layout
from conan.tools.files import copy

ROOT = pathlib.Path(__file__).resolve().parents[3]


class Lodestar(ConanFile):
    name = "lodestar"
    description = "Sensorless field-oriented control of permanent-magnet motors"
    license = "MIT"
    package_type = "static-library"
    settings = "os", "arch", "compiler", "build_type"
    languages = "C"

    def set_version(self):
        text = (ROOT / "include/lodestar/version.h").read_text()
        self.version = ".".join(re.findall(r"define LODE_VERSION_\w+ (\d+)", text))

    def export_sources(self):
        for pattern in ("CMakeLists.txt", "LICENSE", "include/*", "src/*", "port/packages/cmake/*"):
            copy(self, pattern, ROOT, self.export_sources_folder)

    def layout(self):
        cmake_layout(self)

    def generate(self):
        toolchain = CMakeToolchain(self)
        for option in ("SIM", "TESTS", "GATES"):
            toolchain.cache_variables[f"LODE_BUILD_{option}"] = False
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()
        copy(self, "LICENSE", self.source_folder, pathlib.Path(self.package_folder) / "licenses")

    def package_info(self):
        self.cpp_info.libs = ["lodestar"]
        # The headers hold kernels: who includes them must compute as the library does.
        self.cpp_info.cflags = self.cpp_info.cxxflags = ["-ffp-contract=off", "-fno-math-errno"]
        if self.settings.os in ("Linux", "FreeBSD"):
            self.cpp_info.system_libs = ["m"]
