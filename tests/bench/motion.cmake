headstock_bench(motion SOURCES motion_bench.cpp DEPENDS headstock_motion)
