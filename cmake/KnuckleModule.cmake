# SPDX-License-Identifier: Apache-2.0
include(GoogleTest)

# Compiles the target's sources in groups where KNUCKLE_UNITY is on.
function(knuckle_group_sources target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${KNUCKLE_UNITY} UNITY_BUILD_BATCH_SIZE ${KNUCKLE_UNITY_SIZE})
endfunction()

# Processors that code is compiled for besides KNUCKLE_ARCH (cmake/KnuckleLibraries.cmake).
set(KNUCKLE_OTHER_LEVELS "")
if(KNUCKLE_VARIANTS)
  set(KNUCKLE_OTHER_LEVELS x86-64 ${KNUCKLE_LEVELS})
  list(REMOVE_ITEM KNUCKLE_OTHER_LEVELS "${KNUCKLE_ARCH}")
endif()

# Modules whose results are the same bits on every processor: the generator, the forests and what these stand on.
set(KNUCKLE_EXACT_MODULES knuckle_core knuckle_camera knuckle_hand knuckle_forest knuckle_patch knuckle_synth)

# knuckle_round_alike(TARGET MODULE LEVEL)
#
# GCC 12 makes fused multiply-adds of neighbouring sums and differences although -ffp-contract=off forbids them. Without the
# instructions it cannot; AVX-512 brings them again, and there it is the vectoriser of straight code that has to go.
function(knuckle_round_alike target module level)
  if(NOT module IN_LIST KNUCKLE_EXACT_MODULES OR level STREQUAL "x86-64" OR NOT CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    return()
  endif()
  if(level STREQUAL "x86-64-v3")
    target_compile_options(${target} PRIVATE -mno-fma)
  else()
    target_compile_options(${target} PRIVATE -fno-tree-slp-vectorize)
  endif()
endfunction()

# knuckle_compile_for(LEVEL TARGET SOURCES...)
#
# Makes the object library TARGET.LEVEL, compiled like the module TARGET but for the processors LEVEL.
function(knuckle_compile_for level target)
  add_library(${target}.${level} OBJECT EXCLUDE_FROM_ALL ${ARGN})
  knuckle_group_sources(${target}.${level})
  target_include_directories(${target}.${level} PRIVATE $<TARGET_PROPERTY:${target},INCLUDE_DIRECTORIES>)
  target_compile_definitions(${target}.${level} PRIVATE $<TARGET_PROPERTY:${target},COMPILE_DEFINITIONS>)
  # The last -march counts.
  # GCC 12 warns of its own headers for AVX-512.
  target_compile_options(${target}.${level} PRIVATE $<TARGET_PROPERTY:${target},COMPILE_OPTIONS> -march=${level}
                         -Wno-maybe-uninitialized)
  knuckle_round_alike(${target}.${level} ${target} ${level})
  target_link_libraries(${target}.${level} PRIVATE $<TARGET_PROPERTY:${target},LINK_LIBRARIES>)
endfunction()

# knuckle_add_tests(NAME SOURCES ... OF module [TESTED_WITH target ...])
#
# Makes the test program knuckle_NAME_test for a module: each test is a process of its own, so what the program loads counts.
function(knuckle_add_tests name)
  cmake_parse_arguments(test "" "OF" "SOURCES;TESTED_WITH" ${ARGN})
  add_executable(knuckle_${name}_test ${test_SOURCES})
  knuckle_group_sources(knuckle_${name}_test)
  target_link_libraries(knuckle_${name}_test PRIVATE knuckle_${test_OF} knuckle_test_main ${test_TESTED_WITH} knuckle_warnings)
  gtest_discover_tests(knuckle_${name}_test TEST_PREFIX ${name}/ DISCOVERY_MODE PRE_TEST WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
endfunction()

# knuckle_add_module(NAME SOURCES ... [PUBLIC_HEADERS ...] [DEPENDS module ...] [PUBLIC lib ...] [PRIVATE lib ...] [TESTS ...]
#                    [TESTED_WITH target ...])
#
# Makes the static library knuckle_NAME from the sources of src/knuckle/NAME, and knuckle_NAME_test from its tests.
# PUBLIC_HEADERS are installed for programs that use Knuckle; they include public headers, Eigen and fmt only (tests/package).
# Headers that are not listed are private. DEPENDS names other modules; PUBLIC the libraries its headers show; PRIVATE those
# only its sources use; TESTED_WITH what
# its tests use besides.
function(knuckle_add_module name)
  cmake_parse_arguments(module "" "" "SOURCES;PUBLIC_HEADERS;DEPENDS;PUBLIC;PRIVATE;TESTS;TESTED_WITH" ${ARGN})
  list(TRANSFORM module_DEPENDS PREPEND knuckle_)
  add_library(knuckle_${name} STATIC ${module_SOURCES})
  target_include_directories(knuckle_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src>)
  target_compile_features(knuckle_${name} PUBLIC cxx_std_20)
  knuckle_group_sources(knuckle_${name})
  target_link_libraries(knuckle_${name} PUBLIC ${module_DEPENDS} ${module_PUBLIC}
                        PRIVATE ${module_PRIVATE} $<BUILD_INTERFACE:knuckle_warnings>)
  knuckle_round_alike(knuckle_${name} knuckle_${name} "${KNUCKLE_ARCH}")
  set_target_properties(knuckle_${name} PROPERTIES KNUCKLE_LIBRARIES "${module_PUBLIC};${module_PRIVATE}")
  foreach(level IN LISTS KNUCKLE_OTHER_LEVELS)
    knuckle_compile_for(${level} knuckle_${name} ${module_SOURCES})
  endforeach()
  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR}/src ${CMAKE_CURRENT_SOURCE_DIR})
  list(TRANSFORM module_PUBLIC_HEADERS PREPEND ${folder}/)
  set_property(GLOBAL APPEND PROPERTY KNUCKLE_PUBLIC_HEADERS ${module_PUBLIC_HEADERS})
  if(module_TESTS)
    knuckle_add_tests(${name} SOURCES ${module_TESTS} OF ${name} TESTED_WITH ${module_TESTED_WITH})
  endif()
endfunction()
