# The example application against the simulated motor, and on the template board.
set(example "${LODE_PORT_DIR}/example")
set(application "${example}/app.c" "${example}/bringup.c" "${example}/edge.c" "${example}/kept.c" "${example}/measure.c" "${example}/record.c" "${example}/report.c")
if(TARGET lodestar_rig)
  lode_port_test(test_port_bringup "${CMAKE_CURRENT_SOURCE_DIR}/test_port_bringup.c" ${application})
  target_compile_definitions(test_port_bringup PRIVATE APP_RESTARTS=3u)
  lode_port_test(test_port_bringup_double "${CMAKE_CURRENT_SOURCE_DIR}/test_port_bringup.c" ${application})
  target_compile_definitions(test_port_bringup_double PRIVATE APP_RESTARTS=3u DOUBLE_UPDATE=true)
  lode_port_test(test_port_low_bus "${CMAKE_CURRENT_SOURCE_DIR}/test_port_bringup.c" ${application})
  target_compile_definitions(test_port_low_bus PRIVATE APP_V_BUS_V=10.0f)
endif()
lode_port_test(test_port_kept "${CMAKE_CURRENT_SOURCE_DIR}/test_port_kept.c")
lode_port_test(test_port_template "${CMAKE_CURRENT_SOURCE_DIR}/test_port_template.c" ${application}
               "${LODE_PORT_DIR}/template/board.c")
if(LODE_BUILD_GATES)
  add_test(NAME port_options COMMAND bash "${CMAKE_CURRENT_SOURCE_DIR}/options.sh"
           WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}")
  set_tests_properties(port_options PROPERTIES LABELS port TIMEOUT 120)
endif()
