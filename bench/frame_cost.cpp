// SPDX-License-Identifier: Apache-2.0
// What reading and estimating frames take: knuckle_frame_cost PIPELINE SOURCE. python_cost.py compares.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "knuckle/pipeline/pipeline.h"
#include "knuckle/pipeline/stopwatch.h"
#include "knuckle/prepare/open_source.h"

namespace knuckle {
namespace {

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Prints the medians [ms] of reading a frame and of estimating it.
void measure(const std::string& pipeline_file, const std::string& source_text) {
  const Pipeline pipeline = Pipeline::load(pipeline_file);
  const auto source = open_source(source_text);
  std::vector<double> reading;
  std::vector<double> estimating;
  for (std::int64_t i = 0; i < source->size(); ++i) {
    const Stopwatch read;
    const Frame frame = source->read(i);
    reading.push_back(read.milliseconds());
    const Stopwatch estimate;
    (void)pipeline.estimate(frame);
    estimating.push_back(estimate.milliseconds());
  }
  fmt::print("{:.4f} {:.4f}\n", median(reading), median(estimating));
}

}  // namespace
}  // namespace knuckle

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: knuckle_frame_cost PIPELINE SOURCE\n", stderr);
    return 2;
  }
  try {
    knuckle::measure(argv[1], argv[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
