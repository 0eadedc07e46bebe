// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <set>
#include <utility>

#include "knuckle/label/label_book.h"

namespace knuckle {

/// Hands that were labelled in an earlier session, and that nothing was fitted to in this one yet. A value.
class EarlierHands {
 public:
  /// All hands of a book that have landmarks.
  explicit EarlierHands(const LabelBook& book);

  /// Takes the next one out: verified ones first, since others follow them, in the order of frames. Nothing
  /// where none is left.
  std::optional<HandKey> take();
  /// Takes this one out. Whether it was among them.
  bool take(HandKey hand);

 private:
  std::set<std::pair<bool, HandKey>> hands_;  ///< with whether it is still to be verified
};

}  // namespace knuckle
