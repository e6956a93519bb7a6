headstock_bench(motion SOURCES motion_bench.cpp optimal_time.cpp DEPENDS headstock_motion)
