// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/sample_block_index.h"

#include <algorithm>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/storage/content_hash.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/hdf5/hdf5_file.h"
#include "knuckle/storage/hdf5/hdf5_writer.h"

namespace knuckle {
namespace {

constexpr std::string_view kIndexFormat = "knuckle-sample-index";
constexpr int kIndexVersion = 1;
constexpr std::uint64_t kCounts = 4;  // of a block: frames in all, without a hand, off centre; bytes

std::uint64_t sum_of(const std::vector<std::int64_t>& counts, const std::vector<std::uint8_t>& known) {
  return content_sum(std::as_bytes(std::span(known)), content_sum(std::as_bytes(std::span(counts)), 0));
}

bool is_plausible(const SampleBlockNote& block) {
  const auto& [total, without_hand, off_centre] = block.frames;
  const bool are_counts = without_hand >= 0 && off_centre >= 0 && total <= limits::kFrames &&
                          without_hand <= total && off_centre <= total - without_hand;
  return are_counts && block.bytes >= 0 && (block.bytes > 0) == (block.frames.used() > 0);
}

}  // namespace

void write_block_index(const std::filesystem::path& path, const std::vector<SampleBlockNote>& blocks,
                       const Inputs& inputs) {
  std::vector<std::int64_t> counts;
  std::vector<std::uint8_t> known;
  for (const SampleBlockNote& block : blocks) {
    const auto& [total, without_hand, off_centre] = block.frames;
    counts.insert(counts.end(), {total, without_hand, off_centre, block.bytes});
    known.insert(known.end(), block.known.begin(), block.known.end());
  }
  write_file_atomically(path, [&](const std::filesystem::path& temporary) {
    Hdf5Writer file = Hdf5Writer::create(temporary);
    file.set_attribute("format", kIndexFormat);
    file.set_attribute("version", double{kIndexVersion});
    file.set_attribute("inputs", text_hash(inputs.text()));
    file.write("counts", {blocks.size(), kCounts}, counts.data());
    file.write("known", {blocks.size(), blocks.front().known.size()}, known.data());
    const std::uint64_t sum = sum_of(counts, known);
    file.write("sum", {1}, &sum);
    file.close();
  });
}

std::vector<SampleBlockNote> read_block_index(const std::filesystem::path& path, const Inputs& inputs,
                                              int joint_count) {
  const Hdf5File file = Hdf5File::open(path);
  file.require_format(kIndexFormat, kIndexVersion);
  if (file.text_attribute("inputs") != text_hash(inputs.text()))
    fail("{}: is of samples of other sources or options", path.string());
  const auto counts = file.read<std::int64_t>("counts");
  const auto known = file.read<std::uint8_t>("known");
  const auto joints = static_cast<std::size_t>(joint_count);
  const bool fits =
      counts.shape.size() == 2 && counts.shape[0] > 0 && counts.shape[1] == kCounts &&
      known.shape == std::vector<std::uint64_t>{counts.shape[0], joints} &&
      file.read<std::uint64_t>("sum").values == std::vector{sum_of(counts.values, known.values)};
  std::vector<SampleBlockNote> blocks;
  for (std::size_t i = 0; fits && i < counts.shape[0]; ++i) {
    const std::int64_t* const of_block = counts.values.data() + i * kCounts;
    const auto first = known.values.begin() + static_cast<std::ptrdiff_t>(i * joints);
    blocks.push_back({{of_block[0], of_block[1], of_block[2]},
                      of_block[3],
                      std::vector<bool>(first, first + joint_count)});
  }
  if (!fits || !std::ranges::all_of(blocks, is_plausible))
    fail("{}: is damaged; remove the file, and it is made anew from the blocks beside it", path.string());
  return blocks;
}

}  // namespace knuckle
