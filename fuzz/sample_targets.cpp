// SPDX-License-Identifier: Apache-2.0
// Training samples that are kept from one training to the next.
#include "fuzz_target.h"

#include <array>

#include "knuckle/core/error.h"
#include "knuckle/prepare/sample_block_index.h"
#include "knuckle/prepare/sample_file.h"

namespace knuckle::fuzz {

/// A file of samples, all of it and then one of them.
void run_samples(Bytes bytes) {
  const FuzzFile file(bytes, ".h5");
  const SampleFile samples(file.path(), Inputs());
  (void)samples.read();
  if (samples.size() == 0) return;
  CubeSamples one = samples.room_for(1);
  samples.read(std::array{samples.size() - 1}, one, 0);
}

/// The index of a folder of such files.
void run_sample_index(Bytes bytes) {
  constexpr int kJoints = 2;
  const FuzzFile file(bytes, ".h5");
  (void)read_block_index(file.path(), Inputs(), kJoints);
}

}  // namespace knuckle::fuzz
