// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/landmark_definition.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/options.h"
#include "knuckle/core/own_convention.h"
#include "knuckle/core/portable_math.h"
#include "knuckle/core/resources.h"
#include "knuckle/core/text.h"
#include "knuckle/hand/landmark_points.h"

namespace knuckle {
namespace {

constexpr double kLargestOffset = 2.0;  // palm lengths
constexpr double kLeastSine = 0.05;     // of two directions that span a plane
constexpr std::string_view kFormat = "knuckle-landmarks";
constexpr int kVersion = 1;

/// The landmark of the 22 from which a data set's own one is told.
Landmark nearest_of_superset(Landmark landmark) {
  using enum Landmark;
  switch (landmark) {
    case icvl_thumb_root:
      return thumb_cmc;
    case icvl_thumb_mid:
      return thumb_mcp;
    case icvl_thumb_tip:
      return thumb_ip;
    case icvl_index_root:
      return index_mcp;
    case icvl_index_mid:
      return index_pip;
    case icvl_index_tip:
      return index_dip;
    case icvl_middle_root:
      return middle_mcp;
    case icvl_middle_mid:
      return middle_pip;
    case icvl_middle_tip:
      return middle_dip;
    case icvl_ring_root:
      return ring_mcp;
    case icvl_ring_mid:
      return ring_pip;
    case icvl_ring_tip:
      return ring_dip;
    case icvl_little_root:
      return little_mcp;
    case icvl_little_mid:
      return little_pip;
    case icvl_little_tip:
      return little_dip;
    case nyu_little_base:
      return little_mcp;
    case nyu_ring_base:
      return ring_mcp;
    case nyu_middle_base:
      return middle_mcp;
    case nyu_index_base:
      return index_mcp;
    case nyu_thumb_mid:
      return thumb_ip;
    case nyu_thumb_base:
      return thumb_mcp;
    case nyu_wrist_1:
    case nyu_wrist_2:
      return wrist;
    default:
      return is_own(landmark) ? own_landmark_is_near(landmark) : landmark;
  }
}

const Point3& point_of(const SupersetPoints& hand, Landmark landmark) {
  return hand[static_cast<std::size_t>(landmark)];
}

Landmark next_outwards(Landmark landmark) {
  return static_cast<Landmark>(static_cast<int>(landmark) + 1);
}
Landmark next_inwards(Landmark landmark) {
  return static_cast<Landmark>(static_cast<int>(landmark) - 1);
}

bool is_tip(Landmark landmark) {
  return (static_cast<int>(landmark) - static_cast<int>(Landmark::thumb_tip)) % 4 == 0;
}

bool is_of_palm(Landmark landmark) {
  const int beyond_thumb = static_cast<int>(landmark) - static_cast<int>(Landmark::index_mcp);
  return landmark <= Landmark::thumb_cmc || (beyond_thumb >= 0 && beyond_thumb % 4 == 0);
}

bool is_of_thumb(Landmark landmark) {
  return landmark >= Landmark::thumb_mcp && landmark <= Landmark::thumb_tip;
}

/// Orthonormal axes: along, then the part of `aside` that is perpendicular to it, then their product, which a
/// mirror turns round.
std::optional<Eigen::Matrix3d> axes_of(const Eigen::Vector3d& along, const Eigen::Vector3d& aside,
                                       HandSide side) {
  const Eigen::Vector3d first = along.normalized();
  const Eigen::Vector3d rest = aside - aside.dot(first) * first;
  if (!(rest.norm() > kLeastSine * aside.norm()) || !(along.norm() > 0.0)) return std::nullopt;
  Eigen::Matrix3d axes;
  axes.col(0) = first;
  axes.col(1) = rest.normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1)) * (side == HandSide::left ? -1.0 : 1.0);
  if (!axes.allFinite()) return std::nullopt;
  return axes;
}

const std::vector<std::string_view>& superset_names() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> of_superset;
    for (const Landmark landmark : superset_convention().landmarks) of_superset.push_back(name_of(landmark));
    return of_superset;
  }();
  return names;
}

struct LandmarkEntry {
  std::string bone;
  std::vector<double> offset{0.0, 0.0, 0.0};
  std::string towards;
  double share = 0.0;
  std::vector<double> bent{0.0, 0.0, 0.0};

  void visit(OptionVisitor& visitor) {
    visitor.choice("bone", bone, superset_names());
    visitor.reals("offset", offset, closed(-kLargestOffset, kLargestOffset), 3, 3);
    visitor.choice("towards", towards, superset_names());
    visitor.real("share", share, closed(-1, 2));
    visitor.reals("bent", bent, closed(-kLargestOffset, kLargestOffset), 3, 3);
  }
};

struct DefinitionHead {
  std::string format;
  int version = 0;
  std::string convention;
  std::vector<std::string> landmarks;

  void visit(OptionVisitor& visitor) {
    static constexpr std::array kFormats{kFormat};
    visitor.choice("format", format, kFormats);
    visitor.integer("version", version, closed(kVersion, kVersion));
    visitor.text("convention", convention);
    visitor.texts("landmarks", landmarks, {});
  }
};

Landmark superset_landmark(std::string_view name) {
  const auto landmarks = superset_convention().landmarks;
  return *std::ranges::find_if(landmarks, [&](Landmark landmark) { return name_of(landmark) == name; });
}

/// A landmark of the 22 lies where it lies, unless a table says otherwise; in a convention that has a file of
/// its own it needs none.
DefinedLandmark read_landmark(const OptionTable& document, Landmark landmark) {
  const std::string name(name_of(landmark));
  const bool may_be_plain = document.has("landmarks") && static_cast<int>(landmark) < kSupersetSize;
  if (!document.has(name) && may_be_plain) return {.bone = landmark};
  if (!document.has(name)) fail("{}: lacks the table [{}]", document.origin(), name);
  const OptionTable table = document.table(name);
  for (const char* key : {"bone", table.has("towards") ? "share" : "offset"}) {
    if (!table.has(key)) fail("{}: [{}] lacks '{}'", document.origin(), name, key);
  }
  if (table.has("share") && !table.has("towards")) fail("{}: [{}] lacks 'towards'", document.origin(), name);
  LandmarkEntry entry;
  table.read(entry);
  DefinedLandmark read{superset_landmark(entry.bone), Eigen::Vector3d::Map(entry.offset.data())};
  if (!entry.towards.empty()) read.towards = superset_landmark(entry.towards);
  read.share = entry.share;
  if (table.has("bent")) read.bent = Eigen::Vector3d::Map(entry.bent.data());
  return read;
}

/// A line of a landmark's table: three numbers.
std::string vector_line(std::string_view key, const Eigen::Vector3d& numbers) {
  return fmt::format("{} = [{:.5f}, {:.5f}, {:.5f}]\n", key, numbers.x(), numbers.y(), numbers.z());
}

std::string landmark_list(const Convention& convention) {
  std::vector<std::string> names;
  for (const Landmark landmark : convention.landmarks)
    names.push_back(fmt::format("\"{}\"", name_of(landmark)));
  return fmt::format("landmarks = [{}]\n", joined(names));
}

Convention convention_of(const OptionTable& document, const DefinitionHead& head,
                         const std::filesystem::path& path) {
  if (document.has("landmarks")) return convention_from_file(path);
  const auto known = conventions();
  if (std::ranges::find(known, head.convention, &Convention::name) == known.end()) {
    document.fail_at("convention",
                     fmt::format("is \"{}\"; `knuckle info` lists those that there are, and one's "
                                 "own is told with a list 'landmarks'",
                                 head.convention));
  }
  return convention_from_name(head.convention);
}

}  // namespace

LandmarkDefinition LandmarkDefinition::plain(const Convention& convention) {
  LandmarkDefinition definition{convention, {}};
  for (const Landmark landmark : convention.landmarks)
    definition.landmarks.push_back({.bone = nearest_of_superset(landmark)});
  return definition;
}

LandmarkDefinition LandmarkDefinition::load(const std::filesystem::path& path) {
  const OptionTable document = OptionTable::load(path);
  DefinitionHead head;
  for (const char* key : {"format", "version", "convention"}) {
    if (!document.has(key)) {
      fail("{}: lacks '{}': it is not a file of `knuckle landmarks`", document.origin(), key);
    }
  }
  document.read(head);
  LandmarkDefinition definition{convention_of(document, head, path), {}};
  for (const Landmark landmark : definition.convention.landmarks)
    definition.landmarks.push_back(read_landmark(document, landmark));
  document.finish();
  return definition;
}

std::string LandmarkDefinition::as_toml() const {
  std::string text =
      fmt::format("format = \"{}\"\nversion = {}\nconvention = \"{}\"\n", kFormat, kVersion, convention.name);
  if (std::ranges::find(conventions(), convention) == conventions().end()) text += landmark_list(convention);
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    text +=
        fmt::format("\n[{}]\nbone = \"{}\"\n", name_of(convention.landmarks[i]), name_of(landmarks[i].bone));
    text += vector_line("offset", landmarks[i].offset);
    if (landmarks[i].bent) text += vector_line("bent", *landmarks[i].bent);
    if (landmarks[i].towards) {
      text +=
          fmt::format("towards = \"{}\"\nshare = {}\n", name_of(*landmarks[i].towards), landmarks[i].share);
    }
  }
  return text;
}

std::vector<Point3> LandmarkDefinition::on(const SupersetPoints& hand, HandSide side) const {
  const double unit = palm_length(hand);
  std::vector<Point3> points;
  points.reserve(landmarks.size());
  for (const DefinedLandmark& landmark : landmarks) {
    const Point3 origin = offset_origin(hand, landmark);
    if (landmark.offset.isZero(0.0) && !landmark.bent) {
      points.push_back(origin);
      continue;
    }
    Eigen::Vector3d offset = landmark.offset;
    if (landmark.bent) offset += finger_bend(hand, landmark.bone) * (*landmark.bent - landmark.offset);
    const std::optional<Eigen::Matrix3d> axes = bone_axes(hand, side, landmark.bone);
    points.push_back(axes ? Point3(origin + *axes * (unit * offset)) : Point3::Constant(kNaN));
  }
  return points;
}

std::optional<LandmarkDefinition> shipped_definition(const Convention& convention) {
  const std::filesystem::path file = resource_path(fmt::format("landmarks/{}.toml", convention.name));
  if (!std::filesystem::exists(file)) return std::nullopt;
  return LandmarkDefinition::load(file);
}

std::optional<LandmarkDefinition> definition_of_own_landmarks(const Convention& convention) {
  const bool is_plain = std::ranges::all_of(
      convention.landmarks, [](Landmark landmark) { return static_cast<int>(landmark) < kSupersetSize; });
  return is_plain ? std::nullopt : shipped_definition(convention);
}

std::filesystem::path definition_file(const std::filesystem::path& text) {
  if (std::filesystem::exists(text) || text.has_parent_path()) return text;
  const std::filesystem::path shipped = resource_path(fmt::format("landmarks/{}.toml", text.string()));
  return std::filesystem::exists(shipped) ? shipped : text;
}

Point3 offset_origin(const SupersetPoints& hand, const DefinedLandmark& landmark) {
  const Point3& bone = point_of(hand, landmark.bone);
  if (!landmark.towards) return bone;
  return bone + landmark.share * (point_of(hand, *landmark.towards) - bone);
}

double finger_bend(const SupersetPoints& hand, Landmark landmark) {
  constexpr int kFirstOfDigits = static_cast<int>(Landmark::thumb_cmc);
  constexpr int kMiddle = 2;
  const int number = static_cast<int>(landmark) - kFirstOfDigits;
  const int digit = number < 0 ? kMiddle : number / 4;
  const auto joint = [&](int which) { return point_of(hand, landmark_of_digit(digit, which)); };
  const Eigen::Vector3d first = joint(1) - joint(0);
  const Eigen::Vector3d last = joint(3) - joint(2);
  return portable_atan2(first.cross(last).norm(), first.dot(last)) / std::numbers::pi;
}

double palm_length(const SupersetPoints& hand) {
  return (point_of(hand, Landmark::middle_mcp) - point_of(hand, Landmark::wrist)).norm();
}

std::optional<Eigen::Matrix3d> bone_axes(const SupersetPoints& hand, HandSide side, Landmark landmark) {
  using enum Landmark;
  const Eigen::Vector3d outwards = point_of(hand, middle_mcp) - point_of(hand, wrist);
  const Eigen::Vector3d across = point_of(hand, index_mcp) - point_of(hand, little_mcp);
  std::optional<Eigen::Matrix3d> axes = axes_of(outwards, across, side);
  if (!axes || is_of_palm(landmark)) return axes;
  const Landmark from = is_tip(landmark) ? next_inwards(landmark) : landmark;
  const Eigen::Vector3d along = point_of(hand, next_outwards(from)) - point_of(hand, from);
  // A thumb points everywhere but against this: from the little finger's tip to the thumb's side of the
  // wrist.
  Eigen::Vector3d aside = axes->col(1);
  if (is_of_thumb(landmark)) aside -= axes->col(0);
  return axes_of(along, aside, side);
}

}  // namespace knuckle
