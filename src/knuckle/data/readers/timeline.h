// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace knuckle {

/// When the frames of a set were taken, and which sequences they form.
struct Timeline {
  std::vector<double> times_s;  ///< one per frame [s]; empty where they are not known
  std::vector<int> sequences;   ///< one per frame; empty where all belong to sequence 0

  std::optional<double> time_s(std::int64_t frame) const;
  int sequence(std::int64_t frame) const;
};

/// What is wrong with a frame's time or sequence.
struct TimelineFault {
  std::int64_t frame;
  std::string message;
};

/// The first fault: a time that is not finite or goes back within a sequence, a sequence below 0 or below
/// that of the frame before.
std::optional<TimelineFault> fault_of(const Timeline& timeline);

/// The rate [Hz] of frames that follow one another at equal intervals within each sequence (to 0.1 %);
/// nothing where they do not, or where no two frames are of one sequence.
std::optional<double> regular_rate_hz(const Timeline& timeline);

/// The timeline of a folder set of `count` frames: `times.txt` (seconds, one line per frame) and
/// `sequences.txt` (first frame of each sequence from 0 on, one number per line) where they exist; blank
/// lines and lines that start with # do not count. Without times.txt a `rate_hz` above 0 gives each sequence
/// times from 0 on. Throws an Error that names file and line where one is wrong.
Timeline read_timeline(const std::filesystem::path& folder, std::int64_t count, double rate_hz);

/// Writes these files: times.txt where times are known, sequences.txt where there is more than one sequence,
/// whose numbers then count from 0. Throws an Error that names the folder and the frame where the timeline
/// has a fault.
void write_timeline(const std::filesystem::path& folder, const Timeline& timeline);

}  // namespace knuckle
