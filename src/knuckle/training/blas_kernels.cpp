// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/blas_kernels.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include <dlfcn.h>
#include <unistd.h>

namespace knuckle {
namespace {

constexpr const char* kChoice = "OPENBLAS_CORETYPE";
/// Kernels for processors without AVX2.
constexpr std::array<std::string_view, 6> kOldKernels{"Prescott",   "Core2",   "Penryn",
                                                      "Dunnington", "Nehalem", "Sandybridge"};

bool has_avx2() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
  return false;
#endif
}

bool has_avx512() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512vl");
#else
  return false;
#endif
}

/// Nothing where the system's BLAS is another one.
std::string kernels_of_openblas() {
  using Name = char* (*)();
  auto* const name = reinterpret_cast<Name>(::dlsym(RTLD_DEFAULT, "openblas_get_corename"));
  return name == nullptr ? std::string() : name();
}

}  // namespace

std::string better_blas_kernels(std::string_view chosen, bool has_avx2, bool has_avx512) {
  if (!has_avx2 || std::ranges::find(kOldKernels, chosen) == kOldKernels.end()) return {};
  return has_avx512 ? "SkylakeX" : "Haswell";
}

void use_better_blas_kernels(char** arguments) {
  if (std::getenv(kChoice) != nullptr) return;
  const std::string better = better_blas_kernels(kernels_of_openblas(), has_avx2(), has_avx512());
  std::error_code unknown;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", unknown);
  if (better.empty() || unknown) return;
  ::setenv(kChoice, better.c_str(), 1);
  ::execv(self.c_str(), arguments);  // where that fails, this one goes on, more slowly
}

}  // namespace knuckle
