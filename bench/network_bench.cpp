// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include "knuckle/core/random.h"
#include "knuckle/net/net_testing.h"
#include "knuckle/net/pose_network.h"

namespace knuckle {
namespace {

/// From patch to pose, a patch at a time on one thread; the weights say nothing of the time.
void estimate(benchmark::State& state, std::string_view architecture) {
  NetworkOptions options;
  options.architecture = architecture;
  const PoseNetwork network(options, 1);
  Image<float> patch(options.patch.size_px, options.patch.size_px);
  Random random(1);
  for (float& pixel : patch.pixels()) pixel = static_cast<float>(random.uniform(-1.0, 1.0));
  for ([[maybe_unused]] const auto step : state) benchmark::DoNotOptimize(network.predict(patch));
}
BENCHMARK_CAPTURE(estimate, dense, "dense")->Name("estimate/dense")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(estimate, heatmap2d, "heatmap2d")
    ->Name("estimate/heatmap2d")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(estimate, heatmap25d, "heatmap25d")
    ->Name("estimate/heatmap25d")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(estimate, regression, "regression")
    ->Name("estimate/regression")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(estimate, pca, "pca")->Name("estimate/pca")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(estimate, autoencoder, "autoencoder")
    ->Name("estimate/autoencoder")
    ->Unit(benchmark::kMillisecond);

/// One augmented view of a sample: the work of the loader's thread.
void augmented_view(benchmark::State& state) {
  const CubeSamples samples = testing::made_up_samples(1);
  const CubeViewer viewer(samples);
  const CubeSample sample = samples.sample(0);
  std::vector<float> pixels(static_cast<std::size_t>(testing::kTestCube.size_px) *
                            testing::kTestCube.size_px);
  Random random(1);
  for ([[maybe_unused]] const auto step : state) {
    const RandomView seen = random_view(sample, samples, {}, random);
    viewer.view_pixels(sample, seen.view, seen.faults, random, pixels);
    benchmark::DoNotOptimize(pixels.data());
  }
}
BENCHMARK(augmented_view)->Name("train/augmented_view/32")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace knuckle
