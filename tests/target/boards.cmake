# The host's side of the replay, and a test per board.
add_executable(replay_host ${replay_sources})
set_target_properties(replay_host PROPERTIES C_STANDARD 99 C_STANDARD_REQUIRED ON C_EXTENSIONS OFF)
target_include_directories(replay_host PRIVATE "${PROJECT_SOURCE_DIR}/port/emulator")
target_link_libraries(replay_host PRIVATE lodestar::lodestar m)
lode_compile_options(replay_host ${LODE_HOST_WARNINGS})

if(LODE_BUILD_GATES)
  foreach(board m4f m7 m33 m3 m0 r5f)
    add_test(NAME target_${board}
             COMMAND bash "${CMAKE_CURRENT_SOURCE_DIR}/board.sh" target-${board}
                     $<TARGET_FILE:replay_host>)
    set_tests_properties(target_${board} PROPERTIES LABELS target TIMEOUT 300 SKIP_RETURN_CODE 77
                                                    PROCESSORS 2)
  endforeach()
endif()
