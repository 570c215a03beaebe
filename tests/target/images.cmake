# Images, and tests that run them by way of CMAKE_CROSSCOMPILING_EMULATOR.

# target_test(<name> <command>...)
function(target_test name)
  add_test(NAME ${name} COMMAND ${ARGN})
  set_tests_properties(${name} PROPERTIES LABELS target TIMEOUT 240 SKIP_RETURN_CODE 77)
endfunction()

# --- closed loop ---

target_test(closed_loop closed_loop)
if(NOT LODE_CORE MATCHES "m0|r5f")
  # A period that lasts longer than two must be found.
  target_test(overlong_period_is_found closed_loop overlong)
  set_tests_properties(overlong_period_is_found PROPERTIES PASS_REGULAR_EXPRESSION
                       "FAIL ticks: 15000 interrupts in 1500[1-9] periods")
endif()

# --- the same bits as the host ---

if(LODE_REPLAY_HOST)
  set(replay_host "${LODE_REPLAY_HOST}")
else()
  find_program(lode_host_cc NAMES cc gcc clang)
  if(NOT lode_host_cc)
    message(FATAL_ERROR "no compiler for this host (cc): it records what the images replay. Or give a "
                        "built program with -DLODE_REPLAY_HOST=<file>")
  endif()
  set(replay_host "${CMAKE_CURRENT_BINARY_DIR}/replay_host")
  # -O1, so that optimisation differs too.
  add_custom_command(OUTPUT "${replay_host}"
    COMMAND "${lode_host_cc}" -std=c99 -O1 ${LODE_FLOAT_FLAGS} "-I${PROJECT_SOURCE_DIR}/include"
            "-I${PROJECT_SOURCE_DIR}/src" "-I${PROJECT_SOURCE_DIR}/port/emulator"
            ${replay_sources} ${lode_sources} -lm -o "${replay_host}"
    DEPENDS ${replay_sources} ${lode_sources} lodestar VERBATIM)
endif()
set(counts "${CMAKE_CURRENT_BINARY_DIR}/counts.c")
add_custom_command(OUTPUT "${counts}" COMMAND "${replay_host}" counts > "${counts}"
                   DEPENDS "${replay_host}" VERBATIM)
lode_emulator_image(replay replay_target.c replay.c "${counts}"
                    "${PROJECT_SOURCE_DIR}/port/emulator/plant.c")
lode_compile_options(replay ${LODE_WARNINGS})
target_include_directories(replay PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}")
target_test(replay_same_bits bash "${CMAKE_CURRENT_SOURCE_DIR}/same_bits.sh" "${replay_host}"
            ${CMAKE_CROSSCOMPILING_EMULATOR} $<TARGET_FILE:replay>)

# --- module tests ---

# Not estimator, estimator_kinds (they read files), ring (signals); drive takes minutes, and the closed
# loop and the replay run it.
set(modules channel current drive_config emf frames guard inverter lag modulator motor
            notch observer pi pll ramp references scalar scope sense sogi speed start status wire)
if(LODE_CORE STREQUAL "cortex-m0")
  # 16 KB of arrays on the stack of a machine with 16 KB; half a minute each, and the M3 runs them.
  list(REMOVE_ITEM modules inverter observer start)
endif()

foreach(module IN LISTS modules)
  set(test test_${module})
  lode_emulator_image(${test} "${PROJECT_SOURCE_DIR}/tests/${test}.c" left_out.c syscalls.c)
  set_target_properties(${test} PROPERTIES C_EXTENSIONS ON)
  lode_compile_options(${test} ${LODE_TEST_WARNINGS} -include left_out.h)
  target_include_directories(${test} PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}" "${PROJECT_SOURCE_DIR}/tests"
                                             "${PROJECT_SOURCE_DIR}/src" "${PROJECT_SOURCE_DIR}/sim")
  target_compile_definitions(${test} PRIVATE CHECK_SHARE=100)
  target_link_options(${test} PRIVATE "-Wl,-u,_printf_float") # %g in what a failure prints
  target_link_libraries(${test} PRIVATE unity::framework)
  target_test(${test} ${test})
  # No instruction is counted where no timer runs: half the time.
  set_tests_properties(${test} PROPERTIES ENVIRONMENT LODE_EMULATOR_TIME=free)
endforeach()
