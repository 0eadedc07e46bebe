# SPDX-License-Identifier: Apache-2.0
# The two shared libraries, which the program and its users link:
#
#   libknuckle_runtime   from depth to poses
#   libknuckle           on top of it: recordings, generator, preparation of training, evaluation
#
# Without KNUCKLE_VARIANTS they are compiled for KNUCKLE_ARCH. With it they, and the program, run on any x86-64
# processor, and below glibc-hwcaps/ lie variants of both for newer ones, from which glibc's loader (2.33 and later)
# takes the best that the processor can run. No type of a public header may therefore depend on -march.
include(GNUInstallDirs)

set(KNUCKLE_RUNTIME_MODULES core storage camera hand data forest layers onnx segment patch net estimate refine pipeline track)
set(KNUCKLE_LIBRARY_MODULES hdf5 hdf5_writer readers writers stream synth prepare eval)
set(KNUCKLE_VARIANT_LEVELS "")
set(KNUCKLE_BASE_SUFFIX "")  # of the object libraries of what runs everywhere
if(KNUCKLE_VARIANTS)
  set(KNUCKLE_VARIANT_LEVELS ${KNUCKLE_LEVELS})
  set(KNUCKLE_BASE_SUFFIX .x86-64)
endif()

# knuckle_shared_library(TARGET FILE_NAME SUFFIX MODULES...)
#
# Makes the shared library libFILE_NAME from the objects of the modules knuckle_MODULE and SUFFIX.
function(knuckle_shared_library target file_name suffix)
  list(TRANSFORM ARGN PREPEND knuckle_ OUTPUT_VARIABLE modules)
  list(TRANSFORM modules REPLACE "(.+)" "$<TARGET_OBJECTS:\\1${suffix}>" OUTPUT_VARIABLE objects)
  add_library(${target} SHARED ${objects})
  foreach(module IN LISTS modules)
    get_target_property(libraries ${module} KNUCKLE_LIBRARIES)
    target_link_libraries(${target} PRIVATE ${libraries})
  endforeach()
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src>)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_link_libraries(${target} INTERFACE Eigen3::Eigen fmt::fmt)  # what public headers show
  # Only our own names leave the library, and calls within it stay within it.
  target_link_options(${target} PRIVATE -Wl,-Bsymbolic-functions -Wl,--no-undefined
                      -Wl,--version-script=${PROJECT_SOURCE_DIR}/cmake/exported_symbols.map)
  set_target_properties(${target} PROPERTIES OUTPUT_NAME ${file_name} VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} LINKER_LANGUAGE CXX INSTALL_RPATH "$ORIGIN"
    LINK_DEPENDS ${PROJECT_SOURCE_DIR}/cmake/exported_symbols.map)
endfunction()

knuckle_shared_library(knuckle_runtime knuckle_runtime "${KNUCKLE_BASE_SUFFIX}" ${KNUCKLE_RUNTIME_MODULES})
knuckle_shared_library(knuckle_library knuckle "${KNUCKLE_BASE_SUFFIX}" ${KNUCKLE_LIBRARY_MODULES})
target_link_libraries(knuckle_library PUBLIC knuckle_runtime)
set_target_properties(knuckle_library PROPERTIES EXPORT_NAME knuckle)

foreach(level IN LISTS KNUCKLE_VARIANT_LEVELS)
  set(suffix .${level})
  if(level STREQUAL KNUCKLE_ARCH)
    set(suffix "")
  endif()
  knuckle_shared_library(knuckle_runtime_${level} knuckle_runtime "${suffix}" ${KNUCKLE_RUNTIME_MODULES})
  knuckle_shared_library(knuckle_library_${level} knuckle "${suffix}" ${KNUCKLE_LIBRARY_MODULES})
  target_link_libraries(knuckle_library_${level} PUBLIC knuckle_runtime_${level})
  set_target_properties(knuckle_runtime_${level} knuckle_library_${level} PROPERTIES
    LIBRARY_OUTPUT_DIRECTORY ${CMAKE_LIBRARY_OUTPUT_DIRECTORY}/glibc-hwcaps/${level})
  install(TARGETS knuckle_runtime_${level} knuckle_library_${level}
          LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/glibc-hwcaps/${level} COMPONENT knuckle NAMELINK_SKIP)
endforeach()

# knuckle_link_program(TARGET MODULES...)
#
# Links a program, which shall run wherever the libraries do, with them and with modules that are in neither.
function(knuckle_link_program target)
  if(KNUCKLE_VARIANTS)
    target_compile_options(${target} PRIVATE -march=x86-64)  # the last -march counts
  endif()
  foreach(module IN LISTS ARGN)
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:knuckle_${module}${KNUCKLE_BASE_SUFFIX}>)
    get_target_property(libraries knuckle_${module} KNUCKLE_LIBRARIES)
    target_link_libraries(${target} PRIVATE ${libraries})
  endforeach()
  target_link_libraries(${target} PRIVATE knuckle_library)
  set_target_properties(${target} PROPERTIES INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}")
endfunction()
