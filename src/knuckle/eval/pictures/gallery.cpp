// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/pictures/gallery.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "knuckle/camera/projection.h"
#include "knuckle/core/parallel.h"
#include "knuckle/data/fitted_flesh.h"
#include "knuckle/eval/metrics/segmentation_metrics.h"
#include "knuckle/eval/pictures/drawing.h"
#include "knuckle/eval/pictures/surface_picture.h"

namespace knuckle {
namespace {

/// A frame that the gallery shows, and why.
struct Choice {
  std::int64_t frame;
  std::string reason;
};

/// The middles of `count` equal parts of the sequence.
std::vector<Choice> evenly_spread(std::int64_t frames, int count) {
  std::vector<Choice> choices;
  const std::int64_t shown = std::min<std::int64_t>(frames, count);
  for (std::int64_t i = 0; i < shown; ++i) choices.push_back({(2 * i + 1) * frames / (2 * shown), ""});
  return choices;
}

/// Frames by falling error; missing predictions are the worst of all.
std::vector<Choice> worst_of(const MethodScore& method, int count) {
  std::vector<std::int64_t> order;
  for (std::int64_t i = 0; i < method.frames; ++i) {
    if (!std::isnan(method.frame_mean_3d_mm[i])) order.push_back(i);
  }
  std::ranges::stable_sort(order, std::ranges::greater{},
                           [&](std::int64_t i) { return method.frame_mean_3d_mm[i]; });
  order.resize(std::min<std::size_t>(order.size(), static_cast<std::size_t>(count)));
  std::vector<Choice> choices;
  for (const std::int64_t frame : order) choices.push_back({frame, "worst of " + method.name});
  return choices;
}

std::vector<Choice> chosen_frames(const GalleryInput& input, const GalleryOptions& options) {
  std::vector<Choice> choices = evenly_spread(frames_to_show(input), options.even_frames);
  if (input.evaluation == nullptr) return choices;
  for (const MethodScore& method : input.evaluation->methods) {
    for (Choice& choice : worst_of(method, options.worst_frames)) {
      const auto shown = std::ranges::find(choices, choice.frame, &Choice::frame);
      if (shown == choices.end()) {
        choices.push_back(std::move(choice));
      } else {
        shown->reason += (shown->reason.empty() ? "" : ", ") + choice.reason;
      }
    }
  }
  return choices;
}

/// Smallest rectangle around both.
Rectangle united(const Rectangle& a, const Rectangle& b) {
  return {std::min(a.left, b.left), std::min(a.top, b.top), std::max(a.right, b.right),
          std::max(a.bottom, b.bottom)};
}

/// The hand's landmarks in the image; missing where they are not known.
HandPose pose_of(const HandRecord& hand, const Projection& projection) {
  HandPose pose = HandPose::missing(hand.convention);
  for (std::size_t i = 0; i < hand.landmarks_mm.size(); ++i) {
    if (hand.landmarks_mm[i].allFinite()) pose.joints[i] = projection.to_image(hand.landmarks_mm[i]);
  }
  return pose;
}

/// What a method's records tell of a frame.
struct RecordedHands {
  std::vector<HandPose> poses;     ///< of all its hands
  std::vector<FleshCone> flesh;    ///< of those that a hand model was fitted to
  std::vector<HandPose> unfitted;  ///< of the others
};

/// Nothing where the frame has no image, and so no camera.
RecordedHands recorded_hands(const FrameRecord& record, const Frame& frame) {
  RecordedHands recorded;
  if (frame.depth_mm.empty()) return recorded;
  const Projection projection(frame.camera);
  for (const HandRecord& hand : record.hands) {
    recorded.poses.push_back(pose_of(hand, projection));
    const std::vector<FleshCone> flesh = fitted_flesh(hand);
    recorded.flesh.insert(recorded.flesh.end(), flesh.begin(), flesh.end());
    if (flesh.empty()) recorded.unfitted.push_back(recorded.poses.back());
  }
  return recorded;
}

/// One frame with all poses that are drawn into it.
class FramePictures {
 public:
  FramePictures(const GalleryInput& input, const GalleryOptions& options, std::int64_t index)
      : input_(input), options_(options), index_(index) {
    if (input.source != nullptr) frame_ = input.source->read(index);
    if (input.truth != nullptr) {
      truth_ = &input.truth->sequence.poses[index];
    } else if (frame_.truth) {
      truth_ = &*frame_.truth;
    }
    for (const Predictions& method : input.methods) estimates_.push_back(&method.sequence.poses[index]);
    for (const NamedRecords& method : input.records) {
      recorded_.push_back(recorded_hands(method.frames[static_cast<std::size_t>(index)], frame_));
    }
    for (const RecordedHands& recorded : recorded_) {
      for (const HandPose& pose : recorded.poses) estimates_.push_back(&pose);
    }
  }

  GalleryRow row(const std::string& reason) const {
    GalleryRow row;
    row.caption = fmt::format("Frame {}", index_);
    if (!frame_.name.empty()) row.caption += fmt::format(" ({})", frame_.name);
    if (!reason.empty()) row.caption += ": " + reason;
    row.shows_truth = truth_ != nullptr && !truth_->is_missing();
    const View view = hand_view();
    if (!row.shows_truth && !frame_.depth_mm.empty()) row.pictures.push_back(overview(view.crop));
    const DepthRange depths = hand_depths(view);
    const Image<Rgb> ground = picture_of(frame_.depth_mm, view, depths);
    for (std::size_t method = 0; method < input_.methods.size(); ++method) {
      row.pictures.push_back(method_picture(ground, view, method));
    }
    if (input_.methods.empty() && (input_.records.empty() || row.shows_truth))
      row.pictures.push_back(truth_picture(ground, view));
    for (std::size_t method = 0; method < recorded_.size(); ++method) {
      row.pictures.push_back(surface_picture(ground, view, method));
      if (recorded_[method].flesh.empty()) continue;
      row.pictures.push_back(difference_picture(view, depths, method));
      row.shows_difference = true;
    }
    return row;
  }

 private:
  const HandPose& predicted(std::size_t method) const {
    return input_.methods[method].sequence.poses[index_];
  }

  /// Around the true joints, or else around all estimated ones; estimates that are not far off widen it.
  std::optional<Rectangle> hand_rectangle() const {
    constexpr double kLargestGrowth =
        2.0;  // of the true hand's area, so that a stray estimate does not shrink it
    std::optional<Rectangle> around = truth_ != nullptr ? rectangle_around(*truth_) : std::nullopt;
    const bool has_truth = around.has_value();
    const double true_area = has_truth ? around->area() : 0.0;
    for (const HandPose* estimate : estimates_) {
      const std::optional<Rectangle> estimated = rectangle_around(*estimate);
      if (!estimated) continue;
      const Rectangle both = around ? united(*around, *estimated) : *estimated;
      if (!has_truth || both.area() <= kLargestGrowth * true_area) around = both;
    }
    return around;
  }

  View hand_view() const {
    constexpr double kMargin = 1.35;     // of the hand's size
    constexpr double kSmallest = 24.0;   // [px]
    constexpr double kLargest = 2000.0;  // [px]
    const double picture_size = options_.picture_size_px;
    const std::optional<Rectangle> hand = hand_rectangle();
    if (!hand) return whole_view();
    const double extent = std::max(hand->right - hand->left, hand->bottom - hand->top);
    const double shown = std::max(kMargin * extent, open_hand_px());
    const int side = static_cast<int>(std::ceil(std::clamp(shown, kSmallest, kLargest)));
    constexpr double kFar = 1e6;  // [px], where no image is
    const auto place = [&](double from, double to) {
      return static_cast<int>(std::lround(std::clamp((from + to - side) / 2.0, -kFar, kFar)));
    };
    const int x = place(hand->left, hand->right);
    const int y = place(hand->top, hand->bottom);
    return {{x, y, side, side}, picture_size / side};
  }

  /// Without truth the estimates may be too small: how many pixels an open hand with some ground around it
  /// takes where they lie. 0 where truth says how large the hand is.
  double open_hand_px() const {
    constexpr double kOpenHand = 280.0;  // [mm]
    const bool has_truth = truth_ != nullptr && !truth_->is_missing();
    const std::vector<double> depths = joint_depths();
    if (has_truth || depths.empty() || frame_.depth_mm.empty()) return 0.0;
    return kOpenHand * Projection(frame_.camera).pixels_per_mm(std::ranges::min(depths));
  }

  /// The whole image in a square.
  View whole_view() const {
    const int width = frame_.depth_mm.width();
    const int height = frame_.depth_mm.height();
    const int side = std::max({width, height, 1});
    return {{(width - side) / 2, (height - side) / 2, side, side}, double(options_.picture_size_px) / side};
  }

  /// Depths of the true joints, or else of the first estimate that has any.
  std::vector<double> joint_depths() const {
    std::vector<double> depths;
    const auto add = [&](const HandPose& pose) {
      for (const ImagePoint& joint : pose.joints) {
        if (!joint.is_missing()) depths.push_back(joint.depth_mm);
      }
    };
    if (truth_ != nullptr) add(*truth_);
    for (std::size_t i = 0; depths.empty() && i < estimates_.size(); ++i) add(*estimates_[i]);
    return depths;
  }

  /// From a little before the nearest joint to a little behind the farthest; all that is in view where no
  /// hand is known.
  DepthRange hand_depths(const View& view) const {
    constexpr double kBefore = 30.0;  // [mm], joints lie below the skin
    constexpr double kBehind = 60.0;  // [mm]
    const std::vector<double> depths = joint_depths();
    if (depths.empty()) return depth_range_in(frame_.depth_mm, view.crop);
    return {std::ranges::min(depths) - kBefore, std::ranges::max(depths) + kBehind};
  }

  /// The whole frame, with the outline of the part that the other pictures show. Without truth these follow
  /// the estimate, and a wrong one can only be seen from here.
  GalleryPicture overview(const Box& shown) const {
    const View view = whole_view();
    Image<Rgb> picture = picture_of(frame_.depth_mm, view, depth_range_in(frame_.depth_mm, view.crop));
    if (shown != view.crop) draw_box(picture, shown, view, kEstimateColour);
    return {"whole frame", "", std::move(picture)};
  }

  GalleryPicture truth_picture(Image<Rgb> picture, const View& view) const {
    if (truth_ != nullptr) draw_skeleton(picture, *truth_, view, kTruthColour);
    return {"truth", "", std::move(picture)};
  }

  GalleryPicture method_picture(Image<Rgb> picture, const View& view, std::size_t method) const {
    if (truth_ != nullptr) draw_skeleton(picture, *truth_, view, kTruthColour);
    draw_skeleton(picture, predicted(method), view, kEstimateColour);
    return {input_.methods[method].name, note(method), std::move(picture)};
  }

  GalleryPicture surface_picture(Image<Rgb> picture, const View& view, std::size_t method) const {
    const RecordedHands& recorded = recorded_[method];
    if (!recorded.flesh.empty()) draw_surface(picture, seen_surface(recorded.flesh, frame_.camera, view));
    for (const HandPose& pose : recorded.unfitted) draw_skeleton(picture, pose, view, kEstimateColour);
    const std::string_view what = recorded.flesh.empty() ? "" : ": surface";
    const std::string_view remark = recorded.poses.empty() ? "no hand" : "";
    return {fmt::format("{}{}", input_.records[method].name, what), std::string(remark), std::move(picture)};
  }

  GalleryPicture difference_picture(const View& view, const DepthRange& depths, std::size_t method) const {
    SurfaceDifference difference =
        surface_difference(recorded_[method].flesh, frame_.depth_mm, frame_.camera, view, depths);
    return {input_.records[method].name + ": difference",
            std::isfinite(difference.median_mm) ? fmt::format("median {:.1f} mm", difference.median_mm)
                                                : std::string("nothing measured"),
            std::move(difference.picture)};
  }

  std::string note(std::size_t method) const {
    if (predicted(method).is_missing()) return "no hand";
    if (input_.evaluation == nullptr) return "";
    const double error = input_.evaluation->methods[method].frame_mean_3d_mm[index_];
    if (std::isnan(error)) return "no truth";
    return std::isinf(error) ? "incomplete" : fmt::format("{:.1f} mm", error);
  }

  const GalleryInput& input_;
  const GalleryOptions& options_;
  std::int64_t index_;
  Frame frame_;
  const HandPose* truth_ = nullptr;
  std::vector<RecordedHands> recorded_;     ///< one per method with records
  std::vector<const HandPose*> estimates_;  ///< of all methods, predictions first
};

}  // namespace

void GalleryOptions::visit(OptionVisitor& visitor) {
  visitor.integer("even_frames", even_frames, closed(0, 1000));
  visitor.integer("worst_frames", worst_frames, closed(0, 100));
  visitor.integer("picture_size_px", picture_size_px, closed(64, 2000));
}

std::int64_t frames_to_show(const GalleryInput& input) {
  if (!input.methods.empty()) return static_cast<std::int64_t>(input.methods.front().sequence.poses.size());
  if (!input.records.empty()) return static_cast<std::int64_t>(input.records.front().frames.size());
  if (input.truth != nullptr) return static_cast<std::int64_t>(input.truth->sequence.poses.size());
  return input.source != nullptr ? input.source->size() : 0;
}

std::vector<GalleryRow> make_gallery(const GalleryInput& input, const GalleryOptions& options) {
  check_options(options, "gallery");
  const std::vector<Choice> choices = chosen_frames(input, options);
  std::vector<GalleryRow> rows(choices.size());
  parallel_for(static_cast<std::int64_t>(choices.size()), [&](std::int64_t i) {
    rows[i] = FramePictures(input, options, choices[i].frame).row(choices[i].reason);
  });
  return rows;
}

}  // namespace knuckle
