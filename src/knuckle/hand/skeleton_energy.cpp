// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/skeleton_energy.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "knuckle/core/portable_math.h"
#include "knuckle/core/statistics.h"
#include "knuckle/hand/hand_collision.h"

namespace knuckle {
namespace {

using Points = std::array<Point3, kSupersetSize>;

constexpr double kFarMm = 8.0;  ///< what is nearer to the skin is likely its own

/// By how much flesh gives way where digits touch: as much as the generator's hands
/// (docs/synthetic-hands.md).
constexpr double kSoftMm = 6.0;

/// A penalty of a gap, and what multiplies the gap in its derivative: half its square where it is small.
struct GapPenalty {
  double value;
  double weight;
};

/// Of a measured point: no more than half of `kFarMm` squared however large the gap is (Geman and McClure
/// 1985), since the point may be another thing's.
GapPenalty of_point(double gap_mm) {
  const double damped = 1.0 / (1.0 + gap_mm * gap_mm / (kFarMm * kFarMm));
  return {0.5 * gap_mm * gap_mm * damped, damped * damped};
}

/// Of flesh where nothing is: it grows on (Huber 1964), since nothing excuses it.
GapPenalty of_floating(double gap_mm) {
  if (gap_mm <= kFarMm) return {0.5 * gap_mm * gap_mm, 1.0};
  return {kFarMm * (gap_mm - 0.5 * kFarMm), kFarMm / gap_mm};
}

/// How far a landmark is from its target.
struct Miss {
  Eigen::Vector3d away = Eigen::Vector3d::Zero();   ///< from the target [mm]
  Eigen::Vector3d sight = Eigen::Vector3d::Zero();  ///< of length 1
  double along_mm = 0.0;                            ///< the part of `away` along it
  double squared = 0.0;                             ///< distance, squared, its depth weighted [mm^2]
};

Miss miss_of(const LandmarkTarget& target, const Point3& landmark) {
  Miss miss{.away = landmark - target.point};
  miss.squared = miss.away.squaredNorm();
  if (target.depth_weight == 1.0) return miss;
  miss.sight = target.point.normalized();
  miss.along_mm = miss.away.dot(miss.sight);
  miss.squared += (target.depth_weight - 1.0) * miss.along_mm * miss.along_mm;
  return miss;
}

double palm_length(const HandSkeleton& skeleton) {
  const auto at = [&](Landmark landmark) {
    return skeleton.landmarks[static_cast<std::size_t>(landmark)].straight_mm;
  };
  return (at(Landmark::middle_mcp) - at(Landmark::wrist)).norm();
}

/// The unknowns that move a landmark, ascending. Most do not: a row of derivatives has 15 numbers, not 44.
struct Movers {
  std::array<int, kSkeletonUnknowns> unknowns;
  int count = 0;

  void add(int unknown) { unknowns[static_cast<std::size_t>(count++)] = unknown; }
};

using MoversOfLandmarks = std::array<Movers, kSupersetSize>;

MoversOfLandmarks movers_of(const PoseJacobian& jacobian) {
  MoversOfLandmarks movers;
  for (int landmark = 0; landmark < kSupersetSize; ++landmark) {
    for (int unknown = 0; unknown < kSkeletonUnknowns; ++unknown) {
      if (!jacobian.block<3, 1>(3 * landmark, unknown).isZero(0.0)) movers[landmark].add(unknown);
    }
  }
  return movers;
}

Movers merged(const Movers& a, const Movers& b) {
  Movers both;
  const auto end = std::ranges::set_union(std::span(a.unknowns).first(a.count),
                                          std::span(b.unknowns).first(b.count), both.unknowns.begin())
                       .out;
  both.count = static_cast<int>(end - both.unknowns.begin());
  return both;
}

/// Adds the square of a residual, times half of `weight`; `row` has its derivatives by the movers.
void add_square(const Movers& movers, const double* row, double residual, double weight, Linearised& result) {
  for (int a = 0; a < movers.count; ++a) {
    const double weighted = weight * row[a];
    const int unknown = movers.unknowns[static_cast<std::size_t>(a)];
    result.gradient[unknown] += weighted * residual;
    for (int b = 0; b <= a; ++b)
      result.curvature(unknown, movers.unknowns[static_cast<std::size_t>(b)]) += weighted * row[b];
  }
}

void add_contact(const SurfaceContact& contact, const GapPenalty& gap, double weight,
                 const PoseJacobian& jacobian, const Movers& movers, Linearised& result) {
  const int from = 3 * static_cast<int>(contact.flesh->from);
  const int to = 3 * static_cast<int>(contact.flesh->to);
  std::array<double, kSkeletonUnknowns> row;
  for (int i = 0; i < movers.count; ++i) {
    const int unknown = movers.unknowns[static_cast<std::size_t>(i)];
    row[static_cast<std::size_t>(i)] =
        (1.0 - contact.share) * contact.normal.dot(jacobian.block<3, 1>(from, unknown)) +
        contact.share * contact.normal.dot(jacobian.block<3, 1>(to, unknown)) -
        (unknown == kSizeColumn ? contact.radius_mm : 0.0);
  }
  result.energy += weight * gap.value;
  add_square(movers, row.data(), contact.gap_mm, weight * gap.weight, result);
}

/// Derivatives of one coordinate of the way between two landmarks by what moves them.
std::array<double, kSkeletonUnknowns> bone_row(const PoseJacobian& jacobian, const Movers& movers,
                                               std::size_t from, std::size_t to, int axis) {
  std::array<double, kSkeletonUnknowns> row;
  for (int k = 0; k < movers.count; ++k) {
    const int unknown = movers.unknowns[static_cast<std::size_t>(k)];
    row[static_cast<std::size_t>(k)] = jacobian(3 * static_cast<int>(to) + axis, unknown) -
                                       jacobian(3 * static_cast<int>(from) + axis, unknown);
  }
  return row;
}

Movers movers_of_place(const MoversOfLandmarks& movers, const BoneCollision::Place& place) {
  return merged(movers[static_cast<std::size_t>(place.from)], movers[static_cast<std::size_t>(place.to)]);
}

/// Derivatives of the depth of a collision by what moves its bones. They are nearest there, so the depth does
/// not change with the shares.
std::array<double, kSkeletonUnknowns> depth_row(const PoseJacobian& jacobian, const Movers& movers,
                                                const BoneCollision& collision) {
  const auto along = [&](const BoneCollision::Place& place, int unknown) {
    return (1.0 - place.share) * collision.normal.dot(jacobian.block<3, 1>(3 * place.from, unknown)) +
           place.share * collision.normal.dot(jacobian.block<3, 1>(3 * place.to, unknown));
  };
  std::array<double, kSkeletonUnknowns> row;
  for (int k = 0; k < movers.count; ++k) {
    const int unknown = movers.unknowns[static_cast<std::size_t>(k)];
    row[static_cast<std::size_t>(k)] = along(collision.other, unknown) - along(collision.one, unknown) +
                                       (unknown == kSizeColumn ? collision.radii_mm : 0.0);
  }
  return row;
}

}  // namespace

Points landmarks(const HandSkeleton& skeleton, const SkeletonPose& pose, PoseJacobian& jacobian) {
  LandmarkJacobian of_skeleton;
  Points points = landmarks(skeleton, pose.angles, pose.camera_from_hand, &of_skeleton);
  of_skeleton.leftCols<kShiftColumn>() *= pose.size;
  of_skeleton.col(kSizeColumn) *= pose.size;
  jacobian.setZero();
  jacobian.leftCols<kLengthColumn>() = of_skeleton;
  for (int digit = 0; digit < 5; ++digit) {
    for (int bone = 0; bone < 3; ++bone) {
      const auto from = static_cast<int>(landmark_of_digit(digit, bone));
      const auto to = static_cast<int>(landmark_of_digit(digit, bone + 1));
      const double factor = pose.lengths[digit][bone];
      jacobian.middleRows<3>(3 * to) = jacobian.middleRows<3>(3 * from);
      jacobian.block<3, kLengthColumn>(3 * to, 0) +=
          factor * (of_skeleton.middleRows<3>(3 * to) - of_skeleton.middleRows<3>(3 * from));
      jacobian.block<3, 1>(3 * to, kLengthColumn + 3 * digit + bone) +=
          factor * pose.size * (points[to] - points[from]);
    }
  }
  return landmarks(skeleton, pose);
}

HandAngles bent_hand(double mcp, double pip) {
  using enum HandAngle;
  HandAngles angles;
  angles[thumb_radial] = 0.4;
  angles[thumb_palmar] = 0.5;
  angles[thumb_mcp] = angles[thumb_ip] = 0.25;
  for (int finger = 0; finger < 4; ++finger) {
    const FingerAngleNames names = angles_of_finger(finger);
    angles[names.mcp] = mcp;
    angles[names.pip] = pip;
    angles[names.dip] = coupled_dip(pip);
  }
  return angles;
}

SkeletonEnergy::SkeletonEnergy(const HandSkeleton& skeleton, const LandmarkTargets& targets,
                               const HandSurface& surface, const SkeletonFitOptions& options)
    : skeleton_(skeleton),
      targets_(targets),
      surface_(surface),
      options_(options),
      palm_mm_(palm_length(skeleton)) {}

double SkeletonEnergy::at(const SkeletonPose& pose) const {
  const Points points = landmarks(skeleton_, pose);
  double energy = prior_of(pose);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_known(targets_[i])) energy += 0.5 * weight(i) * miss_of(targets_[i], points[i]).squared;
  }
  for_each_bone([&](std::size_t from, std::size_t to, double weight) {
    energy += 0.5 * weight * bone_miss(points, from, to).squaredNorm();
  });
  for_each_overlap(points, [&](const BoneCollision&, double too_deep, double weight) {
    energy += 0.5 * weight * too_deep * too_deep;
  });
  for_each_contact(points, pose.size, [&](const SurfaceContact&, const GapPenalty& gap, double weight) {
    energy += weight * gap.value;
  });
  return energy;
}

Linearised SkeletonEnergy::linearised(const SkeletonPose& pose) const {
  PoseJacobian jacobian;
  const Points points = landmarks(skeleton_, pose, jacobian);
  const MoversOfLandmarks movers = movers_of(jacobian);
  Linearised result;
  result.energy = prior_of(pose);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!is_known(targets_[i])) continue;
    const Miss miss = miss_of(targets_[i], points[i]);
    result.energy += 0.5 * weight(i) * miss.squared;
    const auto add = [&](const Eigen::Vector3d& direction, double residual, double weight) {
      std::array<double, kSkeletonUnknowns> row;
      for (int k = 0; k < movers[i].count; ++k) {
        const int unknown = movers[i].unknowns[static_cast<std::size_t>(k)];
        row[static_cast<std::size_t>(k)] =
            direction.dot(jacobian.block<3, 1>(3 * static_cast<int>(i), unknown));
      }
      add_square(movers[i], row.data(), residual, weight, result);
    };
    for (int axis = 0; axis < 3; ++axis) add(Eigen::Vector3d::Unit(axis), miss.away[axis], weight(i));
    if (targets_[i].depth_weight != 1.0)
      add(miss.sight, miss.along_mm, weight(i) * (targets_[i].depth_weight - 1.0));
  }
  for_each_bone([&](std::size_t from, std::size_t to, double weight) {
    const Eigen::Vector3d miss = bone_miss(points, from, to);
    const auto both = merged(movers[from], movers[to]);
    result.energy += 0.5 * weight * miss.squaredNorm();
    for (int axis = 0; axis < 3; ++axis)
      add_square(both, bone_row(jacobian, both, from, to, axis).data(), miss[axis], weight, result);
  });
  for_each_overlap(points, [&](const BoneCollision& collision, double too_deep, double weight) {
    result.energy += 0.5 * weight * too_deep * too_deep;
    const Movers both =
        merged(movers_of_place(movers, collision.one), movers_of_place(movers, collision.other));
    add_square(both, depth_row(jacobian, both, collision).data(), too_deep, weight, result);
  });
  std::array<Movers, kFleshCount> movers_of_flesh;
  for (std::size_t i = 0; i < kFleshCount; ++i) {
    const HandFlesh& flesh = hand_flesh()[i];
    movers_of_flesh[i] =
        merged(movers[static_cast<std::size_t>(flesh.from)], movers[static_cast<std::size_t>(flesh.to)]);
  }
  for_each_contact(points, pose.size,
                   [&](const SurfaceContact& contact, const GapPenalty& gap, double weight) {
                     const auto number = static_cast<std::size_t>(contact.flesh - hand_flesh().data());
                     add_contact(contact, gap, weight, jacobian, movers_of_flesh[number], result);
                   });
  add_prior(pose, result);
  return result;
}

double SkeletonEnergy::rms_mm(const SkeletonPose& pose) const {
  const Points points = landmarks(skeleton_, pose);
  double sum = 0.0;
  double weights = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!is_known(targets_[i])) continue;
    sum += targets_[i].weight * (points[i] - targets_[i].point).squaredNorm();
    weights += targets_[i].weight;
  }
  return std::sqrt(sum / weights);
}

double SkeletonEnergy::gap_mm(const SkeletonPose& pose) const {
  const PosedFlesh flesh(landmarks(skeleton_, pose), palm_mm_ * pose.size);
  RunningMean mean;
  for (const Point3& point : surface_.points)
    mean.add(std::min(std::abs(flesh.nearest(point).gap_mm), kFarMm));
  return mean.value();
}

double SkeletonEnergy::weight(std::size_t landmark) const {
  return targets_[landmark].weight / (options_.noise_mm * options_.noise_mm);
}

double SkeletonEnergy::prior_of(const SkeletonPose& pose) const {
  double sum = postures_.squared_distance(pose.angles) / (options_.posture_spread * options_.posture_spread);
  for (std::size_t i = 0; options_.expected && i < kHandAngleCount; ++i) {
    const double unexpected =
        (pose.angles.radians[i] - options_.expected->radians[i]) / options_.expected_rad;
    sum += unexpected * unexpected;
  }
  const auto add_factor = [&](double factor, double mean, double spread) {
    if (spread == 0.0) return;
    const double away = portable_log(factor / mean) / spread;
    sum += away * away;
  };
  add_factor(pose.size, options_.size, options_.size_spread);
  for (int i = 0; i < 15; ++i) {
    add_factor(pose.lengths[i / 3][i % 3], options_.lengths[i / 3][i % 3], options_.length_spread);
  }
  return 0.5 * sum;
}

void SkeletonEnergy::add_prior(const SkeletonPose& pose, Linearised& result) const {
  const double of_posture = 1.0 / (options_.posture_spread * options_.posture_spread);
  result.gradient.head<kHandAngleCount>() += of_posture * postures_.half_gradient(pose.angles);
  result.curvature.topLeftCorner<kHandAngleCount, kHandAngleCount>() += of_posture * postures_.precision;
  for (int i = 0; options_.expected && i < kHandAngleCount; ++i) {
    const double of_expected = 1.0 / (options_.expected_rad * options_.expected_rad);
    result.gradient[i] += of_expected * (pose.angles.radians[i] - options_.expected->radians[i]);
    result.curvature(i, i) += of_expected;
  }
  const auto add_factor = [&](int column, double factor, double mean, double spread) {
    if (spread == 0.0) return;
    result.gradient[column] += portable_log(factor / mean) / (spread * spread);
    result.curvature(column, column) += 1.0 / (spread * spread);
  };
  add_factor(kSizeColumn, pose.size, options_.size, options_.size_spread);
  for (int i = 0; i < 15; ++i) {
    add_factor(kLengthColumn + i, pose.lengths[i / 3][i % 3], options_.lengths[i / 3][i % 3],
               options_.length_spread);
  }
}

template <class Visit>
void SkeletonEnergy::for_each_bone(const Visit& visit) const {
  if (options_.bone_mm == 0.0) return;
  for (int digit = 0; digit < 5; ++digit) {
    for (int bone = 0; bone < 3; ++bone) {
      const auto from = static_cast<std::size_t>(landmark_of_digit(digit, bone));
      const auto to = static_cast<std::size_t>(landmark_of_digit(digit, bone + 1));
      if (!is_known(targets_[from]) || !is_known(targets_[to])) continue;
      const double weight = std::sqrt(targets_[from].weight * targets_[to].weight);
      visit(from, to, weight / (options_.bone_mm * options_.bone_mm));
    }
  }
}

Eigen::Vector3d SkeletonEnergy::bone_miss(const Points& points, std::size_t from, std::size_t to) const {
  return (points[to] - points[from]) - (targets_[to].point - targets_[from].point);
}

template <class Visit>
void SkeletonEnergy::for_each_overlap(const Points& points, const Visit& visit) const {
  if (options_.overlap_mm == 0.0) return;
  const double weight = 1.0 / (options_.overlap_mm * options_.overlap_mm);
  for (const BoneCollision& collision : collisions_of(points, kSoftMm))
    visit(collision, collision.depth_mm - kSoftMm, weight);
}

template <class Visit>
void SkeletonEnergy::for_each_contact(const Points& points, double size, const Visit& visit) const {
  if (surface_.points.empty()) return;
  const PosedFlesh flesh(points, palm_mm_ * size);
  const double all = kSupersetSize / (options_.surface_mm * options_.surface_mm);
  for (const Point3& point : surface_.points) {
    const SurfaceContact contact = flesh.nearest(point);
    visit(contact, of_point(contact.gap_mm), all / static_cast<double>(surface_.points.size()));
  }
  for (int place = 0; place < kFloatPlaces; ++place) {
    const SurfaceContact contact = flesh.floating(surface_, place);
    if (contact.flesh != nullptr) visit(contact, of_floating(contact.gap_mm), all / kFloatPlaces);
  }
}

SkeletonPose stepped(const HandSkeleton& skeleton, const SkeletonPose& pose, const SkeletonStep& step) {
  SkeletonPose next = pose;
  for (int i = 0; i < kHandAngleCount; ++i) next.angles.radians[i] += step[i];
  next.angles = clamped(next.angles, skeleton.limits);
  next.camera_from_hand =
      moved(pose.camera_from_hand, step.segment<3>(kTurnColumn), step.segment<3>(kShiftColumn));
  const auto factor = [&](int column) { return portable_exp(std::clamp(step[column], -0.5, 0.5)); };
  next.size *= factor(kSizeColumn);
  for (int i = 0; i < 15; ++i) next.lengths[i / 3][i % 3] *= factor(kLengthColumn + i);
  return next;
}

}  // namespace knuckle
