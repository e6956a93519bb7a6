headstock_fuzz(frame SOURCES frame_fuzz.cpp DEPENDS headstock::wire)
