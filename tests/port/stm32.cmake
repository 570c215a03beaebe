# The STM32 ports against recorded registers on the host, and as complete images for Arm and qemu.
set(stm32_common "${LODE_PORT_DIR}/stm32/board.c" "${LODE_PORT_DIR}/stm32/pwm.c"
                 "${LODE_PORT_DIR}/stm32/serial.c" "${LODE_PORT_DIR}/stm32/supervise.c"
                 ${board_common} ${application} "${CMAKE_CURRENT_SOURCE_DIR}/fakes/fake.c"
                 "${CMAKE_CURRENT_SOURCE_DIR}/test_port_stm32.c")

# stm32_test(<name> <folder of the port> <board header> <definition> <source>...)
function(stm32_test name folder board family)
  list(TRANSFORM ARGN PREPEND "${LODE_PORT_DIR}/${folder}/")
  lode_port_test(${name} ${stm32_common} ${ARGN})
  target_include_directories(${name} PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/fakes"
                             "${LODE_PORT_DIR}/stm32" "${LODE_PORT_DIR}/${folder}")
  target_compile_definitions(${name} PRIVATE ${family} "STM32_BOARD_H=\"boards/${board}.h\"")
endfunction()

stm32_test(test_port_b_g431b_esc1 stm32g4 b_g431b_esc1 FAKE_G4 clock.c analog.c deadline.c)
stm32_test(test_port_nucleo_ihm16m1 stm32g4 nucleo_ihm16m1 FAKE_G4 clock.c analog.c deadline.c)
stm32_test(test_port_stm32f4 stm32f4 generic_f405 FAKE_F4 clock.c adc.c deadline.c)
stm32_test(test_port_stm32h7 stm32h7 generic_h743 FAKE_H7 clock.c adc.c deadline.c)

# Bought boards: their figures once more, from their documents.
foreach(board IN ITEMS b_g431b_esc1 nucleo_ihm16m1)
  target_compile_definitions(test_port_${board} PRIVATE
                             "BOARD_FIGURES_H=\"${CMAKE_CURRENT_SOURCE_DIR}/boards/figures_${board}.h\"")
endforeach()

# The same board with other ways to sense.
foreach(sensing IN ITEMS LOW_SIDE_TWO IN_LINE_THREE IN_LINE_TWO)
  string(TOLOWER "test_port_stm32f4_${sensing}" name)
  stm32_test(${name} stm32f4 generic_f405 FAKE_F4 clock.c adc.c deadline.c)
  target_compile_definitions(${name} PRIVATE VARIANT_SENSING=PORT_${sensing})
endforeach()

# Two calls in a period; with low-side shunts that is refused.
foreach(case IN ITEMS stm32f4:IN_LINE_THREE stm32f4:IN_LINE_TWO stm32f4:LOW_SIDE_THREE stm32h7:IN_LINE_THREE)
  string(REPLACE ":" ";" case "${case}")
  list(GET case 0 port)
  list(GET case 1 sensing)
  string(TOLOWER "test_port_${port}_${sensing}_double" name)
  if(port STREQUAL stm32f4)
    stm32_test(${name} stm32f4 generic_f405 FAKE_F4 clock.c adc.c deadline.c)
  else()
    stm32_test(${name} stm32h7 generic_h743 FAKE_H7 clock.c adc.c deadline.c)
  endif()
  target_compile_definitions(${name} PRIVATE VARIANT_SENSING=PORT_${sensing} VARIANT_DOUBLE_UPDATE=true)
endforeach()

# One shunt in the DC link, without the application.
set(link clock.c analog.c deadline.c link.c)
list(TRANSFORM link PREPEND "${LODE_PORT_DIR}/stm32g4/")
lode_port_test(test_port_link "${LODE_PORT_DIR}/stm32/board.c" "${LODE_PORT_DIR}/stm32/pwm.c"
               "${LODE_PORT_DIR}/stm32/serial.c" "${LODE_PORT_DIR}/stm32/supervise.c" ${link}
               ${board_common} "${CMAKE_CURRENT_SOURCE_DIR}/fakes/fake.c"
               "${CMAKE_CURRENT_SOURCE_DIR}/test_port_link.c")
target_include_directories(test_port_link PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/fakes"
                           "${LODE_PORT_DIR}/stm32" "${LODE_PORT_DIR}/stm32g4")
target_compile_definitions(test_port_link PRIVATE FAKE_G4
                           "STM32_BOARD_H=\"boards/generic_g431_link.h\"")

# The core with the board's own sine and cosine: its sources once more, in front of the library. The
# bring-up must pass with them as well.
file(GLOB core CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/src/*.c")
function(cordic_test name)
  lode_port_test(${name} ${core} "${CMAKE_CURRENT_SOURCE_DIR}/fakes/fake.c"
                 "${LODE_PORT_DIR}/stm32g4/cordic.c" ${ARGN})
  target_include_directories(${name} PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/fakes"
                             "${LODE_PORT_DIR}/stm32" "${LODE_PORT_DIR}/stm32g4")
  target_compile_definitions(${name} PRIVATE FAKE_G4 LODE_SINCOS_BOARD)
endfunction()
cordic_test(test_port_cordic "${CMAKE_CURRENT_SOURCE_DIR}/test_port_cordic.c")
if(TARGET lodestar_rig)
  cordic_test(test_port_bringup_cordic "${CMAKE_CURRENT_SOURCE_DIR}/test_port_bringup.c" ${application})
  target_compile_definitions(test_port_bringup_cordic PRIVATE APP_RESTARTS=3u)
endif()

if(LODE_BUILD_GATES)
  add_test(NAME port_stm32_images COMMAND bash "${CMAKE_CURRENT_SOURCE_DIR}/stm32_images.sh"
           WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}")
  set_tests_properties(port_stm32_images PROPERTIES LABELS port TIMEOUT 600 SKIP_RETURN_CODE 77)
endif()
