// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/shard.h"

#include <charconv>
#include <cstdlib>
#include <optional>
#include <system_error>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

/// Nothing where the text is no whole number from 0 to the most frames that there may be.
std::optional<std::int64_t> whole_number(std::string_view text) {
  std::int64_t number = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (fault != std::errc() || end != text.data() + text.size()) return std::nullopt;
  if (number < 0 || number > limits::kFrames) return std::nullopt;
  return number;
}

/// A number of a variable of the environment; nothing where there is none.
std::optional<std::int64_t> number_in_environment(const char* name) {
  const char* const text = std::getenv(name);
  if (text == nullptr) return std::nullopt;
  const auto number = whole_number(text);
  if (!number) fail("--shard auto: {} is '{}', expected a whole number", name, printable(text));
  return number;
}

/// Tasks have to be numbered from 0 on without a gap: of `--array=2,5`, or 2-3, nobody knows whether these
/// are all parts, or those of eight that were missing.
Shard shard_of_slurm() {
  const auto task = number_in_environment("SLURM_ARRAY_TASK_ID");
  const auto count = number_in_environment("SLURM_ARRAY_TASK_COUNT");
  if (!task || !count) {
    fail("--shard auto: this is no task of a Slurm job array (SLURM_ARRAY_TASK_ID is not set); say I/N");
  }
  const std::int64_t first = number_in_environment("SLURM_ARRAY_TASK_MIN").value_or(0);
  const std::int64_t step = number_in_environment("SLURM_ARRAY_TASK_STEP").value_or(1);
  const std::int64_t last = number_in_environment("SLURM_ARRAY_TASK_MAX").value_or(*count - 1);
  if (first != 0 || step != 1 || last != *count - 1 || *task > last) {
    fail(
        "--shard auto: this is task {} of {} from {} to {} in steps of {}, expected an array 0-(N-1) of all "
        "N "
        "parts; for some of them alone say --shard I/N",
        *task, *count, first, last, step);
  }
  return {*task, *count};
}

}  // namespace

Shard shard_from_text(std::string_view text) {
  if (text == "auto") return shard_of_slurm();
  const std::size_t slash = text.find('/');
  const auto number = whole_number(text.substr(0, slash));
  const auto count = slash == std::string_view::npos ? std::nullopt : whole_number(text.substr(slash + 1));
  if (!number || !count || *number >= *count) {
    fail("--shard is '{}', expected I/N, with I from 0 to N - 1, or auto", printable(text));
  }
  return {*number, *count};
}

IndexRange part_of(const IndexRange& whole, const Shard& shard) {
  if (shard.count > whole.count) {
    fail("--shard {}/{}: there are {} frames, expected a frame for each shard", shard.number, shard.count,
         whole.count);
  }
  // Both are at most limits::kFrames: their product fits.
  const auto begin = [&](std::int64_t number) { return whole.first + whole.count * number / shard.count; };
  return {begin(shard.number), begin(shard.number + 1) - begin(shard.number)};
}

}  // namespace knuckle
