// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace knuckle {

/// How an experiment is made small: by one number s in (0, 1], 1 for the whole. A value that counts frames
/// or samples becomes s times itself, the size of a model or the number of people sqrt(s) times itself, and a
/// tree loses as many levels as its samples are halved, log2(1/s). No value falls below the least that still
/// works, and none grows.
enum class Scaling { amount, size, depth };

/// A value at scale `s`: not below `least`, and never above `value`.
double scaled(double value, Scaling how, double s, double least);
/// The same as a whole number, rounded.
std::int64_t scaled_count(std::int64_t value, Scaling how, double s, std::int64_t least);

/// A test sequence at scale `s`: frames evenly spread over all of it, at least kFewestTestFrames.
std::string scaled_test_source(const std::string& source, double s);
/// Of a test sequence, however small the scale.
inline constexpr int kFewestTestFrames = 10;

/// A source of training frames at scale `s`: its first ones, at least kFewestTrainingFrames.
std::string scaled_training_source(const std::string& source, double s);
/// Of a source of training frames.
inline constexpr int kFewestTrainingFrames = 20;

}  // namespace knuckle
