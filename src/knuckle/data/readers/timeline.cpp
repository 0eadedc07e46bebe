// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/timeline.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

constexpr std::string_view kTimesName = "times.txt";
constexpr std::string_view kSequencesName = "sequences.txt";

/// The first frame of each sequence.
std::vector<std::int64_t> read_sequences_file(const fs::path& path, std::int64_t count) {
  std::vector<std::int64_t> starts;
  visit_content_lines(path, [&](const FileLine& line) {
    const std::int64_t start = parse_integer(line.text, line.where());
    if (starts.empty() && start != 0) {
      fail("{}: the first sequence starts at frame {}, expected 0", line.where(), start);
    }
    if (!starts.empty() && start <= starts.back()) {
      fail("{}: frame {} is not after {}, where the sequence before starts", line.where(), start,
           starts.back());
    }
    if (start >= count) fail("{}: there is no frame {}: the set has {}", line.where(), start, count);
    starts.push_back(start);
  });
  if (starts.empty()) fail("{}: is empty, expected the first frame of each sequence", path.string());
  return starts;
}

std::vector<int> sequence_of_each_frame(const std::vector<std::int64_t>& starts, std::int64_t count) {
  std::vector<int> sequences(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const auto first = sequences.begin() + starts[i];
    std::fill(first, sequences.end(), static_cast<int>(i));
  }
  return sequences;
}

/// Sets the times and checks them. Lines beyond `count` are counted alone.
void read_times_file(const fs::path& path, std::int64_t count, Timeline& timeline) {
  std::int64_t found = 0;
  std::vector<std::size_t> numbers;  // of the lines
  visit_content_lines(path, [&](const FileLine& line) {
    if (++found > count) return;
    numbers.push_back(line.number);
    timeline.times_s.push_back(parse_number(line.text, line.where()));
  });
  if (found != count) fail("{}: has {} times, but there are {} depth images", path.string(), found, count);
  if (const auto fault = fault_of(timeline))
    fail("{}:{}: {}", path.string(), numbers[static_cast<std::size_t>(fault->frame)], fault->message);
}

void add_regular_times(double rate_hz, std::int64_t count, Timeline& timeline) {
  std::int64_t start = 0;
  for (std::int64_t frame = 0; frame < count; ++frame) {
    if (frame > 0 && timeline.sequence(frame) != timeline.sequence(frame - 1)) start = frame;
    timeline.times_s.push_back(static_cast<double>(frame - start) / rate_hz);
  }
}

}  // namespace

std::optional<double> Timeline::time_s(std::int64_t frame) const {
  if (times_s.empty()) return std::nullopt;
  return times_s.at(static_cast<std::size_t>(frame));
}

int Timeline::sequence(std::int64_t frame) const {
  return sequences.empty() ? 0 : sequences.at(static_cast<std::size_t>(frame));
}

std::optional<TimelineFault> fault_of(const Timeline& timeline) {
  const std::size_t count = std::max(timeline.times_s.size(), timeline.sequences.size());
  for (std::size_t i = 0; i < count; ++i) {
    const auto frame = static_cast<std::int64_t>(i);
    const int sequence = timeline.sequence(frame);
    const int before = i == 0 ? 0 : timeline.sequence(frame - 1);
    if (sequence < before) {
      return TimelineFault{frame, fmt::format("the sequence is {}, expected at least {}", sequence, before)};
    }
    if (timeline.times_s.empty()) continue;
    const double time = timeline.times_s[i];
    if (!std::isfinite(time))
      return TimelineFault{frame, fmt::format("the time is {}, expected seconds", time)};
    if (i > 0 && sequence == before && time < timeline.times_s[i - 1]) {
      return TimelineFault{
          frame,
          fmt::format(
              "the time goes back from {} to {} s; a time may only go back where a new sequence starts",
              timeline.times_s[i - 1], time)};
    }
  }
  return std::nullopt;
}

std::optional<double> regular_rate_hz(const Timeline& timeline) {
  constexpr double kTolerance = 1e-3;
  std::vector<double> intervals;
  for (std::size_t i = 1; i < timeline.times_s.size(); ++i) {
    const auto frame = static_cast<std::int64_t>(i);
    if (timeline.sequence(frame) == timeline.sequence(frame - 1))
      intervals.push_back(timeline.times_s[i] - timeline.times_s[i - 1]);
  }
  if (intervals.empty()) return std::nullopt;
  const auto [shortest, longest] = std::ranges::minmax(intervals);
  if (!(shortest > 0.0) || longest - shortest > kTolerance * shortest) return std::nullopt;
  constexpr double kMicro = 1e6;
  return std::round(kMicro * 2.0 / (shortest + longest)) / kMicro;
}

Timeline read_timeline(const fs::path& folder, std::int64_t count, double rate_hz) {
  Timeline timeline;
  if (const fs::path path = folder / kSequencesName; fs::exists(path))
    timeline.sequences = sequence_of_each_frame(read_sequences_file(path, count), count);
  if (const fs::path path = folder / kTimesName; fs::exists(path)) {
    read_times_file(path, count, timeline);
  } else if (rate_hz > 0.0) {
    add_regular_times(rate_hz, count, timeline);
  }
  return timeline;
}

void write_timeline(const fs::path& folder, const Timeline& timeline) {
  if (const auto fault = fault_of(timeline))
    fail("{}: frame {}: {}", folder.string(), fault->frame, fault->message);
  std::string times;
  for (const double time : timeline.times_s) times += fmt::format("{}\n", time);
  if (!times.empty()) write_text_file(folder / kTimesName, times);
  std::string starts = "0\n";
  for (std::size_t i = 1; i < timeline.sequences.size(); ++i) {
    if (timeline.sequences[i] != timeline.sequences[i - 1]) starts += fmt::format("{}\n", i);
  }
  if (starts != "0\n") write_text_file(folder / kSequencesName, starts);
}

}  // namespace knuckle
