headstock_library(reasons SOURCES ${CMAKE_CURRENT_LIST_DIR}/reasons.cpp)
headstock_embed_table(headstock_reasons NAME reasons FILE ${CMAKE_CURRENT_LIST_DIR}/reasons.tsv COLUMNS key en zh)
