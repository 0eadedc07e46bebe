// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "knuckle/label/label_book.h"
#include "knuckle/label/mask_brush.h"

namespace knuckle {

/// What a person asks for: one message of the page.
struct LabelRequest {
  enum class Kind : std::uint8_t {
    place,   ///< a landmark onto a pixel
    move,    ///< a landmark to a point in space
    look,    ///< say whether a landmark is visible
    free,    ///< let a landmark follow the model again
    verify,  ///< all of the hand is right
    undo,    ///< the last change, whatever the hand
    redo,
    brush,    ///< paint the hand's mask
    outline,  ///< begin the mask with what was measured on the fitted hand model
  };

  Kind kind = Kind::verify;
  HandKey hand;               ///< which one; undo and redo need none
  std::int64_t revision = 0;  ///< of the hand as the person saw it; 0: there were no labels
  std::size_t landmark = 0;   ///< index into the convention
  double u = 0.0;             ///< place: pixel-centre coordinates [px]
  double v = 0.0;
  Point3 point_mm = Point3::Zero();  ///< move: in camera coordinates [mm]
  bool is_visible = true;            ///< look
  BrushStroke stroke = {};           ///< brush
  bool is_preview = false;           ///< say what it would do, and keep nothing
  bool uses_model = true;            ///< the hand model moves the other landmarks
  double seconds = 0.0;              ///< the person has worked on the frame since the last change
};

/// The most bytes that a request has.
inline constexpr std::size_t kMostRequestBytes = 8192;

/// Reads a message of the page, for labels of that head:
///
///     {"act":"place","frame":12,"side":"right","revision":3,"landmark":"index_tip","pixel":[120.5,88]}
///
/// "move" has "point_mm": [x, y, z] in place of "pixel", "look" has "visible"; "verify", "undo" and "redo"
/// have neither. "brush" has "points": [[u, v], ...], "radius_px" and "erases", "outline" nothing, and both
/// no landmark. "preview", "model" and "seconds" may stand in all. Throws an Error of one line where the
/// text is anything else: too long, no JSON, unknown, missing or wrong keys, a frame or a landmark that there
/// is not, numbers that are not finite or out of range.
LabelRequest parse_label_request(std::string_view json, const LabelHead& head);

}  // namespace knuckle
