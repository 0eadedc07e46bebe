// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/core/camera.h"
#include "knuckle/core/frame.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/core/pose.h"
#include "knuckle/label/label_mask.h"

namespace knuckle {

/// How a label came about; each is more to be trusted than those before it.
enum class LabelState : std::uint8_t {
  estimated,   ///< a pipeline found it, or the hand model laid it there
  propagated,  ///< it follows from verified frames beside it
  corrected,   ///< a person put it there
  verified,    ///< a person looked at the whole hand and found it right
};

/// "estimated", "propagated", "corrected" or "verified".
std::string_view name_of(LabelState state);

/// One landmark of one hand in one frame.
struct LandmarkLabel {
  ImagePoint at;  ///< in pixel-centre coordinates; missing where the landmark is not labelled
  LabelState state = LabelState::estimated;
  bool is_visible = true;  ///< whether its skin is seen, as a person or the estimator has it
  std::int64_t since = 0;  ///< revision of the hand in which it got this value; not in the file

  /// Whether a person answers for it: it stays where it is.
  bool is_pinned() const { return !at.is_missing() && state >= LabelState::corrected; }
  bool operator==(const LandmarkLabel& other) const;
};

/// What was done to a hand's labels.
enum class LabelAct : std::uint8_t {
  estimate,
  propagate,
  import,
  correct,
  look,
  verify,
  undo,
  redo,
  brush,  ///< its mask was painted, or laid over the fitted surface
};

/// "estimate", ..., "brush".
std::string_view name_of(LabelAct act);
/// Whether a person did it, so that it can be undone.
bool is_of_person(LabelAct act);
/// Whether the change says which mask the hand has, or that it has none; all others leave it as it is.
bool says_mask(LabelAct act);

/// The labels of one hand after a change: a line of labels.jsonl. The last line of a hand says how it stands.
struct LabelChange {
  std::int64_t frame = 0;           ///< index in the source
  HandSide side = HandSide::right;  ///< a frame has one hand of each side at most
  std::int64_t revision = 1;        ///< of this hand: 1 is the first
  LabelAct act = LabelAct::correct;
  std::string author = {};  ///< a person's name, or the pipeline's
  std::string time = {};    ///< of day, UTC, as in "2026-11-23T17:40:58Z"
  double seconds = 0.0;     ///< that the person had worked on this frame since the last change
  std::vector<LandmarkLabel> landmarks = {};   ///< one per landmark of the head's convention
  std::shared_ptr<const LabelMask> mask = {};  ///< the hand's pixels; null: nobody has painted them
  std::int64_t order = 0;  ///< among all changes of its book, the first is 1; not in the file
};

/// Whether any landmark is labelled.
bool has_landmarks(const LabelChange& change);
/// Whether the hand has labels: landmarks or a mask. What was taken back to its beginning has none.
bool is_labelled(const LabelChange& change);

/// What the labels belong to: the first line of labels.jsonl. Where there are more such lines, because the
/// source changed and a person went on nevertheless, the last one counts.
struct LabelHead {
  std::string source;       ///< as the person named it
  std::string fingerprint;  ///< what `source_fingerprint` says of it
  std::int64_t frames = 0;  ///< that the source has
  Convention convention;    ///< of all labels
  Camera camera;            ///< of the first frame
};

/// The lines, without their end. Positions have 0.0001 px and mm.
std::string to_json_line(const LabelHead& head);
/// Throws an Error where the number of landmarks is not the convention's.
std::string to_json_line(const LabelChange& change, const Convention& convention);

/// Whether a line is a head. Looks at its beginning only.
bool is_label_head(std::string_view line);
/// Read a line. Throw an Error that starts with `where` (as in "labels.jsonl:12") and names the key that is
/// missing, unknown or wrong: numbers that are not finite or out of range, frames that the source does not
/// have, landmarks that the convention does not have.
LabelHead parse_label_head(std::string_view line, std::string_view where = "label head");
LabelChange parse_label_change(std::string_view line, const LabelHead& head,
                               std::string_view where = "label change");  ///< See parse_label_head.

/// Whether `name` may stand in a file's name for an author: 1 to 64 letters, digits, '_', '-' and '.', not a
/// '.' first.
bool is_author_name(std::string_view name);

}  // namespace knuckle
