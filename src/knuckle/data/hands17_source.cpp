// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/hands17_source.h"

#include "knuckle/core/image_io.h"
#include "knuckle/data/depth_image.h"
#include "knuckle/data/file_listing.h"
#include "knuckle/data/truth.h"

namespace knuckle {
namespace {

constexpr Camera kHands17Camera{
    CameraModel::projective, 640, 480, 475.065948, 475.065857, 315.944855, 245.287079, {}};
constexpr std::size_t kValuesAHands17Frame = 63;

}  // namespace

Hands17Source::Hands17Source(const std::filesystem::path& folder, const Hands17Options& options)
    : images_(subfolder_or_self(folder, "images"),
              find_annotation(folder, options.annotation, "Training_Annotation.txt")),
      projection_(kHands17Camera) {}

std::optional<Convention> Hands17Source::convention() const {
  if (!images_.has_labels()) return std::nullopt;
  return convention_from_name("hands21");
}

std::optional<HandPose> Hands17Source::truth_of(const LabelledImages::Entry& entry) const {
  if (!images_.has_labels()) return std::nullopt;
  return known_or_nothing(pose_from_camera(convention_from_name("hands21"), entry.numbers, projection_));
}

FrameLabel Hands17Source::read_label(std::int64_t index) const {
  return {kHands17Camera, truth_of(images_.read(index, kValuesAHands17Frame))};
}

Frame Hands17Source::read(std::int64_t index) const {
  const LabelledImages::Entry entry = images_.read(index, kValuesAHands17Frame);
  Frame frame;
  frame.name = without_extension(entry.name);
  frame.camera = kHands17Camera;
  const Image<std::uint16_t> counts = read_png16(entry.path);
  require_size(counts, kHands17Camera.width, kHands17Camera.height, entry.path);
  frame.depth_mm = depth_from_counts(counts, 1.0);
  frame.truth = truth_of(entry);
  return frame;
}

}  // namespace knuckle
