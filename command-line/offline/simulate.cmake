# headstock simulate
headstock_library(offline_simulate
  SOURCES simulate.cpp
  DEPENDS headstock::offline_interpret headstock::operation nlohmann_json::nlohmann_json)
