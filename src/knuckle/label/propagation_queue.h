// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>
#include <set>

#include "knuckle/label/label_book.h"

namespace knuckle {

/// Hands that wait to follow a verified one. A value.
class PropagationQueue {
 public:
  /// `reach`: frames to both sides that a verified one pulls, at least 0.
  explicit PropagationQueue(int reach) : reach_(reach) {}

  /// Puts the hands of the same side around a verified one at the end, the nearest first: they follow most
  /// surely. On each side as far as the next verified one; those that a person has touched stay as they are.
  void add_neighbours(HandKey verified, const LabelBook& book);
  /// Puts in what waited when an earlier session ended: the hands around each verified one that have not
  /// followed since. One that was looked at and hardly moved has left no line: it is looked at again.
  void add_interrupted(const LabelBook& book);
  /// Takes the first one out; nothing where none waits.
  std::optional<HandKey> take();

 private:
  void add_neighbours(HandKey verified, const LabelBook& book, std::int64_t since);

  int reach_;
  std::deque<HandKey> hands_;
  std::set<HandKey> waiting_;  ///< the same hands
};

}  // namespace knuckle
