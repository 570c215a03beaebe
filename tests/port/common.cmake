# What every board with a header of figures shares.
lode_port_test(test_port_ntc "${CMAKE_CURRENT_SOURCE_DIR}/test_port_ntc.c" "${LODE_PORT_DIR}/common/ntc.c")
