# SPDX-License-Identifier: Apache-2.0
# Debian packages, found here once for all modules; scripts/setup.sh installs them.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(OpenCV 4.5 REQUIRED COMPONENTS core imgproc imgcodecs)
find_package(HDF5 REQUIRED COMPONENTS C)
find_package(TBB REQUIRED)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(OpenEXR CONFIG REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(GTest REQUIRED)
find_package(benchmark REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(MATIO REQUIRED IMPORTED_TARGET matio)

# OpenCV and HDF5 export variables, not usage requirements: wrap what we use of them.
add_library(knuckle_opencv INTERFACE)
target_include_directories(knuckle_opencv SYSTEM INTERFACE ${OpenCV_INCLUDE_DIRS})
target_link_libraries(knuckle_opencv INTERFACE opencv_core opencv_imgproc opencv_imgcodecs)
add_library(knuckle_hdf5 INTERFACE)
target_include_directories(knuckle_hdf5 SYSTEM INTERFACE ${HDF5_C_INCLUDE_DIRS})
target_link_libraries(knuckle_hdf5 INTERFACE ${HDF5_C_LIBRARIES})
