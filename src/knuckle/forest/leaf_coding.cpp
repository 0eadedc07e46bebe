// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/leaf_coding.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "knuckle/core/error.h"
#include "knuckle/core/symmetric_eigen.h"

namespace knuckle {
namespace {

using RowMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using RowView = Eigen::Map<const RowMatrix>;

/// A row per component, the widest first.
RowMatrix principal_components(const RowMatrix& centred) {
  const Eigen::MatrixXd covariance = (centred.transpose() * centred).cast<double>();
  return symmetric_eigen(covariance).vectors.rowwise().reverse().transpose().cast<float>();
}

std::uint16_t code_of(float value, float step) {
  const float steps = std::round(value / step);
  constexpr float kMost = std::numeric_limits<std::int16_t>::max();
  if (!(std::abs(steps) <= kMost)) {
    fail("forest leaves: a step of {} is too fine for leaves as far as {} apart", step, value);
  }
  const auto signed_steps = static_cast<int>(steps);
  return static_cast<std::uint16_t>(signed_steps >= 0 ? 2 * signed_steps : -2 * signed_steps - 1);
}

float steps_of(std::uint16_t code) {
  return static_cast<float>(code % 2 == 0 ? code / 2 : -(code + 1) / 2);
}

bool all_finite(std::span<const float> values) {
  return std::ranges::all_of(values, [](float value) { return std::isfinite(value); });
}

}  // namespace

CodedLeaves coded(const LeafTable& leaves, const LeafCoding& coding) {
  const auto dimensions = static_cast<Eigen::Index>(leaves.dimensions());
  const auto count = static_cast<Eigen::Index>(leaves.leaf_count());
  if (std::ssize(coding.scale) != dimensions ||
      std::ranges::any_of(coding.scale, [](float s) { return !(s > 0); })) {
    fail("forest leaves: {} scales for {} targets, expected one above 0 a target", coding.scale.size(),
         dimensions);
  }
  if (!(coding.step > 0.0F)) fail("forest leaves: a step of {}, expected more than 0", coding.step);
  const std::vector<float> values = leaves.decoded();
  RowMatrix scaled = RowView(values.data(), count, dimensions);
  scaled.array().rowwise() *= Eigen::Map<const Eigen::RowVectorXf>(coding.scale.data(), dimensions).array();
  const Eigen::RowVectorXf mean = scaled.cast<double>().colwise().mean().cast<float>();
  scaled.rowwise() -= mean;
  const RowMatrix components = principal_components(scaled);
  const RowMatrix lengths = components * scaled.transpose();

  CodedLeaves result{coding.step, coding.scale, {mean.data(), mean.data() + dimensions}, {}, {}};
  result.components.assign(components.data(), components.data() + components.size());
  result.codes.resize(static_cast<std::size_t>(lengths.size()));
  std::transform(lengths.data(), lengths.data() + lengths.size(), result.codes.begin(),
                 [&](float length) { return code_of(length, coding.step); });
  return result;
}

std::vector<float> decoded(const CodedLeaves& coded, const std::string& origin) {
  const std::size_t dimensions = coded.mean.size();
  if (dimensions == 0 || coded.scale.size() != dimensions ||
      coded.components.size() != dimensions * dimensions || coded.codes.size() % dimensions != 0) {
    fail("{}: the parts of the coded leaves do not fit together", origin);
  }
  if (!all_finite(coded.mean) || !all_finite(coded.components) || !std::isfinite(coded.step) ||
      std::ranges::any_of(coded.scale, [](float s) { return !(s > 0 && std::isfinite(s)); })) {
    fail("{}: the coded leaves' mean, scale, step or components are not finite, or a scale is not above 0",
         origin);
  }
  const auto rows = static_cast<Eigen::Index>(dimensions);
  const auto count = static_cast<Eigen::Index>(coded.codes.size() / dimensions);
  RowMatrix lengths(rows, count);
  std::ranges::transform(coded.codes, lengths.data(),
                         [&](std::uint16_t code) { return coded.step * steps_of(code); });
  RowMatrix values = lengths.transpose() * RowView(coded.components.data(), rows, rows);
  values.rowwise() += Eigen::Map<const Eigen::RowVectorXf>(coded.mean.data(), rows);
  values.array().rowwise() /= Eigen::Map<const Eigen::RowVectorXf>(coded.scale.data(), rows).array();
  if (!values.allFinite()) fail("{}: a leaf value is not finite", origin);
  return {values.data(), values.data() + values.size()};
}

}  // namespace knuckle
