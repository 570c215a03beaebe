# Toolchain file for Arm's bare-metal gcc: -DCMAKE_TOOLCHAIN_FILE=port/cmake/arm-none-eabi.cmake
# LODE_CORE names the core; the float ABI is the hard one wherever the core has an FPU.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR arm)

find_program(CMAKE_C_COMPILER arm-none-eabi-gcc)
if(NOT CMAKE_C_COMPILER)
  message(FATAL_ERROR "arm-none-eabi-gcc is not in PATH (Debian: gcc-arm-none-eabi, libnewlib-arm-none-eabi)")
endif()
find_program(CMAKE_SIZE arm-none-eabi-size)
set(CMAKE_ASM_COMPILER "${CMAKE_C_COMPILER}")

set(LODE_CORE "cortex-m4f" CACHE STRING
    "cortex-m0, cortex-m3, cortex-m4f, cortex-m7, cortex-m33 or cortex-r5f")
set(lode_cpu_cortex-m0 "-mcpu=cortex-m0 -mthumb -mfloat-abi=soft")
set(lode_cpu_cortex-m3 "-mcpu=cortex-m3 -mthumb -mfloat-abi=soft")
set(lode_cpu_cortex-m4f "-mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard")
set(lode_cpu_cortex-m7 "-mcpu=cortex-m7 -mthumb -mfpu=fpv5-d16 -mfloat-abi=hard")
set(lode_cpu_cortex-m33 "-mcpu=cortex-m33 -mthumb -mfpu=fpv5-sp-d16 -mfloat-abi=hard")
set(lode_cpu_cortex-r5f "-mcpu=cortex-r5 -marm -mfpu=vfpv3-d16 -mfloat-abi=hard")
if(NOT DEFINED "lode_cpu_${LODE_CORE}")
  message(FATAL_ERROR "LODE_CORE=${LODE_CORE}: expected cortex-m0, -m3, -m4f, -m7, -m33 or -r5f")
endif()

set(CMAKE_C_FLAGS_INIT "${lode_cpu_${LODE_CORE}} -ffunction-sections -fdata-sections")
# CMake would append -O3 to an _INIT value; -O3 buys little here and costs flash.
set(CMAKE_C_FLAGS_RELEASE "-O2 -g" CACHE STRING "Flags of a release build")
# Without any optimisation the smaller chips' flash does not hold the application.
set(CMAKE_C_FLAGS_DEBUG "-Og -g" CACHE STRING "Flags of a debug build")
set(CMAKE_ASM_FLAGS_INIT "${lode_cpu_${LODE_CORE}}")
# A port brings its own start-up code and linker script.
set(CMAKE_EXE_LINKER_FLAGS_INIT "-nostartfiles --specs=nano.specs -Wl,--gc-sections")

# CMake's first test program would need a linker script.
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES LODE_CORE)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
