# cmake --install: library, headers, and what find_package() and pkg-config read. All of it may be moved.
include(CMakePackageConfigHelpers)

set(lode_cmake_dir "${CMAKE_INSTALL_LIBDIR}/cmake/lodestar")
set(lode_pc_dir "${CMAKE_INSTALL_LIBDIR}/pkgconfig")
file(RELATIVE_PATH lode_pc_to_prefix "/prefix/${lode_pc_dir}" "/prefix")

install(TARGETS lodestar EXPORT lodestar-targets ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}")
install(DIRECTORY "${PROJECT_SOURCE_DIR}/include/lodestar"
        DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" FILES_MATCHING PATTERN "*.h" PATTERN "*.def")
install(EXPORT lodestar-targets NAMESPACE lodestar:: DESTINATION "${lode_cmake_dir}")

configure_package_config_file("${CMAKE_CURRENT_LIST_DIR}/lodestar-config.cmake.in"
                              "${PROJECT_BINARY_DIR}/lodestar-config.cmake"
                              INSTALL_DESTINATION "${lode_cmake_dir}")
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file("${PROJECT_BINARY_DIR}/lodestar-config-version.cmake"
                                 COMPATIBILITY SameMinorVersion)
configure_file("${CMAKE_CURRENT_LIST_DIR}/lodestar.pc.in" "${PROJECT_BINARY_DIR}/lodestar.pc" @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/lodestar-config.cmake"
              "${PROJECT_BINARY_DIR}/lodestar-config-version.cmake"
        DESTINATION "${lode_cmake_dir}")
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}")
install(FILES "${PROJECT_BINARY_DIR}/lodestar.pc" DESTINATION "${lode_pc_dir}")
