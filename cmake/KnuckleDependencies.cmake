# SPDX-License-Identifier: Apache-2.0
# What the libraries are built with: Debian packages, found here once for all modules; scripts/setup.sh installs them. Who uses
# an installed Knuckle needs Eigen and fmt alone (knuckleConfig.cmake.in).
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(HDF5 REQUIRED COMPONENTS C)
find_package(TBB REQUIRED)
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(XXHASH REQUIRED IMPORTED_TARGET libxxhash)
pkg_check_modules(DEFLATE REQUIRED IMPORTED_TARGET libdeflate)
pkg_check_modules(MATIO REQUIRED IMPORTED_TARGET matio)  # tests write files with it
find_package(PNG REQUIRED)
find_package(BZip2 REQUIRED)
pkg_check_modules(LZ4 REQUIRED IMPORTED_TARGET liblz4)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
find_package(ZLIB REQUIRED)
pkg_check_modules(OPENEXR REQUIRED IMPORTED_TARGET OpenEXR)  # its CMake package needs files that Debian leaves out
find_package(Threads REQUIRED)

# The server of `live --view` alone: without Boost the program has none, and says so.
find_package(Boost 1.74 QUIET)

# Cameras, and recordings of OpenNI2, each in a process of its own: without its library the program has none, and says so.
pkg_check_modules(FREENECT QUIET IMPORTED_TARGET libfreenect)
pkg_check_modules(OPENNI2 QUIET IMPORTED_TARGET libopenni2)

# The CMake package of OpenCV comes only with all of it (Qt, VTK, ...): find the modules that we use ourselves.
find_path(OPENCV_INCLUDE_FOLDER opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
add_library(knuckle_opencv INTERFACE IMPORTED GLOBAL)
target_include_directories(knuckle_opencv INTERFACE ${OPENCV_INCLUDE_FOLDER})
foreach(module core imgproc)
  find_library(OPENCV_${module}_LIBRARY opencv_${module} REQUIRED)
endforeach()
target_link_libraries(knuckle_opencv INTERFACE ${OPENCV_core_LIBRARY} ${OPENCV_imgproc_LIBRARY})

# Runs ONNX files: the module net/onnx loads it when it is needed. Without it such files are checked and refused.
find_library(OPENCV_dnn_LIBRARY opencv_dnn)
find_path(OPENCV_DNN_INCLUDE_FOLDER opencv2/dnn.hpp PATH_SUFFIXES opencv4)
if(OPENCV_dnn_LIBRARY AND OPENCV_DNN_INCLUDE_FOLDER)
  add_library(knuckle_opencv_networks INTERFACE IMPORTED GLOBAL)
  target_include_directories(knuckle_opencv_networks INTERFACE ${OPENCV_DNN_INCLUDE_FOLDER})
  target_link_libraries(knuckle_opencv_networks INTERFACE ${OPENCV_core_LIBRARY} ${OPENCV_dnn_LIBRARY})
endif()

# HDF5 exports variables, not usage requirements.
add_library(knuckle_libhdf5 INTERFACE IMPORTED GLOBAL)
target_include_directories(knuckle_libhdf5 INTERFACE ${HDF5_C_INCLUDE_DIRS})
target_link_libraries(knuckle_libhdf5 INTERFACE ${HDF5_C_LIBRARIES})
