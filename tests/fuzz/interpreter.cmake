# One program a profile: fuzz_interpreter_fanuc-0i-t …
foreach(profile fanuc-0i-t fanuc-0i-m gsk-2000tc gsk-218t k2000tc lathe-200t)
  headstock_fuzz(interpreter_${profile} SOURCES interpreter_fuzz.cpp DEPENDS headstock::dialects)
  target_compile_definitions(fuzz_interpreter_${profile} PRIVATE HEADSTOCK_PROFILE="${profile}")
endforeach()
