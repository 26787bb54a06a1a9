# Warnings are errors, results agree across compilers and CPUs, one binary runs from x86-64-v2 up
# (kernels dispatch upwards at run time).
option(ARGIL_WERROR "Treat warnings as errors" ON)
option(ARGIL_FUZZ "Build nothing but the targets of tests/fuzz, with libFuzzer (needs clang)" OFF)
set(ARGIL_SANITIZE "" CACHE STRING "Sanitizers to build with: address,undefined or thread")

option(ARGIL_PRECOMPILED "Read the headers that most files include once for all of them" ON)

find_program(ARGIL_CCACHE ccache)
if(ARGIL_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # It keeps nothing that was made with a precompiled header unless it is told that macros of the command line count; and
  # what one checkout made serves another where it is told what is the checkout in a path.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros
                                  CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} ${ARGIL_CCACHE})
endif()
find_program(ARGIL_MOLD mold)
if(ARGIL_MOLD)
  add_link_options(-fuse-ld=mold)
endif()

add_compile_options(-Wall -Wextra -Wpedantic -Wshadow $<$<COMPILE_LANGUAGE:CXX>:-Wnon-virtual-dtor> $<$<COMPILE_LANGUAGE:CXX>:-Woverloaded-virtual>)
if(ARGIL_WERROR)
  add_compile_options(-Werror)
endif()
# What clang warns of and g++ does not: `a >> 3 != b` reads well enough.
add_compile_options($<$<CXX_COMPILER_ID:Clang>:-Wno-overloaded-shift-op-parentheses>)
# A fused multiply-add changes the last bit: stored results must have equal bits everywhere.
add_compile_options(-ffp-contract=off -fno-math-errno)
# g++ 12 drops the rounding of double(float(x)) in code that its straight-line vectorizer pairs up.
add_compile_options($<$<CXX_COMPILER_ID:GNU>:-fno-tree-slp-vectorize>)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  add_compile_options(-march=x86-64-v2)
endif()
if(ARGIL_SANITIZE)
  add_compile_options(-fsanitize=${ARGIL_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${ARGIL_SANITIZE})
  # g++ 12 takes parts of <regex> for uninitialized there.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    add_compile_options(-Wno-maybe-uninitialized)
  endif()
endif()
if(ARGIL_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link)  # the engine itself is linked to the targets: tests/fuzz
endif()
if(ARGIL_PRECOMPILED AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  add_compile_options(-fpch-preprocess)  # ccache asks for it
endif()
