# lode_stm32_firmware(<target> <family: G4, F4 or H7> <linker script> <source>...)
set(LODE_CMSIS_DIR "" CACHE PATH
    "ST's device headers: the folder CMSIS of STM32CubeG4, F4 or H7, or one with stm32g4xx.h, stm32f4xx.h or stm32h7xx.h")

# What every board needs but the emulated one.
set(lode_stm32_board "${LODE_PORT_DIR}/stm32/board.c" "${LODE_PORT_DIR}/stm32/pwm.c"
                     "${LODE_PORT_DIR}/stm32/supervise.c" ${lode_port_common})

function(lode_stm32_firmware target family script)
  string(TOLOWER "${family}" name)
  set(header "stm32${name}xx.h")
  set(folders "${LODE_CMSIS_DIR}" "${LODE_CMSIS_DIR}/Device/ST/STM32${family}xx/Include")
  unset(lode_device CACHE)
  find_path(lode_device ${header} PATHS ${folders} NO_DEFAULT_PATH NO_CMAKE_FIND_ROOT_PATH)
  if(NOT LODE_CMSIS_DIR OR NOT lode_device)
    message(FATAL_ERROR "LODE_CMSIS_DIR=${LODE_CMSIS_DIR}: expected ${header} there, or in "
                        "Device/ST/STM32${family}xx/Include below it")
  endif()
  lode_firmware(${target} "${LODE_PORT_DIR}/stm32/startup.c" "${LODE_PORT_DIR}/stm32/serial.c" ${ARGN})
  target_include_directories(${target} PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}" "${LODE_PORT_DIR}/stm32")
  target_compile_definitions(${target} PRIVATE "APP_NOINIT=__attribute__((section(\".noinit\")))")
  # System headers: their warnings are ST's.
  target_include_directories(${target} SYSTEM PRIVATE "${lode_device}" "${LODE_CMSIS_DIR}/Include"
                                                      "${LODE_CMSIS_DIR}/Core/Include")
  if(CMAKE_CROSSCOMPILING)
    target_link_options(${target} PRIVATE "-T${script}" "-L${LODE_PORT_DIR}/stm32"
                        "-Wl,-Map=${target}.map")
    set_target_properties(${target} PROPERTIES LINK_DEPENDS
                          "${script};${LODE_PORT_DIR}/stm32/sections.ld")
    add_custom_command(TARGET ${target} POST_BUILD
                       COMMAND ${CMAKE_OBJCOPY} -O binary $<TARGET_FILE:${target}> ${target}.bin
                       COMMAND ${CMAKE_SIZE} -A $<TARGET_FILE:${target}>)
  endif()
endfunction()
