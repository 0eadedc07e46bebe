// SPDX-License-Identifier: Apache-2.0
// What labelling reads: the file of labels, and what the page sends.
#include "fuzz_target.h"

#include <stdexcept>
#include <string>

#include "knuckle/label/label_book.h"
#include "knuckle/label/label_request.h"

namespace knuckle::fuzz {

/// A labels.jsonl. What is read is written as lines that are read as the same.
void run_labels(Bytes bytes) {
  const auto read = read_labels(as_text(bytes), "labels.jsonl");
  if (!read) return;
  const LabelHead& head = read->book.head();
  for (const auto& [hand, history] : read->book.hands()) {
    for (const LabelChange& change : history.changes) {
      const std::string line = to_json_line(change, head.convention);
      if (to_json_line(parse_label_change(line, head), head.convention) != line)
        throw std::logic_error("a change is not read as it was written");
    }
  }
  (void)read->book.undone();
  (void)read->book.redone();
}

/// A message of the page.
void run_label_request(Bytes bytes) {
  LabelHead head;
  head.frames = 20;
  head.convention = superset_convention();
  const LabelRequest request = parse_label_request(as_text(bytes), head);
  const bool is_in_place = request.hand.frame >= 0 && request.hand.frame < head.frames &&
                           request.landmark < head.convention.landmarks.size();
  if (!is_in_place || !request.point_mm.allFinite()) throw std::logic_error("nonsense is let through");
}

}  // namespace knuckle::fuzz
