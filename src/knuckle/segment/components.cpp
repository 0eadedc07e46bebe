// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/components.h"

#include <algorithm>
#include <cstddef>
#include <span>

namespace knuckle {
namespace {

/// Set pixels of one row that touch one another: columns [first, last).
struct PixelRun {
  std::int32_t row;
  std::int32_t first;
  std::int32_t last;
  std::size_t parent;  ///< an earlier run of the same component; itself: the component's first
};

class RunList {
 public:
  explicit RunList(const Image<std::uint8_t>& mask) {
    std::size_t above = 0;  // where the runs of the row above start
    for (int row = 0; row < mask.height(); ++row) {
      const std::size_t start = runs_.size();
      add_row(mask.row(row), row);
      join(above, start);
      above = start;
    }
  }

  const std::vector<PixelRun>& runs() const { return runs_; }

  /// The first run of a run's component.
  std::size_t first_of(std::size_t run) {
    while (runs_[run].parent != run) {
      runs_[run].parent = runs_[runs_[run].parent].parent;
      run = runs_[run].parent;
    }
    return run;
  }

 private:
  void add_row(std::span<const std::uint8_t> pixels, std::int32_t row) {
    const auto width = static_cast<std::int32_t>(pixels.size());
    for (std::int32_t column = 0; column < width;) {
      if (pixels[column] == 0) {
        ++column;
        continue;
      }
      const std::int32_t first = column;
      while (column < width && pixels[column] != 0) ++column;
      runs_.push_back({row, first, column, runs_.size()});
    }
  }

  /// Joins the runs [above, start) of one row with those from `start` on, of the next, where they touch, also
  /// by a corner.
  void join(std::size_t above, std::size_t start) {
    std::size_t upper = above;
    std::size_t lower = start;
    while (upper < start && lower < runs_.size()) {
      if (runs_[upper].first <= runs_[lower].last && runs_[lower].first <= runs_[upper].last) {
        const std::size_t a = first_of(upper);
        const std::size_t b = first_of(lower);
        runs_[std::max(a, b)].parent = std::min(a, b);
      }
      ++(runs_[upper].last < runs_[lower].last ? upper : lower);
    }
  }

  std::vector<PixelRun> runs_;
};

}  // namespace

std::vector<std::vector<std::int32_t>> components_of(const Image<std::uint8_t>& mask) {
  RunList list(mask);
  std::vector<std::vector<std::int32_t>> components;
  std::vector<std::size_t> component_of(list.runs().size());  // of the first run of each
  for (std::size_t i = 0; i < list.runs().size(); ++i) {
    const PixelRun& run = list.runs()[i];
    const std::size_t first = list.first_of(i);
    if (first == i) {
      component_of[i] = components.size();
      components.emplace_back();
    }
    std::vector<std::int32_t>& pixels = components[component_of[first]];
    for (std::int32_t column = run.first; column < run.last; ++column)
      pixels.push_back(run.row * mask.width() + column);
  }
  return components;
}

}  // namespace knuckle
