# SPDX-License-Identifier: Apache-2.0
# What only the programs, the tests and the benchmarks need.
find_package(CLI11 REQUIRED)

option(KNUCKLE_DEVELOPMENT "Tests, benchmarks and the training of networks: needs GoogleTest, Google Benchmark and LibTorch" ON)
add_library(knuckle_torch INTERFACE IMPORTED GLOBAL)
add_library(knuckle_opencv_codecs INTERFACE IMPORTED GLOBAL)
if(NOT KNUCKLE_DEVELOPMENT)
  # Targets that use these are known then, but cannot be built.
  foreach(library GTest::gtest_main GTest::gmock benchmark::benchmark_main)
    add_library(${library} INTERFACE IMPORTED GLOBAL)
  endforeach()
  return()
endif()

find_package(GTest REQUIRED)
find_package(benchmark REQUIRED)

# Another reader and writer of PNG. It brings a hundred libraries, so nothing but tests is linked to it.
find_library(OPENCV_imgcodecs_LIBRARY opencv_imgcodecs REQUIRED)
target_link_libraries(knuckle_opencv_codecs INTERFACE knuckle_opencv ${OPENCV_imgcodecs_LIBRARY})

# LibTorch's CMake package asks for files that Debian leaves out, and warns of each: where it is Debian's, name the three
# libraries ourselves, and those of CUDA where it is libtorch-cuda-dev. Elsewhere CMAKE_PREFIX_PATH tells where it lies.
find_path(TORCH_API_INCLUDE_FOLDER torch/torch.h PATHS /usr/include/torch/csrc/api/include NO_DEFAULT_PATH)
if(TORCH_API_INCLUDE_FOLDER)
  target_include_directories(knuckle_torch INTERFACE ${TORCH_API_INCLUDE_FOLDER})
  target_link_libraries(knuckle_torch INTERFACE torch torch_cpu c10 ${CMAKE_DL_LIBS})
  find_library(TORCH_CUDA_LIBRARY torch_cuda)
  if(TORCH_CUDA_LIBRARY)
    # Nothing is called in it by name: what it has registers itself.
    target_link_libraries(knuckle_torch INTERFACE -Wl,--no-as-needed ${TORCH_CUDA_LIBRARY} c10_cuda -Wl,--as-needed)
  endif()
else()
  find_package(Torch REQUIRED)
  target_include_directories(knuckle_torch INTERFACE ${TORCH_INCLUDE_DIRS})
  target_link_libraries(knuckle_torch INTERFACE ${TORCH_LIBRARIES} ${CMAKE_DL_LIBS})
endif()
