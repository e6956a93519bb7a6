headstock_bench(bound SOURCES bound_bench.cpp least_time.cpp)
