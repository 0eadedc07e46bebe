// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace knuckle {

/// What one method contributes to a figure.
struct Series {
  std::string name;            ///< stands in the legend
  std::vector<double> values;  ///< one per place on the x axis; NaN leaves a gap
};

/// What a figure draws.
enum class FigureKind {
  curves,  ///< a line per series over numbers
  bars,    ///< a group of bars, one per series, over each category
};

/// What an axis shows.
struct AxisRange {
  double begin = 0.0;
  double end = 100.0;  ///< above `begin`
  double step = 20.0;  ///< between two numbers on it, above 0
};

/// A figure to be drawn.
struct Figure {
  FigureKind kind = FigureKind::curves;
  std::string name;  ///< of its files, without extension
  std::string title;
  std::string x_label;                  ///< with unit
  std::string y_label;                  ///< with unit
  std::vector<double> x;                ///< places on the x axis, rising; curves only
  std::vector<std::string> categories;  ///< below the groups; bars only
  std::vector<Series> series;
  /// The y axis of curves; nothing: from 0 to where the values end.
  std::optional<AxisRange> y = AxisRange{};
};

/// Writes NAME.svg and NAME.png for each figure. The folder must exist. Throws where gnuplot is missing or
/// fails.
void write_figures(std::span<const Figure> figures, const std::filesystem::path& folder);

/// The colour of the i-th series of every figure, as "#rrggbb": those of Okabe and Ito that are seen on white
/// and on black, told apart by colour-blind readers, and grey; these seven repeat with another dash.
std::string series_colour(std::size_t index);

}  // namespace knuckle
