// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/pose_coordinates.h"

#include <array>
#include <cassert>
#include <vector>

#include <Eigen/LU>
#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/named_table.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

constexpr std::string_view kAxisNames = "xyz";

struct UnitRow {
  std::string_view name;
  double mm;
};
constexpr std::array kUnits = {UnitRow{"mm", 1.0}, UnitRow{"cm", 10.0}, UnitRow{"m", 1000.0}};

struct KindRow {
  std::string_view name;
  PoseCoordinates::Kind kind;
};
constexpr std::array kKinds = {KindRow{"uvd", PoseCoordinates::Kind::uvd},
                               KindRow{"xyz", PoseCoordinates::Kind::xyz}};

template <class Rows>
const auto& known_row(const Rows& rows, std::string_view what, std::string_view name) {
  const auto* const row = row_named(rows, name);
  if (row == nullptr) fail("{}", unknown_name(what, name, names_of(rows)));
  return *row;
}

std::string text_of(const Eigen::Matrix3d& axes) {
  std::vector<std::string> parts;
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      if (axes(row, column) == 0.0) continue;
      parts.push_back(fmt::format("{}{}", axes(row, column) < 0.0 ? "-" : "", kAxisNames[row]));
    }
  }
  return joined(parts, ",");
}

}  // namespace

PoseCoordinates::Kind coordinate_kind_from_text(std::string_view text) {
  std::string name(text);
  std::erase(name, ' ');
  return known_row(kKinds, "format of poses", name).kind;
}

Eigen::Matrix3d axes_from_text(std::string_view text) {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
  const std::vector<std::string_view> parts = split(text, ',');
  for (std::size_t column = 0; column < parts.size() && parts.size() == 3; ++column) {
    std::string_view name = trimmed(parts[column]);
    const bool is_backwards = name.starts_with('-');
    if (is_backwards) name.remove_prefix(1);
    const std::size_t row = name.size() == 1 ? kAxisNames.find(name[0]) : std::string_view::npos;
    if (row < kAxisNames.size())
      axes(static_cast<int>(row), static_cast<int>(column)) = is_backwards ? -1.0 : 1.0;
  }
  if (axes.cwiseAbs().determinant() == 0.0) {
    fail(
        "axes '{}': expected where the three numbers point, each of x (right), y (down) and z (forward) "
        "once: "
        "x,-y,-z",
        text);
  }
  return axes;
}

double unit_from_text(std::string_view text) {
  return known_row(kUnits, "unit", text).mm;
}

std::string as_options(const PoseCoordinates& coordinates) {
  const PoseCoordinates usual;
  std::vector<std::string> options;
  for (const KindRow& row : kKinds) {
    if (row.kind == coordinates.kind) options.push_back("--format " + std::string(row.name));
  }
  if (coordinates.axes != usual.axes) options.push_back("--axes " + text_of(coordinates.axes));
  for (const UnitRow& row : kUnits) {
    if (row.mm == coordinates.unit_mm && row.mm != usual.unit_mm)
      options.push_back("--unit " + std::string(row.name));
  }
  return joined(options, " ");
}

ImagePoint image_point(const Eigen::Vector3d& numbers, const PoseCoordinates& coordinates,
                       const Projection* projection) {
  if (!numbers.allFinite()) return {};
  if (coordinates.kind == PoseCoordinates::Kind::uvd)
    return {numbers.x(), numbers.y(), numbers.z() * coordinates.unit_mm};
  assert(projection != nullptr);
  return projection->to_image(coordinates.axes * numbers * coordinates.unit_mm);
}

}  // namespace knuckle
