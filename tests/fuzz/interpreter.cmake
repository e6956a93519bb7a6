headstock_fuzz(interpreter SOURCES interpreter_fuzz.cpp DEPENDS headstock::dialects)
