// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/torch_device.h"

#include <torch/cuda.h>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

TEST(TorchDevice, OfAProcessorIsTheSameForAllWorkers) {
  EXPECT_TRUE(device_from_name("cpu").is_cpu());
  EXPECT_TRUE(device_from_name("cpu", 3).is_cpu());
}

TEST(TorchDevice, ThatIsNoneIsNamed) {
  for (const char* const name : {"abacus", "", "cudas", "cuda:", "cuda:x", "cuda:1x", "cuda:-1", "cuda:1000"})
    EXPECT_THAT(error_of([&] { device_from_name(name); }), HasSubstr("device")) << name;
}

TEST(TorchDevice, OfEachWorkerIsAGpuOfItsOwnWhileThereAreEnough) {
  const int count = static_cast<int>(torch::cuda::device_count());
  if (count == 0) GTEST_SKIP() << "no GPU on this machine";
  for (int worker = 0; worker < 2 * count; ++worker)
    EXPECT_EQ(device_from_name("cuda", worker).index(), worker % count);
  EXPECT_EQ(device_from_name("cuda:0", 1).index(), 0) << "the one that is named";
}

}  // namespace
}  // namespace knuckle
