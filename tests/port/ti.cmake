# TI's ports: F28004x on a recorded driverlib, AM263x on recorded registers and as a complete image for
# the Cortex-R5F, and what a 16-bit char and int would break.
set(ti_common "${LODE_PORT_DIR}/ti/board.c" "${LODE_PORT_DIR}/ti/counts.c" ${board_common} ${application})

# ti_test(<name> <folder of the port> <source>...): with the fake of the same name
function(ti_test name chip)
  list(TRANSFORM ARGN PREPEND "${LODE_PORT_DIR}/ti_${chip}/")
  lode_port_test(${name} ${ti_common} ${ARGN} "${CMAKE_CURRENT_SOURCE_DIR}/fakes/ti/${chip}.c"
                 "${CMAKE_CURRENT_SOURCE_DIR}/test_port_ti_${chip}.c")
  target_include_directories(${name} PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/fakes/ti"
                             "${LODE_PORT_DIR}/ti" "${LODE_PORT_DIR}/ti_${chip}")
endfunction()

ti_test(test_port_ti_f28004x f28004x board.c pwm.c analog.c)
ti_test(test_port_ti_am263x am263x board.c pwm.c analog.c)
target_compile_definitions(test_port_ti_am263x PRIVATE "TI_REG_H=\"am263x_reg.h\"")

# Two calls in a period; with low-side shunts that is refused.
foreach(chip IN ITEMS f28004x am263x)
  set(double_board "TI_BOARD_H=\"${CMAKE_CURRENT_SOURCE_DIR}/boards/${chip}_double.h\"")
  foreach(sensing IN ITEMS IN_LINE_THREE LOW_SIDE_THREE)
    string(TOLOWER "test_port_ti_${chip}_${sensing}_double" name)
    ti_test(${name} ${chip} board.c pwm.c analog.c)
    target_compile_definitions(${name} PRIVATE ${double_board} VARIANT_SENSING=PORT_${sensing})
  endforeach()
endforeach()
foreach(sensing IN ITEMS in_line_three low_side_three)
  target_compile_definitions(test_port_ti_am263x_${sensing}_double PRIVATE "TI_REG_H=\"am263x_reg.h\"")
endforeach()

# The LaunchPad's port with an NTC and bootstrap capacitors, which that board does not have.
ti_test(test_port_ti_f28004x_ntc f28004x board.c pwm.c analog.c)
target_compile_definitions(test_port_ti_f28004x_ntc
                           PRIVATE "TI_BOARD_H=\"${CMAKE_CURRENT_SOURCE_DIR}/boards/f28004x_ntc.h\"")

if(LODE_BUILD_GATES)
  foreach(script IN ITEMS ti_images ti_char16)
    add_test(NAME port_${script} COMMAND bash "${CMAKE_CURRENT_SOURCE_DIR}/${script}.sh"
             WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}")
    set_tests_properties(port_${script} PROPERTIES LABELS port TIMEOUT 300 SKIP_RETURN_CODE 77)
  endforeach()
endif()
