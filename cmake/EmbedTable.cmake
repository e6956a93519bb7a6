# headstock_embed_table(TARGET NAME table_name FILE table.tsv COLUMNS a b …): compiles a tab-separated table into TARGET.
#
# The file's first line names its columns and must be exactly COLUMNS; every row must have as many cells. A mistake
# stops the build with file and line. In C++:
#   #include "tables/table_name.hpp"
#   for (const auto& row : headstock::tables::table_name) … row[0] … row[N-1]   // std::string_view each
# The tables are constants: nothing is parsed or allocated at run time, any thread may read them.
add_executable(embed_table ${CMAKE_CURRENT_LIST_DIR}/embed_table.cpp)
set_target_properties(embed_table PROPERTIES CXX_STANDARD 20 CXX_STANDARD_REQUIRED ON)
target_compile_options(embed_table PRIVATE -Wall -Wextra -Wconversion -Wshadow -Werror)

function(headstock_embed_table target)
  cmake_parse_arguments(ARG "" "NAME;FILE" "COLUMNS" ${ARGN})
  cmake_path(ABSOLUTE_PATH ARG_FILE BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
  set(out ${PROJECT_BINARY_DIR}/generated)
  add_custom_command(
    OUTPUT ${out}/tables/${ARG_NAME}.cpp ${out}/tables/${ARG_NAME}.hpp
    COMMAND embed_table ${ARG_FILE} ${ARG_NAME} ${out}/tables ${ARG_COLUMNS}
    DEPENDS embed_table ${ARG_FILE}
    COMMENT "Table ${ARG_NAME}"
    VERBATIM)
  target_sources(${target} PRIVATE ${out}/tables/${ARG_NAME}.cpp ${out}/tables/${ARG_NAME}.hpp)
  target_include_directories(${target} PUBLIC ${out})
endfunction()
