# How every target of the project is made: one function for a library, one for a program, one for a unit test.

find_program(CCACHE ccache)
if(CCACHE)
  # Common headers (below) can be cached only with these two said.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE})
  set(CMAKE_C_COMPILER_LAUNCHER ${CCACHE})
endif()

add_library(headstock_options INTERFACE)
target_compile_options(headstock_options INTERFACE -Wall -Wextra -Wconversion -Wshadow -Werror -fno-omit-frame-pointer)
target_include_directories(headstock_options INTERFACE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/controller-agent)
# GCC 12 takes Asio's coroutine frames for mismatched allocations, as it happens to inline.
target_compile_options(headstock_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-mismatched-new-delete>)
# The same samples bit for bit in the agent, the simulator and the server: no contraction that differs by inlining.
target_compile_options(headstock_options INTERFACE -ffp-contract=off)
if(HEADSTOCK_SANITIZE)
  target_compile_options(headstock_options INTERFACE -fsanitize=${HEADSTOCK_SANITIZE} -fno-sanitize-recover=all -O1)
  target_link_options(headstock_options INTERFACE -fsanitize=${HEADSTOCK_SANITIZE})
  # GCC 12 warns falsely inside standard headers when sanitizers change inlining.
  target_compile_options(headstock_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized> $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow>)
  # What the standard library asks of its callers (an index inside, a value that is there), asked aloud.
  target_compile_definitions(headstock_options INTERFACE _GLIBCXX_ASSERTIONS)
  if(HEADSTOCK_SANITIZE MATCHES "undefined")
    # A number too large for the integer it is turned into is undefined as well, but not among what "undefined" covers.
    target_compile_options(headstock_options INTERFACE -fsanitize=float-cast-overflow)
    target_link_options(headstock_options INTERFACE -fsanitize=float-cast-overflow)
  endif()
  if(HEADSTOCK_SANITIZE MATCHES "thread")
    # Asio has a fence in it that the thread sanitizer does not model; GCC 12 says so at every include.
    target_compile_options(headstock_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-tsan>)
  endif()
endif()
if(HEADSTOCK_FUZZ)
  target_compile_options(headstock_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

if(HEADSTOCK_TOGETHER AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # Joined sources are large: the compiler looks for memory to free from 700 MB (its unit is kB) instead of 128 MB.
  add_compile_options($<$<COMPILE_LANGUAGE:CXX>:--param=ggc-min-heapsize=700000>)
  find_program(GOLD ld.gold)
  if(GOLD)  # links in half the time
    add_link_options(-fuse-ld=gold)
  endif()
endif()

# The headers that nearly every source of a kind reads, read once for all of them: headstock_common_headers(NAME LEVEL HEADER
# [LIBRARY]) makes them for targets compiled with -O<LEVEL> that use LIBRARY. A source includes what it uses all the same: an
# ordinary build has none.
function(headstock_common_headers name level header)
  if(HEADSTOCK_TOGETHER AND CMAKE_BUILD_TYPE STREQUAL "Release")
    file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/common_headers/${name}.cpp CONTENT "")
    add_library(headstock_headers_${name} OBJECT ${CMAKE_BINARY_DIR}/common_headers/${name}.cpp)
    target_link_libraries(headstock_headers_${name} PRIVATE headstock_options ${ARGN})
    target_compile_options(headstock_headers_${name} PRIVATE -O${level})
    target_precompile_headers(headstock_headers_${name} PRIVATE ${PROJECT_SOURCE_DIR}/${header})
  endif()
endfunction()

# Several sources in one run of the compiler: their headers are read once. headstock_together(TARGET… ALONE SOURCE… HEADERS
# NAME AT_ONCE n) names the targets whose sources may stand in one file; ALONE are those whose file-local names clash with their
# neighbours', HEADERS the common headers that fit how these targets are compiled.
function(headstock_together)
  cmake_parse_arguments(ARG "" "HEADERS;AT_ONCE" "ALONE" ${ARGN})
  if(NOT ARG_AT_ONCE)
    set(ARG_AT_ONCE 8)
  endif()
  if(HEADSTOCK_TOGETHER)
    foreach(target ${ARG_UNPARSED_ARGUMENTS})
      get_target_property(folder ${target} SOURCE_DIR)
      foreach(source ${ARG_ALONE})
        set_property(SOURCE ${folder}/${source} TARGET_DIRECTORY ${target} PROPERTY SKIP_UNITY_BUILD_INCLUSION ON)
      endforeach()
      set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${ARG_AT_ONCE})
      # Seen from the joined file, what is local to one source looks as if it were local to a header.
      target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
      if(ARG_HEADERS AND TARGET headstock_headers_${ARG_HEADERS})
        target_precompile_headers(${target} REUSE_FROM headstock_headers_${ARG_HEADERS})
        # Read ahead, standard headers are no system headers to GCC 12: it warns falsely where their strings are inlined.
        foreach(warning stringop-overflow restrict array-bounds)
          target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-${warning}>)
        endforeach()
      endif()
    endforeach()
  endif()
endfunction()

# headstock_library(NAME SOURCES a.cpp … DEPENDS other …): static library, alias headstock::NAME.
function(headstock_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  if(ARG_SOURCES)
    add_library(headstock_${name} STATIC ${ARG_SOURCES})
    target_link_libraries(headstock_${name} PUBLIC headstock_options ${ARG_DEPENDS})
  else()
    add_library(headstock_${name} INTERFACE)
    target_link_libraries(headstock_${name} INTERFACE headstock_options ${ARG_DEPENDS})
  endif()
  add_library(headstock::${name} ALIAS headstock_${name})
endfunction()

# headstock_program(NAME SOURCES … DEPENDS …): an executable in build/<preset>/bin.
function(headstock_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE headstock_options ${ARG_DEPENDS})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
endfunction()

# headstock_test(NAME SOURCES … DEPENDS … LABELS … SECONDS n COMPUTES): a GoogleTest program, run whole by ctest (one case of it:
# `NAME --gtest_filter=…`), those that take long by SECONDS first. What is tested is optimised; the tests
# themselves only where they compute (a reference, a search).
function(headstock_test name)
  cmake_parse_arguments(ARG "COMPUTES" "SECONDS" "SOURCES;DEPENDS;LABELS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  if(NOT ARG_COMPUTES)
    target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O0>)
  endif()
  target_link_libraries(${name} PRIVATE headstock_options ${ARG_DEPENDS} GTest::gtest_main GTest::gmock)
  target_compile_definitions(${name} PRIVATE HEADSTOCK_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
    HEADSTOCK_BINARY_DIR="${CMAKE_BINARY_DIR}")
  if(NOT ARG_LABELS)
    set(ARG_LABELS unit)
  endif()
  add_test(NAME ${name} COMMAND ${name})
  set(longest_s 600)
  if(HEADSTOCK_SANITIZE)
    set(longest_s 3600)
  endif()
  set_tests_properties(${name} PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT ${longest_s})
  if(ARG_SECONDS)
    set_tests_properties(${name} PROPERTIES COST ${ARG_SECONDS})
  endif()
endfunction()
