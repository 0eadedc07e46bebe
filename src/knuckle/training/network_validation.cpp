// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/network_validation.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <torch/utils.h>

#include "knuckle/core/parallel.h"
#include "knuckle/core/statistics.h"
#include "knuckle/training/torch_threads.h"

namespace knuckle {
namespace {

constexpr std::int64_t kChunk = 32;

/// Samples that go through the network together.
class Chunk {
 public:
  Chunk(const CubeSamples& samples, std::int64_t first, std::int64_t count)
      : samples_(samples), viewer_(samples), first_(first), views_(static_cast<std::size_t>(count)) {}

  /// Predicts the joints in the present views; their errors.
  RunningMean look(NetworkModule& network, const torch::Device& device) {
    const int64_t count = std::ssize(views_);
    const int64_t size = samples_.patch().size_px;
    const auto numbers = static_cast<std::size_t>(samples_.joint_count()) * 3;
    torch::Tensor patches = torch::empty({count, 1, size, size});
    Random unused(0);
    for (int64_t i = 0; i < count; ++i) {
      const std::span<float> pixels(patches.data_ptr<float>() + i * size * size,
                                    static_cast<std::size_t>(size * size));
      viewer_.view_pixels(sample(i), views_[i], {}, unused, pixels);
    }
    patches = patches.to(device);
    const torch::Tensor joints = network.decode(network.forward(patches), patches).joints.cpu().contiguous();
    predicted_.assign(joints.data_ptr<float>(), joints.data_ptr<float>() + joints.numel());
    RunningMean sum;
    std::vector<float> truth(numbers);
    for (int64_t i = 0; i < count; ++i) {
      viewer_.view_joints(sample(i), views_[i], truth);
      for (std::size_t j = 0; j < numbers; j += 3) add_error(sum, i, j, truth);
    }
    return sum;
  }

  void move_to_joints_found() {
    const auto numbers = static_cast<std::size_t>(samples_.joint_count()) * 3;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      const std::span<const float> joints = std::span<const float>(predicted_).subspan(i * numbers, numbers);
      views_[i] = viewer_.around_mean_joint(sample(static_cast<int64_t>(i)), views_[i], joints);
    }
  }

 private:
  CubeSample sample(int64_t i) const { return samples_.sample(first_ + i); }

  /// A joint that is not known does not count; one that is predicted as NaN makes the sum NaN.
  void add_error(RunningMean& sum, int64_t i, std::size_t j, const std::vector<float>& truth) const {
    if (!std::isfinite(truth[j] + truth[j + 1] + truth[j + 2])) return;
    const float* const found = predicted_.data() + static_cast<std::size_t>(i) * truth.size() + j;
    const Point3 at = viewer_.in_camera(sample(i), views_[i], std::span<const float, 3>(found, 3));
    const Point3 is = viewer_.in_camera(sample(i), views_[i], std::span<const float, 3>(truth.data() + j, 3));
    sum.add((at - is).norm());
  }

  const CubeSamples& samples_;
  CubeViewer viewer_;
  std::int64_t first_;
  std::vector<CubeView> views_;
  std::vector<float> predicted_;
};

}  // namespace

std::vector<double> validation_errors(NetworkModule& network, const CubeSamples& samples,
                                      const torch::Device& device) {
  const std::int64_t chunks = (samples.size() + kChunk - 1) / kChunk;
  std::vector<RunningMean> first(static_cast<std::size_t>(chunks));
  std::vector<RunningMean> second(first.size());
  parallel_for(chunks, [&](std::int64_t c) {
    use_calling_thread_alone();
    const c10::InferenceMode inference;
    Chunk chunk(samples, c * kChunk, std::min(kChunk, samples.size() - c * kChunk));
    first[static_cast<std::size_t>(c)] = chunk.look(network, device);
    chunk.move_to_joints_found();
    second[static_cast<std::size_t>(c)] = chunk.look(network, device);
  });
  RunningMean first_sum;
  RunningMean second_sum;
  for (const RunningMean& sum : first) first_sum.add(sum);
  for (const RunningMean& sum : second) second_sum.add(sum);
  return {first_sum.value(), second_sum.value()};
}

}  // namespace knuckle
