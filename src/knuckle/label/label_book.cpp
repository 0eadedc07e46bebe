// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_book.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

bool is_pinned_anywhere(const LabelChange& change) {
  return std::ranges::any_of(change.landmarks, &LandmarkLabel::is_pinned);
}

/// Notes for each landmark since when it is as it is.
void note_ages(LabelChange& change, const LabelChange* before) {
  for (std::size_t i = 0; i < change.landmarks.size(); ++i) {
    const bool is_same = before != nullptr && before->landmarks[i] == change.landmarks[i];
    change.landmarks[i].since = is_same ? before->landmarks[i].since : change.revision;
  }
}

/// As std::stod reads what `{:.4f}` writes.
double in_file(double value) {
  constexpr double kPerUnit = 1e4;
  return std::round(value * kPerUnit) / kPerUnit;
}

}  // namespace

const LabelChange* HandHistory::estimate() const {
  const auto found = std::ranges::find_if_not(changes.rbegin(), changes.rend(), is_pinned_anywhere);
  return found == changes.rend() ? nullptr : &*found;
}

LabelState HandHistory::state() const {
  if (newest().mask && !has_landmarks(newest()))
    return newest().act == LabelAct::verify ? LabelState::verified : LabelState::corrected;
  LabelState least = LabelState::verified;
  LabelState most = LabelState::estimated;
  for (const LandmarkLabel& label : newest().landmarks) {
    if (label.at.is_missing()) continue;
    least = std::min(least, label.state);
    most = std::max(most, label.state);
  }
  if (most < LabelState::corrected) return most;
  return least == LabelState::verified ? LabelState::verified : LabelState::corrected;
}

double HandHistory::seconds() const {
  double sum = 0.0;
  for (const LabelChange& change : changes) sum += change.seconds;
  return sum;
}

std::int64_t HandHistory::last(LabelAct act) const {
  const auto found = std::ranges::find(changes.rbegin(), changes.rend(), act, &LabelChange::act);
  return found == changes.rend() ? 0 : found->order;
}

bool HandHistory::follows() const {
  const auto is_stroke = [](const LabelChange& change) { return change.act == LabelAct::brush; };
  const auto found = std::ranges::find_if_not(changes.rbegin(), changes.rend(), is_stroke);
  return found != changes.rend() && found->act == LabelAct::propagate;
}

void LabelBook::take_head(LabelHead head, std::string_view where) {
  if (head.frames != head_.frames || !(head.convention == head_.convention)) {
    fail("{}: another number of frames or convention than in the first line; labels of one source only",
         where);
  }
  head_ = std::move(head);
}

void LabelBook::add(LabelChange change, std::string_view where) {
  const HandKey key{change.frame, change.side};
  const HandHistory* const before = find(key);
  const std::int64_t next = before == nullptr ? 1 : before->revision() + 1;
  if (change.revision != next) {
    fail("{}: revision {} of the {} hand of frame {}, expected {}", where, change.revision,
         change.side == HandSide::left ? "left" : "right", change.frame, next);
  }
  if (change.landmarks.size() != head_.convention.landmarks.size())
    fail("{}: {} landmarks, expected {}", where, change.landmarks.size(), head_.convention.size());
  if (before != nullptr && !says_mask(change.act)) change.mask = before->newest().mask;
  note_ages(change, before == nullptr ? nullptr : &before->newest());
  note_step(change, where);
  change.order = ++changes_;
  hands_[key].changes.push_back(std::move(change));
}

void LabelBook::note_step(const LabelChange& change, std::string_view where) {
  const HandKey hand{change.frame, change.side};
  if (is_of_person(change.act)) {
    done_.push_back({hand, change.revision - 1, change.revision});
    undone_.clear();
    return;
  }
  if (change.act != LabelAct::undo && change.act != LabelAct::redo) return;
  auto& from = change.act == LabelAct::undo ? done_ : undone_;
  auto& to = change.act == LabelAct::undo ? undone_ : done_;
  if (from.empty() || from.back().hand != hand)
    fail("{}: '{}' of something that was not done last", where, name_of(change.act));
  to.push_back(from.back());
  from.pop_back();
}

const HandHistory* LabelBook::find(HandKey hand) const {
  const auto found = hands_.find(hand);
  return found == hands_.end() ? nullptr : &found->second;
}

std::optional<LabelChange> LabelBook::undone() const {
  if (done_.empty()) return std::nullopt;
  return back_to(done_.back().hand, done_.back().before, LabelAct::undo);
}

std::optional<LabelChange> LabelBook::redone() const {
  if (undone_.empty()) return std::nullopt;
  return back_to(undone_.back().hand, undone_.back().after, LabelAct::redo);
}

/// Revision 0 is the hand without labels.
LabelChange LabelBook::back_to(HandKey hand, std::int64_t revision, LabelAct act) const {
  const HandHistory& history = hands_.at(hand);
  LabelChange change{.frame = hand.frame, .side = hand.side, .revision = history.revision() + 1, .act = act};
  change.landmarks.resize(head_.convention.landmarks.size());
  if (revision == 0) return change;
  const LabelChange& then = history.changes[static_cast<std::size_t>(revision - 1)];
  change.landmarks = then.landmarks;
  change.mask = then.mask;
  return change;
}

LabelChange rounded(LabelChange change) {
  for (LandmarkLabel& label : change.landmarks) {
    if (label.at.is_missing()) {
      label = {};
      continue;
    }
    label.at = {in_file(label.at.u), in_file(label.at.v), in_file(label.at.depth_mm)};
  }
  return change;
}

std::optional<ReadLabels> read_labels(std::string_view text, std::string_view name) {
  std::optional<ReadLabels> read;
  std::size_t begin = 0;
  int number = 0;
  for (std::size_t end = text.find('\n'); end != std::string_view::npos; end = text.find('\n', begin)) {
    const std::string_view line = text.substr(begin, end - begin);
    const std::string where = fmt::format("{}:{}", name, ++number);
    begin = end + 1;
    if (!read) {
      read = ReadLabels{LabelBook(parse_label_head(line, where))};
    } else if (is_label_head(line)) {
      read->book.take_head(parse_label_head(line, where), where);
    } else {
      read->book.add(parse_label_change(line, read->book.head(), where), where);
    }
    read->whole_bytes = begin;
  }
  return read;
}

}  // namespace knuckle
