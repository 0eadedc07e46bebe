// SPDX-License-Identifier: Apache-2.0
// How fast training's samples come where they are streamed: knuckle_stream_rate CONFIG CACHE BATCHES. CACHE
// may be "-": none.
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <ctime>
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

/// A line of /proc/self/status, as "RssAnon:".
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
  const auto is_space = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  while (!found.empty() && is_space(found.back())) found.pop_back();
  found.erase(0, found.find_first_not_of(" \t"));
  return found;
}

/// Processor time of this thread [s]: what a busy machine does not change.
double processor_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// What a sample costs that is fetched, and one that a view is made of, on this thread.
void measure_steps(BatchPlan plan, std::int64_t batches) {
  double fetching = 0.0;
  double making = 0.0;
  const std::int64_t at_once = plan.most_at_once();
  for (std::int64_t first = 0; first < batches; first += at_once) {
    const double begin = processor_seconds();
    const BatchSamples samples = plan.fetched(first, std::min(batches, first + at_once));
    const double fetched = processor_seconds();
    for (std::int64_t i = first; i < samples.end; ++i) (void)plan.batch(i, samples);
    fetching += fetched - begin;
    making += processor_seconds() - fetched;
  }
  const double micros = 1e6 / static_cast<double>(batches * plan.batch_size());
  fmt::print("processor time per sample: fetched {:.1f} us, a view made of it {:.1f} us\n", micros * fetching,
             micros * making);
}

void measure(const NetworkTrainingConfig& config, const std::filesystem::path& cache, std::int64_t batches) {
  const ConfiguredSamples samples = streamed_samples(config, cache);
  const PatchQuestions questions{.side = config.network.dense.tells_side,
                                 .hand = config.network.dense.tells_hand};
  const auto views = std::make_shared<const StreamedViews>(
      samples.streams, config.augmentation, questions, streaming_options(config, samples.validation.samples));
  const BatchPlan plan(views, config.training.batch_size, config.training.seed);
  measure_steps(plan, batches);
  BatchLoader loader(plan, 0, batches);
  const Stopwatch watch;
  for (std::int64_t i = 0; i < batches; ++i) (void)loader.next();
  fmt::print(
      "{} batches: {:.0f} samples/s; at most {} of {} samples in memory, {} of it this process's own\n",
      batches, static_cast<double>(batches * config.training.batch_size) / watch.seconds(),
      views->most_held(), views->size(), from_status("RssAnon:"));
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
