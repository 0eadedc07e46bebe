// SPDX-License-Identifier: Apache-2.0
// What pulls a skeleton's flesh to measured points; only the energy of a fit includes this.
#pragma once

#include <array>

#include "knuckle/hand/hand_flesh.h"
#include "knuckle/hand/hand_surface.h"

namespace knuckle {

/// A measured point and the place on the line between two landmarks that it is compared with.
struct SurfaceContact {
  const HandFlesh* flesh = nullptr;
  double share = 0.0;                                 ///< of the way from `flesh->from` to `flesh->to`
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< from the point to that place, of length 1
  double radius_mm = 0.0;                             ///< of the flesh there
  double gap_mm = 0.0;  ///< how far the skin is from the point; negative: the point lies within the flesh
};

/// Places in the flesh that can be where they should not: before what was measured.
inline constexpr int kFloatPlaces = 2 * kFleshCount;

/// The flesh of a hand in a pose.
class PosedFlesh {
 public:
  /// `palm_mm` is the distance from the wrist to the middle MCP, which radii are parts of.
  PosedFlesh(const std::array<Point3, kSupersetSize>& landmarks, double palm_mm);

  /// Where the skin is nearest to a point.
  SurfaceContact nearest(const Point3& point) const;

  /// The contact of the place `number` of the flesh, [0, kFloatPlaces), with the measured point nearest to
  /// it, where it is seen to float: where the depth measured there lies clearly behind it. `flesh` is null
  /// where it does not float, or nobody knows.
  SurfaceContact floating(const HandSurface& surface, int number) const;

 private:
  /// Room for all lines, in whole registers.
  static constexpr std::size_t kRoom = (kFleshCount + 7) / 8 * 8;
  using Numbers = std::array<double, kRoom>;
  /// Lines between two landmarks and the radii along them, in columns: all are gone through for each point.
  struct Cones {
    std::array<Numbers, 3> from;
    std::array<Numbers, 3> axis;  ///< of length 1
    Numbers length;
    Numbers radius;   ///< where it begins
    Numbers growth;   ///< of the radius along the line [mm/mm]
    Numbers leaning;  ///< how far along the line, per distance from it, the skin's normal leads
  };

  /// The point on a line that lies so far from its beginning.
  Point3 on_line(std::size_t number, double place_mm) const;
  SurfaceContact contact(std::size_t number, double share, const Point3& point) const;

  Cones cones_{};
};

}  // namespace knuckle
