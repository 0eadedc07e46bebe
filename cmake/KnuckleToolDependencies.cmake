# SPDX-License-Identifier: Apache-2.0
# What only the program, the tests and the benchmarks need.
find_package(CLI11 REQUIRED)
find_package(GTest REQUIRED)
find_package(benchmark REQUIRED)
