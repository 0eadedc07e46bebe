// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/holdout.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/random.h"

namespace knuckle {
namespace {

constexpr std::uint64_t kOrderSeed = 0x686f6c64;  // of no training: the parts are the same for all

std::vector<int> sequences_of(const FrameSource& source) {
  std::vector<int> sequences(static_cast<std::size_t>(source.size()));
  parallel_for(source.size(), [&](std::int64_t i) {
    sequences[static_cast<std::size_t>(i)] = source.read_label(i).sequence;
  });
  return sequences;
}

struct Sequence {
  int id = 0;
  std::int64_t frames = 0;
};

/// In a random order, which hangs on their number alone.
std::vector<Sequence> in_random_order(const std::vector<int>& sequence_of_frame) {
  std::map<int, std::int64_t> frames;
  for (const int sequence : sequence_of_frame) ++frames[sequence];
  std::vector<Sequence> sequences;
  sequences.reserve(frames.size());
  for (const auto& [id, count] : frames) sequences.push_back({id, count});
  Random random(kOrderSeed);
  for (std::size_t i = sequences.size(); i > 1; --i) {
    std::swap(sequences[i - 1], sequences[random.below(static_cast<std::uint32_t>(i))]);
  }
  return sequences;
}

std::set<int> held_out(const std::vector<Sequence>& sequences, double wanted_frames) {
  std::set<int> ids;
  double frames = 0.0;
  for (const Sequence& sequence : sequences) {
    const double more = frames + static_cast<double>(sequence.frames);
    const bool is_nearer = std::abs(more - wanted_frames) < std::abs(frames - wanted_frames);
    if (!is_nearer || ids.size() + 1 == sequences.size()) continue;
    ids.insert(sequence.id);
    frames = more;
  }
  if (ids.empty()) ids.insert(std::ranges::min_element(sequences, {}, &Sequence::frames)->id);
  return ids;
}

}  // namespace

std::vector<std::int64_t> frames_of_part(const FrameSource& source, const Holdout& holdout,
                                         std::string_view name) {
  if (holdout.share <= 0.0) {
    std::vector<std::int64_t> all(static_cast<std::size_t>(source.size()));
    std::iota(all.begin(), all.end(), std::int64_t{0});
    return all;
  }
  const std::vector<int> sequence_of_frame = sequences_of(source);
  const std::vector<Sequence> sequences = in_random_order(sequence_of_frame);
  if (sequences.size() < 2) {
    fail(
        "{}: all its frames are one sequence, so none can be held out for validation: say where sequences "
        "start (a folder's sequences.txt), or name other frames as 'validation'",
        name);
  }
  const std::set<int> ids = held_out(sequences, holdout.share * static_cast<double>(source.size()));
  std::vector<std::int64_t> frames;
  for (std::int64_t i = 0; i < source.size(); ++i) {
    const bool is_held_out = ids.contains(sequence_of_frame[static_cast<std::size_t>(i)]);
    if (is_held_out == (holdout.part == Holdout::Part::validation)) frames.push_back(i);
  }
  return frames;
}

}  // namespace knuckle
