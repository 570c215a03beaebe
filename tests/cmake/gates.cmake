# Every gate is a ctest test, gate_<name>, that runs one script of tests/tools. Exit code 77 means
# that its tool is not installed.

function(lode_gate name)
  add_test(NAME gate_${name} COMMAND ${ARGN} WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}")
  set_tests_properties(gate_${name} PROPERTIES LABELS gate TIMEOUT 300 SKIP_RETURN_CODE 77)
endfunction()

function(lode_add_gates)
  set(tools "${PROJECT_SOURCE_DIR}/tests/tools")
  set(python "${Python3_EXECUTABLE}")

  # The text of the tree.
  lode_gate(format bash ${tools}/format.sh)
  lode_gate(layers ${python} ${tools}/check_layers.py .)
  lode_gate(words ${python} ${tools}/check_words.py .)
  lode_gate(sim_layers ${python} ${tools}/check_sim_layers.py .)
  lode_gate(called ${python} ${tools}/check_called.py .)
  lode_gate(tree ${python} ${tools}/check_tree.py .)
  lode_gate(equations ${python} ${tools}/check_equations.py .)
  lode_gate(evidence ${python} ${tools}/check_evidence.py .)
  lode_gate(safety ${python} ${tools}/safety_page.py .)
  lode_gate(safety_planted ${python} ${tools}/safety_page.py . planted)
  lode_gate(equations_planted ${python} ${tools}/check_equations.py . --planted)

  lode_gate(figures ${python} ${tools}/figures.py check)

  lode_gate(tuning_fields ${python} ${tools}/check_golden.py ${tools}/tuning_fields.py
            sim/design/tuning_fields.h)

  # What compilers say.
  lode_gate(headers bash ${tools}/headers.sh)
  lode_gate(warnings_gcc bash ${tools}/warnings.sh gcc ${LODE_WARNINGS}
            -Wunsuffixed-float-constants -Wlogical-op -Wduplicated-cond ${LODE_FLOAT_FLAGS})
  lode_gate(warnings_clang bash ${tools}/warnings.sh clang ${LODE_WARNINGS} ${LODE_FLOAT_FLAGS})
  lode_gate(char16_clang bash ${tools}/char16_clang.sh)
  lode_gate(char16_cppcheck bash ${tools}/char16_cppcheck.sh)
  lode_gate(arm bash ${tools}/arm.sh ${LODE_FLOAT_FLAGS})
  lode_gate(symbols ${python} ${tools}/check_symbols.py $<TARGET_FILE:lodestar>)
  lode_gate(readme ${python} ${tools}/extract_readme.py . ${CMAKE_CURRENT_BINARY_DIR}/readme
            ${CMAKE_C_COMPILER})
  lode_gate(subdirectory bash ${tools}/subdirectory.sh)

  # Analysis.
  lode_gate(tidy bash ${tools}/tidy.sh)
  lode_gate(cppcheck bash ${tools}/cppcheck.sh)
  lode_gate(misra ${python} ${tools}/misra.py .)
  lode_gate(misra_planted ${python} ${tools}/misra.py . planted)

  # The tests again, built in other ways.
  lode_gate(sanitize bash ${tools}/sanitize.sh)
  lode_gate(clang bash ${tools}/clang.sh)
  lode_gate(coverage bash ${tools}/coverage.sh)
  lode_gate(mcdc bash ${tools}/mcdc.sh)
  lode_gate(memory bash ${tools}/memory.sh)
  set_tests_properties(gate_sanitize gate_clang gate_coverage gate_mcdc gate_memory
                       PROPERTIES TIMEOUT 1500 PROCESSORS 2 COST 1000)
  set_tests_properties(gate_tidy PROPERTIES TIMEOUT 600 COST 900)
endfunction()
