// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/selected_frames.h"

#include <algorithm>
#include <utility>

namespace knuckle {

void FrameSelection::visit(OptionVisitor& visitor) {
  visitor.integer("first", first, at_least(0));
  visitor.integer("count", count, at_least(1));
  visitor.integer("step", step, at_least(1));
}

SelectedFrames::SelectedFrames(std::unique_ptr<FrameSource> source, const FrameSelection& selection,
                               std::string_view where)
    : source_(std::move(source)), selection_(selection) {
  check_options(selection, where);
  const std::int64_t available = source_->size() - selection.first;
  if (available <= 0)
    fail("{}: first={} leaves no frame, the source has {}", where, selection.first, source_->size());
  size_ = std::min<std::int64_t>(selection.count, (available + selection.step - 1) / selection.step);
}

std::int64_t SelectedFrames::index_in_source(std::int64_t index) const {
  if (index < 0 || index >= size_) fail("frame {} is out of range: {} frames are selected", index, size_);
  return selection_.first + index * selection_.step;
}

Frame SelectedFrames::read(std::int64_t index) const {
  return source_->read(index_in_source(index));
}

FrameLabel SelectedFrames::read_label(std::int64_t index) const {
  return source_->read_label(index_in_source(index));
}

std::unique_ptr<FrameSource> select_frames(std::unique_ptr<FrameSource> source,
                                           const FrameSelection& selection, std::string_view where) {
  if (selection.takes_all()) return source;
  return std::make_unique<SelectedFrames>(std::move(source), selection, where);
}

}  // namespace knuckle
