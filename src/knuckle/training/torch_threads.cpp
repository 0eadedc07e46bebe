// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/torch_threads.h"

#include <ATen/Parallel.h>
#include <dlfcn.h>

namespace knuckle {
namespace {

/// OpenBLAS has a pool of its own where Debian's package for POSIX threads is the system's BLAS.
void set_blas_threads(int count) {
  using SetThreads = void (*)(int);
  if (auto* const set = reinterpret_cast<SetThreads>(::dlsym(RTLD_DEFAULT, "openblas_set_num_threads"))) {
    set(count);
  }
}

}  // namespace

void use_calling_thread_alone() {
  // OpenMP's number of threads belongs to the calling thread: once each is enough.
  thread_local bool is_set = false;
  if (is_set) return;
  at::set_num_threads(1);
  set_blas_threads(1);
  is_set = true;
}

}  // namespace knuckle
