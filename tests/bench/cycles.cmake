headstock_bench(cycles SOURCES cycles_bench.cpp DEPENDS headstock::dialects)
