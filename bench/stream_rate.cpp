// SPDX-License-Identifier: Apache-2.0
// How fast training's samples come where they are streamed: knuckle_stream_rate CONFIG CACHE BATCHES. CACHE
// may be "-": none.
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"
#include "knuckle/pipeline/stopwatch.h"
#include "knuckle/training/batch_loader.h"
#include "knuckle/training/configured_samples.h"

namespace knuckle {
namespace {

/// A line of /proc/self/status, as "VmHWM".
std::string from_status(const std::string& key) {
  std::FILE* const file = std::fopen("/proc/self/status", "r");
  if (file == nullptr) return "unknown";
  std::array<char, 256> line{};
  std::string found = "unknown";
  while (std::fgets(line.data(), line.size(), file) != nullptr) {
    const std::string text(line.data());
    if (text.starts_with(key)) found = text.substr(key.size() + 1);
  }
  std::fclose(file);
  while (!found.empty() && std::isspace(static_cast<unsigned char>(found.back())) != 0) found.pop_back();
  return found;
}

/// How long it takes to go through the batches [s].
double seconds_of(BatchLoader& loader, std::int64_t batches) {
  const Stopwatch watch;
  for (std::int64_t i = 0; i < batches; ++i) (void)loader.next();
  return watch.seconds();
}

void measure(const NetworkTrainingConfig& config, const std::filesystem::path& cache, std::int64_t batches) {
  const Stopwatch opening;
  const ConfiguredSamples samples = streamed_samples(config, cache);
  const StreamingOptions options = streaming_options(config, samples.validation.samples);
  fmt::print("opened in {:.1f} s; {} at once, memory {}\n", opening.seconds(), options.most_at_once,
             from_status("VmHWM:"));
  const auto views = std::make_shared<const StreamedViews>(
      samples.streams, config.augmentation,
      PatchQuestions{.side = config.network.dense.tells_side, .hand = config.network.dense.tells_hand},
      options);
  BatchPlan plan(views, config.training.batch_size, config.training.seed);
  const std::int64_t at_once = std::min(batches, plan.most_at_once());
  const Stopwatch fetching;
  const BatchSamples fetched = plan.fetched(0, at_once);
  const double seconds = fetching.seconds();
  const Stopwatch making;
  for (std::int64_t i = 0; i < at_once; ++i) (void)plan.batch(i, fetched);
  const double made = making.seconds();
  const auto count = static_cast<double>(at_once * config.training.batch_size);
  fmt::print("{:.0f} samples: fetched at {:.0f} samples/s, made into views at {:.0f}\n", count,
             count / seconds, count / made);
  BatchLoader loader(BatchPlan(views, config.training.batch_size, config.training.seed), 0, batches);
  const double all = seconds_of(loader, batches);
  fmt::print("{} batches: {:.0f} samples/s; at most {} samples held of {}, memory {}\n", batches,
             static_cast<double>(batches * config.training.batch_size) / all, views->most_held(),
             views->size(), from_status("VmHWM:"));
}

}  // namespace
}  // namespace knuckle

int main(int count, char** arguments) {
  try {
    const std::vector<std::string> words(arguments, arguments + count);
    if (count != 4) knuckle::fail("usage: knuckle_stream_rate CONFIG CACHE BATCHES");
    const std::string cache = words[2] == "-" ? "" : words[2];
    knuckle::measure(knuckle::NetworkTrainingConfig::load(words[1]), cache,
                     knuckle::parse_integer(words[3], "BATCHES"));
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "knuckle_stream_rate: {}\n", error.what());
    return 1;
  }
}
