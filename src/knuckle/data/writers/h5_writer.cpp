// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/writers/h5_writer.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "knuckle/core/error.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

fs::path with_suffix(fs::path path, std::string_view suffix) {
  path += suffix;
  return path;
}

/// All that the frames of a run depend on.
std::string identity_of(const FrameWriterOptions& options) {
  const std::string whole =
      options.part_of ? fmt::format("part of {} from {} on\n", options.part_of->count, options.part_of->first)
                      : "";
  return fmt::format("with hands, labels and sums\n{}first {}\ncount {}\ndepth_unit_mm {}\nby {}\n{}", whole,
                     options.first, options.count, options.depth_unit_mm, options.generator,
                     options.manifest);
}

}  // namespace

H5Writer::H5Writer(fs::path path, const FrameWriterOptions& options)
    : path_(std::move(path)),
      options_(options),
      ledger_(path_.string(), options, FrameCameras::of_one_size),
      log_(with_suffix(path_, ".partial"), identity_of(options)) {
  restore();
}

void H5Writer::restore() {
  const std::vector<std::int64_t> indices = log_.indices();
  if (indices.empty()) return;
  const StoredFrame frame = logged(indices.front());
  ledger_.restore({frame.camera, !frame.infrared.empty(), !frame.mask.empty(), !frame.labels.empty(),
                   !std::isnan(frame.time_s)},
                  indices);
}

/// The frame as it stands in the log.
StoredFrame H5Writer::logged(std::int64_t index) const {
  return stored_frame_from(log_.read(index), fmt::format("{}.partial: frame {}", path_.string(), index));
}

/// Of the frames of the set.
std::int64_t H5Writer::count() const {
  return options_.count > 0 ? options_.count : ledger_.size();
}

void H5Writer::write(std::int64_t index, const Frame& frame) {
  ledger_.enter(index, frame);
  const std::string where = fmt::format("{}: frame {}", path_.string(), index);
  log_.append(index, to_bytes(stored_frame(frame, options_.depth_unit_mm, where)));
  ledger_.note_written(index);
}

H5Facts H5Writer::facts() const {
  const FrameLayout layout = *ledger_.layout();
  H5Facts facts;
  facts.frames = {options_.first, count()};
  facts.part_of = options_.part_of;
  facts.manifest = options_.manifest;
  facts.generator = options_.generator;
  facts.depth_unit_mm = options_.depth_unit_mm;
  facts.camera = logged(options_.first).camera;
  facts.has_infrared = layout.has_infrared;
  facts.has_mask = layout.has_mask;
  facts.has_labels = layout.has_labels;
  facts.has_time = layout.has_time;
  return facts;
}

void H5Writer::finish() {
  ledger_.require_complete();
  for (std::int64_t i = 0; i < count(); ++i) {
    if (!has(options_.first + i)) fail("{}: frame {} was not written", path_.string(), options_.first + i);
  }
  assemble_h5(path_, facts(), [&](std::int64_t index) { return logged(index); });
  log_.remove();
}

}  // namespace knuckle
