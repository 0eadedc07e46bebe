// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/fakenect_index.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

constexpr double kTicksPerSecond = 60e6;
constexpr double kTicksPerTurn = 4294967296.0;  // 2^32
constexpr double kLatestHostTime = 1e11;        // [s], the year 5138

/// What the name of a file tells.
struct FakenectStamp {
  double host_s = 0.0;
  std::uint32_t ticks = 0;
};

/// Ticks without their turns.
class KinectClock {
 public:
  /// Seconds since the clock's first 0.
  double time_s(const FakenectStamp& stamp) {
    elapsed_ = last_ ? elapsed_ + ticks_between(*last_, stamp) : stamp.ticks;
    last_ = stamp;
    return elapsed_ / kTicksPerSecond;
  }

 private:
  /// Of all numbers that the ticks allow the one nearest to what the computer's clock says; less than 0 where
  /// the Kinect's went back.
  static double ticks_between(const FakenectStamp& first, const FakenectStamp& second) {
    const std::uint32_t least = second.ticks - first.ticks;
    const double expected = (second.host_s - first.host_s) * kTicksPerSecond;
    return least + kTicksPerTurn * std::round((expected - least) / kTicksPerTurn);
  }

  std::optional<FakenectStamp> last_;
  double elapsed_ = 0.0;  ///< [ticks]
};

std::uint32_t parse_ticks(std::string_view text, std::string_view where) {
  const std::string_view digits = text.substr(0, text.find_first_not_of("0123456789"));
  const std::string_view extension = text.substr(digits.size());
  if (!extension.empty() && extension.front() != '.' && extension.front() != '-') {
    fail("{}: '{}' is not a number of ticks", where, text);
  }
  const long long ticks = parse_integer(digits, where);
  if (ticks >= static_cast<long long>(kTicksPerTurn))
    fail("{}: {} ticks are more than 32 bits", where, ticks);
  return static_cast<std::uint32_t>(ticks);
}

FakenectStamp parse_stamp(std::string_view name, std::string_view where) {
  const std::size_t dash = name.find('-', 2);
  if (dash == std::string_view::npos) fail("{}: '{}' is not TYPE-TIME-TICKS.EXTENSION", where, name);
  const double host_s = parse_number(name.substr(2, dash - 2), where);
  if (!(host_s >= 0.0 && host_s <= kLatestHostTime)) fail("{}: {} is not a time in seconds", where, host_s);
  return {host_s, parse_ticks(name.substr(dash + 1), where)};
}

void require_name(std::string_view name, std::string_view where) {
  const bool is_name = name.size() > 2 && name[1] == '-' && name.size() <= limits::kNameLength;
  if (!is_name) fail("{}: '{:.40}' is not TYPE-TIME-TICKS.EXTENSION", where, name);
  if (name.find_first_of(std::string_view("/\0", 2)) != std::string_view::npos) {
    fail("{}: '{}' is not in the folder of the recording", where, printable(name));
  }
}

}  // namespace

std::vector<FakenectImage> parse_fakenect_index(std::string_view text, std::string_view where) {
  std::vector<FakenectImage> images;
  KinectClock clock;
  std::size_t begin = 0;
  for (std::size_t number = 1; begin < text.size(); ++number) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view name = trimmed(text.substr(begin, end - begin));
    begin = end + 1;
    if (name.empty()) continue;
    const std::string place = fmt::format("{}:{}", where, number);
    require_name(name, place);
    if (name.front() != 'd') continue;
    const double time_s = clock.time_s(parse_stamp(name, place));
    const int sequence = images.empty() ? 0 : images.back().sequence;
    const bool went_back = !images.empty() && time_s < images.back().time_s;
    images.push_back({std::string(name), time_s, sequence + (went_back ? 1 : 0)});
  }
  if (images.empty()) fail("{}: lists no depth image (d-TIME-TICKS.pgm)", where);
  return images;
}

}  // namespace knuckle
