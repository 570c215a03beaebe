# The example application against the simulated motor; the template board compiles.
set(example "${LODE_PORT_DIR}/example")
if(TARGET lodestar_rig)
  lode_port_test(test_port_bringup "${CMAKE_CURRENT_SOURCE_DIR}/test_port_bringup.c"
                 "${example}/app.c" "${example}/bringup.c" "${example}/report.c")
endif()

add_library(lode_port_template OBJECT "${LODE_PORT_DIR}/template/board.c")
target_include_directories(lode_port_template PRIVATE "${LODE_PORT_DIR}")
target_link_libraries(lode_port_template PRIVATE lodestar::lodestar)
lode_compile_options(lode_port_template ${LODE_WARNINGS})
