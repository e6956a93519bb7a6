# bench_line: characters a second over a paced line against what the line can carry.
headstock_program(bench_line SOURCES ${CMAKE_CURRENT_LIST_DIR}/line_bench.cpp ${PROJECT_SOURCE_DIR}/tests/unit/serial/simulated_control.cpp
  DEPENDS headstock::serial_port)
set_target_properties(bench_line PROPERTIES EXCLUDE_FROM_ALL TRUE)
add_dependencies(bench bench_line)
