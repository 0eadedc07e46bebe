// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "knuckle/camera/projection.h"
#include "knuckle/core/camera.h"
#include "knuckle/core/frame.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/core/pose.h"

namespace knuckle {

/// A place in an image [px]; both NaN where it is not known.
struct PixelPoint {
  double u = kNaN;  ///< column
  double v = kNaN;  ///< row
};

/// One hand of a frame record. What is not known is NaN, and `null` in JSON.
struct HandRecord {
  int id = 1;                            ///< of a tracked hand; without a tracker its rank in the frame, >= 1
  std::optional<HandSide> side;          ///< nothing where it is not known
  double score = kNaN;                   ///< how sure the hand is, [0, 1]
  Convention convention;                 ///< names and order of the landmarks
  std::vector<Point3> landmarks_mm;      ///< one per landmark, camera coordinates [mm]
  std::vector<PixelPoint> landmarks_px;  ///< one per landmark, in the source's pixel origin [px]
  std::vector<double> confidence;        ///< one per landmark, [0, 1]; empty where the method gives none
  /// Name and value of each joint angle [rad], in the order of HandAngle; empty where no hand model was
  /// fitted.
  std::vector<std::pair<std::string, double>> angles_rad;
  std::string skeleton;  ///< name of the fitted hand model; empty where there is none
};

/// What is found in one frame: a line of `--records`, a message to the page, a line of `live`.
struct FrameRecord {
  std::int64_t frame = 0;        ///< index in its source, >= 0
  std::string name;              ///< as Frame::name
  std::optional<double> time_s;  ///< as Frame::time_s
  std::string status;  ///< why there is no hand, or what is to be known of it; empty where all is well
  std::vector<HandRecord> hands;     ///< surest first
  std::optional<double> latency_ms;  ///< `live` only: from the frame's arrival to the record [ms]
};

/// A pose as the landmarks of a record. `projection` is of the frame's camera; `origin` is where the source's
/// pixel coordinates start. Id, side, score and angles are the caller's matter.
HandRecord hand_record(const HandPose& pose, const Projection& projection, PixelOrigin origin);

/// The record as one line of JSON (schemas/frame_record.json) without an end of line. The same record has the
/// same bytes: keys in one order; times to 1 us, mm and px to 0.001, latencies to 0.001 ms, score and
/// confidences to 0.0001, angles to 0.00001 rad. A landmark of which any coordinate is not finite is `null`,
/// and so is any other number that is not. Texts that are not UTF-8 have U+FFFD where they are not. Throws an
/// Error where the number of landmarks or confidences is not the convention's.
std::string to_json_line(const FrameRecord& record);

/// The record that such a line holds; keys may come in any order, landmarks in that of
/// their convention. Throws an Error that starts with `where` (as in
/// "records.jsonl:12") and names the key that is missing, unknown or wrong, or the landmarks that are those
/// of no convention.
FrameRecord parse_frame_record(std::string_view line, std::string_view where = "frame record");

}  // namespace knuckle
