# The RP2350 port against recorded registers, with two and with three sensors; what brings its samples to
# t_k; and a complete image.
lode_port_test(test_port_sequential "${CMAKE_CURRENT_SOURCE_DIR}/test_port_sequential.c"
               "${LODE_PORT_DIR}/common/sequential.c")

set(rp2350 board.c clock.c adc.c driver.c pwm.c)
list(TRANSFORM rp2350 PREPEND "${LODE_PORT_DIR}/rp2350/")
foreach(sensing IN ITEMS LOW_SIDE_TWO LOW_SIDE_THREE)
  string(TOLOWER "test_port_rp2350_${sensing}" name)
  lode_port_test(${name} ${rp2350} ${board_common} "${LODE_PORT_DIR}/common/sequential.c" ${application}
                 "${CMAKE_CURRENT_SOURCE_DIR}/fakes/rp2350/rp2350.c"
                 "${CMAKE_CURRENT_SOURCE_DIR}/test_port_rp2350.c")
  target_include_directories(${name} PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/fakes/rp2350"
                             "${LODE_PORT_DIR}/rp2350")
  target_compile_definitions(${name} PRIVATE "RP_REG_H=\"rp2350_reg.h\"" VARIANT_SENSING=PORT_${sensing})
endforeach()

if(LODE_BUILD_GATES)
  add_test(NAME port_rp2350_images COMMAND bash "${CMAKE_CURRENT_SOURCE_DIR}/rp2350_images.sh"
           WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}")
  set_tests_properties(port_rp2350_images PROPERTIES LABELS port TIMEOUT 300 SKIP_RETURN_CODE 77)
endif()
