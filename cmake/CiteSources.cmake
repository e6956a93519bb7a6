# headstock_cite_sources(TARGET FOLDER): generated/tables/citations.hpp, what the sources below FOLDER raise and read
# (see cite_sources.cpp). Made anew when one of them changes, and rewritten only when its contents change.
add_executable(cite_sources ${CMAKE_CURRENT_LIST_DIR}/cite_sources.cpp)
set_target_properties(cite_sources PROPERTIES CXX_STANDARD 20 CXX_STANDARD_REQUIRED ON)
target_compile_options(cite_sources PRIVATE -Wall -Wextra -Wconversion -Wshadow -Werror)

function(headstock_cite_sources target folder)
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${folder}/*.cpp ${folder}/*.hpp)
  list(FILTER sources EXCLUDE REGEX "alarm_reason\\.hpp$")
  set(out ${PROJECT_BINARY_DIR}/generated/tables/citations.hpp)
  set(reasons ${PROJECT_SOURCE_DIR}/controller-agent/dialects/alarm_reason.hpp)
  add_custom_command(
    OUTPUT ${out}
    COMMAND cite_sources ${folder} ${reasons} ${out} ${sources}
    DEPENDS cite_sources ${reasons} ${sources}
    COMMENT "What the controllers' sources raise and read"
    VERBATIM)
  target_sources(${target} PRIVATE ${out})
  target_include_directories(${target} PUBLIC ${PROJECT_BINARY_DIR}/generated)
endfunction()
