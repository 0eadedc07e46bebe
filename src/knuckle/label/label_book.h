// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "knuckle/label/label_change.h"

namespace knuckle {

/// A hand of a source: at most one of each side per frame.
struct HandKey {
  std::int64_t frame = 0;
  HandSide side = HandSide::right;

  bool operator==(const HandKey&) const = default;
  bool operator<(const HandKey& other) const {
    return std::tie(frame, side) < std::tie(other.frame, other.side);
  }
};

/// The changes of one hand, in order; never empty.
struct HandHistory {
  std::vector<LabelChange> changes;  ///< that of revision r is changes[r - 1]

  const LabelChange& newest() const { return changes.back(); }
  std::int64_t revision() const { return newest().revision; }
  /// What machines made of it last: the newest change without a pinned landmark, or null.
  const LabelChange* estimate() const;
  /// The best state that all labelled landmarks have reached: verified once a person has verified the hand;
  /// else corrected where any landmark is; else that of its landmarks. Of a hand that has a mask alone:
  /// verified where that is the last that was done, else corrected.
  LabelState state() const;
  /// That persons have worked on it.
  double seconds() const;
  /// `LabelChange::order` of the last change of a kind; 0 where there is none.
  std::int64_t last(LabelAct act) const;
  /// Whether its landmarks stand as they followed from verified neighbours.
  bool follows() const;
};

/// All labels of one author with their history: what labels.jsonl says, in memory. A value; not safe to
/// change from several threads at once.
class LabelBook {
 public:
  explicit LabelBook(LabelHead head) : head_(std::move(head)) {}

  const LabelHead& head() const { return head_; }
  /// Takes a head that stands further down in a file. Throws an Error where the convention or the number of
  /// frames is another one.
  void take_head(LabelHead head, std::string_view where);

  /// Adds a change. Throws an Error that starts with `where` where its revision is not the hand's next, or
  /// there is nothing to undo or redo.
  void add(LabelChange change, std::string_view where = "label change");

  /// Null where nothing is labelled.
  const HandHistory* find(HandKey hand) const;
  const std::map<HandKey, HandHistory>& hands() const { return hands_; }

  /// The change that would undo the last one that a person made, whatever the hand, and that has not been
  /// undone; its time is the caller's. Nothing where there is none.
  std::optional<LabelChange> undone() const;
  /// The change that would take the last undoing back.
  std::optional<LabelChange> redone() const;

 private:
  /// What a person did to a hand: between these revisions.
  struct Step {
    HandKey hand;
    std::int64_t before;
    std::int64_t after;
  };

  void note_step(const LabelChange& change, std::string_view where);
  LabelChange back_to(HandKey hand, std::int64_t revision, LabelAct act) const;

  LabelHead head_;
  std::map<HandKey, HandHistory> hands_;
  std::int64_t changes_ = 0;  ///< of all hands
  std::vector<Step> done_;
  std::vector<Step> undone_;
};

/// The change with all coordinates as a file holds them, to 0.0001 px and mm.
LabelChange rounded(LabelChange change);

/// What the lines of a labels.jsonl say. What stands after the last line's end was cut short by a kill, and
/// is left out: `whole_bytes` says how long the file is without it.
struct ReadLabels {
  LabelBook book;
  std::size_t whole_bytes = 0;
};

/// Reads the text of a labels.jsonl. Nothing where it has not one whole line: a file that was just begun.
/// Throws an Error that starts with `name` and the line's number where a line is wrong.
std::optional<ReadLabels> read_labels(std::string_view text, std::string_view name);

}  // namespace knuckle
