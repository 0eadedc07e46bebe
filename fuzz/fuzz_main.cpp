// SPDX-License-Identifier: Apache-2.0
// libFuzzer's entry: one program per target, which KNUCKLE_FUZZ_TARGET names.
#include "fuzz_target.h"

#include <cstddef>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  knuckle::fuzz::run_target(KNUCKLE_FUZZ_TARGET, {data, size});
  return 0;
}
