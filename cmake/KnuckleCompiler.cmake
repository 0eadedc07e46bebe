# SPDX-License-Identifier: Apache-2.0
# Language level, warnings, sanitizers and the instruction set, for all of our own targets.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)  # every module may end in a shared library, of ours or of others
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)

set(KNUCKLE_SANITIZE "" CACHE STRING "Sanitizers to build with: `address` (and that of undefined behaviour), `thread`, or none")
option(KNUCKLE_WERROR "Treat warnings in our own code as errors" OFF)  # on in .ci/run: other compilers warn of other things
# All is built in half the time so, but after a change more of it has to be. Names must differ within a module, even those
# in unnamed namespaces.
option(KNUCKLE_UNITY "Compile the sources of a module in groups" ON)
set(KNUCKLE_UNITY_SIZE 5 CACHE STRING "Sources of a group: more make a whole build quicker, and one after a change slower")
# Tests, benchmarks and static libraries are compiled for one kind of processor, and so is all else without
# KNUCKLE_VARIANTS: see cmake/KnuckleLibraries.cmake.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set(default_arch x86-64-v3)  # AVX2 and FMA: every x86 processor since 2013
endif()
set(KNUCKLE_ARCH "${default_arch}" CACHE STRING "Value of -march; empty for the compiler's own default")
option(KNUCKLE_VARIANTS "Build program and shared libraries for any x86-64, with variants for newer ones, as packages need" OFF)
set(KNUCKLE_LEVELS "x86-64-v3;x86-64-v4" CACHE STRING "Newer x86-64 processors that KNUCKLE_VARIANTS compiles for")

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(CMAKE_C_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

# Results must be the same bits on every machine: no fused multiply-add behind our back, no fast-math.
add_compile_options(-ffp-contract=off)
# So does Eigen, whose vector code would use fused multiply-adds and sums of as many lanes as the processor has; only
# `segment` has it (see there). What Eigen aligns is the same under all flags, so that modules and variants agree.
add_compile_definitions(EIGEN_DONT_VECTORIZE EIGEN_MAX_STATIC_ALIGN_BYTES=16 EIGEN_MAX_ALIGN_BYTES=32)
# Who preloads a library to replace one of our functions gets what was inlined all the same.
add_compile_options(-fno-semantic-interposition)
if(KNUCKLE_ARCH)
  add_compile_options(-march=${KNUCKLE_ARCH})
endif()
# GCC warns of each function that takes a vector wider than the processor's. None of ours crosses a library's border.
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  add_compile_options(-Wno-psabi)
endif()
option(KNUCKLE_FUZZ "Build the fuzz targets with libFuzzer: needs clang" OFF)
if(KNUCKLE_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link)
  add_compile_definitions(FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION)
endif()
# Release leaves assertions out. Tests are to see them, ours and those of the standard library (an index behind the end).
option(KNUCKLE_ASSERTIONS "Check assertions whatever the build type is, and the standard library's preconditions" OFF)
if(KNUCKLE_ASSERTIONS)
  # Assertions say in which file they are: not where on this machine. GCC 12 takes what fmt's leave for a write behind the end.
  add_compile_options(-UNDEBUG -fmacro-prefix-map=${PROJECT_SOURCE_DIR}/= $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow>)
  add_compile_definitions(_GLIBCXX_ASSERTIONS)
endif()
if(KNUCKLE_SANITIZE STREQUAL "address")
  add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
elseif(KNUCKLE_SANITIZE STREQUAL "thread")
  add_compile_options(-fsanitize=thread -fno-omit-frame-pointer)
  add_link_options(-fsanitize=thread)
elseif(KNUCKLE_SANITIZE)
  message(FATAL_ERROR "KNUCKLE_SANITIZE is '${KNUCKLE_SANITIZE}', expected `address`, `thread` or nothing")
endif()

add_library(knuckle_warnings INTERFACE)
target_compile_options(knuckle_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor
                       -Woverloaded-virtual -Wcast-qual $<$<BOOL:${KNUCKLE_WERROR}>:-Werror>)
