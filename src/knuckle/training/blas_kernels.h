// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace knuckle {

/// OpenBLAS chooses its kernels by the processor's model as it is loaded. On a model that is newer than the
/// library it takes those of 2004: Debian 12's trains `regression` at 158 instead of 337 samples/s on a Xeon
/// of 2023. Returns the kernels to ask it for by OPENBLAS_CORETYPE, or nothing where it has `chosen` well.
std::string better_blas_kernels(std::string_view chosen, bool has_avx2, bool has_avx512);

/// Starts this program anew, once, where OpenBLAS has not chosen well (0.45 s); OPENBLAS_CORETYPE, where set,
/// is the user's choice. `arguments`: those of main(), which calls this first.
void use_better_blas_kernels(char** arguments);

}  // namespace knuckle
