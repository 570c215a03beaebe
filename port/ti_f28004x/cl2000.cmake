# Toolchain file for TI's C2000 compiler: cl2000 in PATH.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR c28x)
find_program(CMAKE_C_COMPILER cl2000)
if(NOT CMAKE_C_COMPILER)
  message(FATAL_ERROR "cl2000 is not in PATH (TI: C2000-CGT)")
endif()
# fp_mode strict: the core needs IEEE comparisons and real divisions.
set(CMAKE_C_FLAGS_INIT "-v28 -ml --abi=eabi --float_support=fpu32 --fp_mode=strict")
set(CMAKE_C_FLAGS_RELEASE "--opt_level=2 --opt_for_speed=4" CACHE STRING "Flags of a release build")
set(CMAKE_EXE_LINKER_FLAGS_INIT "--run_linker --rom_model --entry_point=code_start")
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
