# Of the tests themselves, not of what they test: a quarter less time of the compiler than -O2.
set(ARGIL_TESTS_OPTIMISATION $<$<CONFIG:Release>:-O1>)

# argil_precompile(FROM TARGETS...): their files read what was compiled once for FROM: argil_precompiled has
# cmake/precompiled.h, argil_precompiled_tests GoogleTest too. They link the libraries that these headers are of.
if(ARGIL_PRECOMPILED)
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/precompiled.cpp CONTENT "// Compiled for its header alone.\n")
  add_library(argil_precompiled OBJECT ${CMAKE_BINARY_DIR}/precompiled.cpp)
  target_link_libraries(argil_precompiled PRIVATE Eigen3::Eigen fmt::fmt)
  target_precompile_headers(argil_precompiled PRIVATE ${PROJECT_SOURCE_DIR}/cmake/precompiled.h)
  add_library(argil_precompiled_tests OBJECT ${CMAKE_BINARY_DIR}/precompiled.cpp)
  target_link_libraries(argil_precompiled_tests PRIVATE Eigen3::Eigen fmt::fmt GTest::gmock)
  target_precompile_headers(argil_precompiled_tests PRIVATE ${PROJECT_SOURCE_DIR}/cmake/precompiled.h <gtest/gtest.h>)
  target_compile_options(argil_precompiled_tests PRIVATE ${ARGIL_TESTS_OPTIMISATION})
endif()
function(argil_precompile from)
  if(ARGIL_PRECOMPILED)
    foreach(target IN LISTS ARGN)
      target_precompile_headers(${target} REUSE_FROM ${from})
    endforeach()
  endif()
endfunction()

# argil_module(NAME DEPENDS modules... LIBRARIES libs... PRIVATE_LIBRARIES libs... EXCEPT folders...)
# One static library per module from the .cpp files of its folder and its subfolders, but for those that are programs of their own. DEPENDS names the modules that it may
# include: the arrows of the plan (tests/arrows checks the includes themselves).
function(argil_module name)
  cmake_parse_arguments(MODULE "" "" "DEPENDS;LIBRARIES;PRIVATE_LIBRARIES;EXCEPT" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  foreach(folder IN LISTS MODULE_EXCEPT)
    list(FILTER sources EXCLUDE REGEX "/${name}/${folder}/")
  endforeach()
  if(NOT sources)
    add_library(argil_${name} INTERFACE)
    return()
  endif()
  add_library(argil_${name} STATIC ${sources})
  target_include_directories(argil_${name} PUBLIC ${PROJECT_SOURCE_DIR})
  foreach(module IN LISTS MODULE_DEPENDS)
    target_link_libraries(argil_${name} PUBLIC argil_${module})
  endforeach()
  target_link_libraries(argil_${name} PUBLIC ${MODULE_LIBRARIES} PRIVATE ${MODULE_PRIVATE_LIBRARIES})
  argil_precompile(argil_precompiled argil_${name})
endfunction()

# argil_tests(KIND MODULE LIBRARIES libs... UNDER wrapper... PARTS n): tests/KIND/MODULE/*.cpp becomes the program
# KIND_MODULE and the CTest of that name, started by the wrapper if one is given; with PARTS n CTests KIND_MODULE_1 to
# KIND_MODULE_n, which have a part of the cases each and may run beside each other. Their reports are in reports/ of the
# build folder.
function(argil_tests kind module)
  cmake_parse_arguments(TESTS "" "PARTS" "LIBRARIES;UNDER" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/${kind}/${module}/*.cpp)
  if(NOT sources)
    return()
  endif()
  set(program ${kind}_${module})
  add_executable(${program} ${sources} ${PROJECT_SOURCE_DIR}/tests/support/own_folder.cpp)
  target_link_libraries(${program} PRIVATE ${TESTS_LIBRARIES} GTest::gmock GTest::gtest_main)
  if(TESTS_LIBRARIES)
    argil_precompile(argil_precompiled_tests ${program})
    if(ARGIL_PRECOMPILED)
      # g++ 12 warns of strings that are joined ("a" + text), wrongly (GCC bug 105329), where its headers are precompiled.
      target_compile_options(${program} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-restrict;-Wno-stringop-overflow>)
    endif()
  endif()
  if(NOT TESTS_PARTS)
    set(TESTS_PARTS 1)
  endif()
  foreach(part RANGE 1 ${TESTS_PARTS})
    set(name ${program})
    if(TESTS_PARTS GREATER 1)
      set(name ${program}_${part})
    endif()
    math(EXPR index "${part} - 1")
    add_test(NAME ${name} COMMAND ${TESTS_UNDER} $<TARGET_FILE:${program}>)
    # The limit is for a hang: on a machine that does four other things at once the slowest takes three quarters of it.
    # Mesa's software driver does with one thread what costs a fifth more with two, and other tests have the other cores.
    set_tests_properties(${name} PROPERTIES TIMEOUT 3600 ENVIRONMENT
      "LP_NUM_THREADS=1;GTEST_TOTAL_SHARDS=${TESTS_PARTS};GTEST_SHARD_INDEX=${index};GTEST_OUTPUT=xml:${CMAKE_BINARY_DIR}/reports/${name}.xml")
  endforeach()
endfunction()
