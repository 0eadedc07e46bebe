// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/sample_blocks.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/prepare/sample_file.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/work_claim.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

fs::path file_of(const fs::path& folder, std::int64_t block) {
  return folder / fmt::format("block_{:06}.h5", block);
}

fs::path index_of(const fs::path& folder) {
  return folder / "index.h5";
}

Inputs inputs_of(const Inputs& set, std::int64_t block) {
  Inputs inputs = set;
  inputs.add("block", fmt::format("{} of {} frames", block, SampleBlocks::kFrames));
  return inputs;
}

SampleBlockNote note_of(const NetworkSamples& block, const fs::path& file) {
  return {block.frames, block.samples.size() == 0 ? 0 : static_cast<std::int64_t>(fs::file_size(file)),
          known_joints(block.samples)};
}

/// Makes the blocks of a folder that are not there.
class BlockMaker {
 public:
  BlockMaker(const fs::path& folder, const SampleBlocks::Making& making)
      : folder_(folder),
        making_(making),
        cutter_(making.cutter()),
        progress_(making.what, "frames", cutter_->frames()) {}

  std::vector<SampleBlockNote> all() {
    std::vector<SampleBlockNote> notes;
    for (std::int64_t first = 0; first < cutter_->frames(); first += SampleBlocks::kFrames) {
      end_if_interrupted();
      notes.push_back(block(first, std::min(SampleBlocks::kFrames, cutter_->frames() - first)));
    }
    return notes;
  }

 private:
  SampleBlockNote block(std::int64_t first, std::int64_t count) {
    const std::int64_t number = first / SampleBlocks::kFrames;
    const fs::path file = file_of(folder_, number);
    const Inputs inputs = inputs_of(making_.inputs, number);
    if (fs::exists(file)) {
      progress_.advance(count);
      return note_of(read_samples(file, inputs), file);
    }
    const NetworkSamples made = cut_samples(*cutter_, first, count, making_.options, progress_);
    if (made.samples.size() > 0) write_samples(file, made, inputs);
    return note_of(made, file);
  }

  const fs::path& folder_;
  const SampleBlocks::Making& making_;
  std::unique_ptr<SampleCutter> cutter_;
  Progress progress_;
};

/// The size of a block's file; nothing where it is missing.
std::optional<std::int64_t> bytes_of(const fs::path& file) {
  std::error_code fault;
  const std::uintmax_t bytes = fs::file_size(file, fault);
  return fault ? std::nullopt : std::optional(static_cast<std::int64_t>(bytes));
}

/// Whether all blocks are there. Throws where one is not as it was.
bool are_there(const fs::path& folder, const std::vector<SampleBlockNote>& blocks) {
  for (std::int64_t i = 0; i < std::ssize(blocks); ++i) {
    const std::int64_t expected = blocks[static_cast<std::size_t>(i)].bytes;
    const fs::path file = file_of(folder, i);
    const std::optional<std::int64_t> bytes = expected == 0 ? 0 : bytes_of(file);
    if (!bytes) return false;
    if (*bytes != expected) {
      fail("{}: has {} bytes, expected {}: it is damaged; remove the file, and it is made anew",
           file.string(), *bytes, expected);
    }
  }
  return true;
}

std::vector<SampleBlockNote> made(const fs::path& folder, const SampleBlocks::Making& making) {
  std::error_code there_is_none;
  fs::remove(index_of(folder),
             there_is_none);  // a making that is killed leaves none that tells of other blocks
  std::vector<SampleBlockNote> notes = BlockMaker(folder, making).all();
  write_block_index(index_of(folder), notes, making.inputs);
  return notes;
}

/// What the index says, where it and all blocks are there.
std::optional<std::vector<SampleBlockNote>> whole(const fs::path& folder,
                                                  const SampleBlocks::Making& making) {
  if (!fs::exists(index_of(folder))) return std::nullopt;
  std::vector<SampleBlockNote> notes =
      read_block_index(index_of(folder), making.inputs, making.options.convention.size());
  return are_there(folder, notes) ? std::optional(std::move(notes)) : std::nullopt;
}

std::vector<SampleBlockNote> notes_of(const fs::path& folder, const SampleBlocks::Making& making) {
  if (auto notes = whole(folder, making)) return *std::move(notes);
  make_folder(folder);
  // Of several trainings of the same samples one makes the blocks.
  const WorkClaim claim(folder / "blocks.claim");
  if (auto notes = whole(folder, making)) return *std::move(notes);
  return made(folder, making);
}

}  // namespace

std::unique_ptr<SampleBlocks> SampleBlocks::opened(const fs::path& folder, const Making& making) {
  return std::unique_ptr<SampleBlocks>(new SampleBlocks(folder, making, notes_of(folder, making)));
}

SampleBlocks::SampleBlocks(fs::path folder, Making making, const std::vector<SampleBlockNote>& blocks)
    : folder_(std::move(folder)),
      inputs_(std::move(making.inputs)),
      options_(making.options),
      first_{0},
      known_(static_cast<std::size_t>(options_.convention.size()), false) {
  for (const SampleBlockNote& block : blocks) {
    frames_.add(block.frames);
    runs_.push_back(block.frames.used());
    first_.push_back(first_.back() + runs_.back());
    for (std::size_t j = 0; j < known_.size(); ++j) known_[j] = known_[j] || block.known[j];
  }
}

void SampleBlocks::fetch(std::span<const std::int64_t> numbers, CubeSamples& to, std::int64_t first) const {
  std::vector<std::int64_t> in_block;
  while (!numbers.empty()) {
    end_if_interrupted();
    const auto after = std::ranges::upper_bound(first_, numbers.front());
    const std::int64_t block = after - first_.begin() - 1;
    in_block.clear();
    for (const std::int64_t number : numbers) {
      if (number >= *after) break;
      in_block.push_back(number - *(after - 1));
    }
    const SampleFile file(file_of(folder_, block), inputs_of(inputs_, block));
    if (!file.has_sums() || file.size() != runs_[static_cast<std::size_t>(block)]) {
      fail("{}: is not the block that it was; remove it, and it is made anew",
           file_of(folder_, block).string());
    }
    file.read(in_block, to, first);
    first += std::ssize(in_block);
    numbers = numbers.subspan(in_block.size());
  }
}

}  // namespace knuckle
