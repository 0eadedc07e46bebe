// SPDX-License-Identifier: Apache-2.0
#include "knuckle/view/label_messages.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "knuckle/camera/projection.h"
#include "knuckle/core/statistics.h"
#include "knuckle/data/frame_record.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/view/message_parts.h"

namespace knuckle {
namespace {

HandRecord record_of_points(const std::vector<ImagePoint>& points, const Convention& convention,
                            const Projection& projection, HandSide side) {
  HandRecord record = hand_record({convention, points, {}}, projection, PixelOrigin::centre);
  record.id = side == HandSide::left ? 2 : 1;
  record.side = side;
  return record;
}

/// The labels as the page draws hands: what a person answers for is sure.
HandRecord record_of_labels(const LabelledHand& hand, const Convention& convention,
                            const Projection& projection) {
  constexpr double kEstimated = 0.45;
  constexpr double kHidden = 0.2;
  std::vector<ImagePoint> points;
  std::vector<double> confidence;
  for (const LandmarkLabel& label : hand.landmarks) {
    points.push_back(label.at);
    confidence.push_back(!label.is_visible ? kHidden : label.is_pinned() ? 1.0 : kEstimated);
  }
  HandRecord record = record_of_points(points, convention, projection, hand.side);
  record.score = 1.0;
  record.confidence = std::move(confidence);
  return record;
}

Json surface_of(const LabelledHand& hand, const Convention& convention, const Projection& projection) {
  if (!hand.fit) return Json::array();
  HandRecord record = record_of_points(hand.fit->points, convention, projection, hand.side);
  record.skeleton = adult_skeleton().name;
  return flesh_json(record);
}

Json number_or_null(double value) {
  return std::isfinite(value) ? Json(std::round(value * 100.0) / 100.0) : Json();
}

/// Width, height and runs in one list; null where there is none.
Json mask_json(const LabelledHand& hand) {
  if (!hand.mask) return {};
  Json json = Json::array({hand.mask->width, hand.mask->height});
  for (const std::int64_t run : hand.mask->runs) json.push_back(run);
  return json;
}

Json labels_json(const LabelledHand& hand, const Convention& convention) {
  Json landmarks = Json::object();
  for (std::size_t i = 0; i < hand.landmarks.size(); ++i) {
    const LandmarkLabel& label = hand.landmarks[i];
    Json& entry = landmarks[std::string(name_of(convention.landmarks[i]))];
    if (!label.at.is_missing())
      entry = {{"state", name_of(label.state)}, {"visible", label.is_visible}, {"since", label.since}};
  }
  return {{"side", hand.side == HandSide::left ? "left" : "right"},
          {"revision", hand.revision},
          {"state", name_of(hand.state)},
          {"seconds", number_or_null(hand.seconds)},
          {"author", hand.author},
          {"time", hand.time},
          {"rms_mm", number_or_null(hand.fit ? hand.fit->rms_mm : kNaN)},
          {"gap_mm", number_or_null(hand.fit ? hand.fit->gap_mm : kNaN)},
          {"mask", mask_json(hand)},
          {"landmarks", std::move(landmarks)}};
}

/// What is said of a frame beside its images, without the braces around.
std::string fields_of(const LabelledFrame& labelled, const Convention& convention) {
  FrameRecord record;
  record.frame = labelled.index;
  Json surface = Json::array();
  Json labels = Json::array();
  if (labelled.frame) {
    const Projection projection(labelled.frame->camera);
    record.name = labelled.frame->name;
    record.time_s = labelled.frame->time_s;
    for (const LabelledHand& hand : labelled.hands) {
      record.hands.push_back(record_of_labels(hand, convention, projection));
      surface.push_back(surface_of(hand, convention, projection));
      labels.push_back(labels_json(hand, convention));
    }
  }
  return fmt::format("\"record\":{},\"surface\":{},\"labels\":{}", to_json_line(record), text_of(surface),
                     text_of(labels));
}

}  // namespace

std::string label_info_message(const LabelInfo& info, const LabelHead& head) {
  return text_of({{"version", info.version},
                  {"source", info.source},
                  {"frames", head.frames},
                  {"camera", camera_json(head.camera)},
                  {"convention", head.convention.name},
                  {"landmarks", landmarks_json(head.convention)},
                  {"bones", bones_json(head.convention)},
                  {"file", info.file},
                  {"author", info.author},
                  {"pipeline", info.estimator}});
}

std::vector<std::uint8_t> labelled_frame_message(const LabelledFrame& labelled,
                                                 const Convention& convention) {
  return image_message(*labelled.frame, fields_of(labelled, convention));
}

std::string label_answer_message(const LabelAnswer& answer, const Convention& convention,
                                 const std::string& fault, std::size_t waiting) {
  const Json others = {{"refused", answer.is_refused},
                       {"remark", answer.remark},
                       {"fit_ms", number_or_null(answer.fit_ms)},
                       {"fault", fault},
                       {"waiting", waiting}};
  return fmt::format("{{{},{}", fields_of(answer.labelled, convention), text_of(others).substr(1));
}

std::string standings_message(const std::vector<FrameStanding>& standings,
                              const std::vector<double>& seconds) {
  constexpr std::string_view kLetters = "epcv";
  std::string states;
  Json doubts = Json::array();
  for (const FrameStanding& standing : standings) {
    states += standing.state ? kLetters[static_cast<std::size_t>(*standing.state)] : '-';
    doubts.push_back(number_or_null(standing.doubt_mm));
  }
  return text_of({{"states", states},
                  {"doubts", std::move(doubts)},
                  {"verified", seconds.size()},
                  {"median_s", number_or_null(median(seconds))}});
}

std::vector<std::uint8_t> thumbnail_message(const Frame& frame) {
  constexpr int kWidest = 96;
  const int step =
      std::max(1, (std::max(frame.depth_mm.width(), frame.depth_mm.height()) + kWidest - 1) / kWidest);
  Frame small;
  const int width = (frame.depth_mm.width() + step - 1) / step;
  const int height = (frame.depth_mm.height() + step - 1) / step;
  small.camera = frame.camera;
  small.camera.width = width;
  small.camera.height = height;
  small.depth_mm = Image<float>(width, height);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column)
      small.depth_mm(column, row) = frame.depth_mm(column * step, row * step);
  }
  return image_message(small, "\"record\":{\"frame\":0,\"hands\":[]}");
}

}  // namespace knuckle
