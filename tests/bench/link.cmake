# bench_drip: a drip-feed against openssl s_server and s_client in the same run.
headstock_program(bench_drip SOURCES ${CMAKE_CURRENT_LIST_DIR}/drip_bench.cpp ${CMAKE_CURRENT_LIST_DIR}/openssl_pair.cpp
  ${PROJECT_SOURCE_DIR}/tests/unit/link/shop.cpp
  DEPENDS headstock::link headstock::gateway)
# bench_drip_fleet: 200 machines fed at once, none starved.
headstock_program(bench_drip_fleet SOURCES ${CMAKE_CURRENT_LIST_DIR}/drip_fleet_bench.cpp ${PROJECT_SOURCE_DIR}/tests/unit/link/shop.cpp
  DEPENDS headstock::link headstock::gateway)
# fleet_simulator: many agents without a CNC, against a running server.
headstock_program(fleet_simulator SOURCES ${CMAKE_CURRENT_LIST_DIR}/fleet_simulator.cpp DEPENDS headstock::link headstock::process)
set_target_properties(bench_drip bench_drip_fleet fleet_simulator PROPERTIES EXCLUDE_FROM_ALL TRUE)
add_dependencies(bench bench_drip bench_drip_fleet fleet_simulator)
