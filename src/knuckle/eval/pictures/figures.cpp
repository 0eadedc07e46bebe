// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/pictures/figures.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <iterator>

#include "knuckle/core/error.h"
#include "knuckle/core/text_file.h"
#include "knuckle/eval/pictures/gnuplot.h"
#include "knuckle/eval/pictures/scratch_folder.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

// Okabe and Ito, "Color universal design" (2008), without black and yellow, which vanish on dark or white
// paper, and with a grey that is seen on both.
constexpr std::array kColours = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a8a8a"};
constexpr std::array kDashes = {"1", "2", "4", "5"};  // gnuplot's dash types: solid, dashed, dash-dotted, ...
constexpr std::array kDensities = {1.0, 0.5, 0.25};   // of bars, where the colours repeat
constexpr std::size_t kLongestLegendEntry = 36;       // characters
constexpr int kWidth = 600;                           // [px]
constexpr int kPlotHeight = 300;                      // [px], title and axes' area without what is below it
constexpr int kBelowAxis = 76;                        // [px], for the x axis' numbers and label
constexpr int kBelowBars = 112;                       // [px], for the sloping names of the categories
constexpr int kLegendRowHeight = 24;                  // [px]
constexpr int kLegendMargin = 12;                     // [px], below the legend
constexpr int kCharacterWidth = 8;                    // [px], of the figure's font
constexpr int kLegendEntryExtra = 9;                  // characters that a legend's sample and gap take
constexpr std::string_view kFont = "DejaVu Sans";

/// At most `longest` characters of UTF-8, with an ellipsis where some are missing.
std::string shortened(const std::string& text, std::size_t longest) {
  std::size_t characters = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool begins_character = (static_cast<unsigned char>(text[i]) & 0xC0) != 0x80;
    characters += begins_character ? 1 : 0;
    if (characters > longest) return text.substr(0, i) + "\u2026";
  }
  return text;
}

std::string legend_entry(const Series& series) {
  return shortened(series.name, kLongestLegendEntry);
}

/// Bars take the width of two figures with curves: a page shows all in one size of type.
int width_of(const Figure& figure) {
  return figure.kind == FigureKind::bars ? 2 * kWidth : kWidth;
}

/// How many entries of equal width a legend's row holds, and how many rows there are.
struct LegendLayout {
  int columns = 1;
  int rows = 1;
};

LegendLayout legend_layout(const Figure& figure) {
  std::size_t longest = 1;
  for (const Series& series : figure.series) longest = std::max(longest, legend_entry(series).size());
  const int count = static_cast<int>(figure.series.size());
  const int entry_width = (static_cast<int>(longest) + kLegendEntryExtra) * kCharacterWidth;
  LegendLayout layout;
  layout.columns = std::clamp(width_of(figure) / entry_width, 1, std::max(count, 1));
  layout.rows = std::max(1, (count + layout.columns - 1) / layout.columns);
  return layout;
}

/// Height of what lies below the plot: numbers or names, label, legend.
int height_below_plot(const Figure& figure) {
  return (figure.kind == FigureKind::bars ? kBelowBars : kBelowAxis) +
         legend_layout(figure).rows * kLegendRowHeight + kLegendMargin;
}

int height_of(const Figure& figure) {
  return kPlotHeight + height_below_plot(figure);
}

using Script = fmt::memory_buffer;

template <class... Arguments>
void add(Script& script, fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  fmt::format_to(std::back_inserter(script), format, std::forward<Arguments>(arguments)...);
  script.push_back('\n');
}

void add_number(Script& script, double value) {
  if (std::isfinite(value)) {
    fmt::format_to(std::back_inserter(script), " {:.6g}", value);
  } else {
    fmt::format_to(std::back_inserter(script), " NaN");
  }
}

/// A data block: a line per place on the x axis, x first, then a column per series.
void add_data(Script& script, const Figure& figure) {
  const bool has_categories = figure.kind == FigureKind::bars;
  const std::size_t rows = has_categories ? figure.categories.size() : figure.x.size();
  add(script, "$data << END_OF_DATA");
  for (std::size_t row = 0; row < rows; ++row) {
    add_number(script, has_categories ? static_cast<double>(row) : figure.x[row]);
    for (const Series& series : figure.series) add_number(script, series.values[row]);
    script.push_back('\n');
  }
  add(script, "END_OF_DATA");
}

void add_frame(Script& script, const Figure& figure) {
  add(script, "set encoding utf8");
  add(script, "set datafile missing 'NaN'");
  add(script, "set border 3 linecolor rgb '#333333' linewidth 1");
  add(script, "set tics nomirror out textcolor rgb '#333333'");
  add(script, "set grid ytics linecolor rgb '#d9d9d9' linewidth 1 dashtype 1");
  add(script, "set title {} textcolor rgb '#333333'", gnuplot_quoted(figure.title));
  add(script, "set xlabel {} textcolor rgb '#333333'", gnuplot_quoted(figure.x_label));
  add(script, "set ylabel {} textcolor rgb '#333333'", gnuplot_quoted(figure.y_label));
  const double height = height_of(figure);
  add(script, "set bmargin at screen {:.4f}", height_below_plot(figure) / height);
  add(script,
      "set key at screen 0.5, screen {:.4f} center bottom horizontal Left reverse samplen 2 maxcols {} "
      "spacing 1.25 textcolor rgb '#333333'",
      kLegendMargin / height, legend_layout(figure).columns);
}

bool has_values(const Figure& figure) {
  return std::ranges::any_of(figure.series, [](const Series& series) {
    return std::ranges::any_of(series.values, [](double value) { return std::isfinite(value); });
  });
}

/// gnuplot refuses to find the end where no value is known, as of a method that found no hand.
void add_free_y_range(Script& script, const Figure& figure) {
  add(script, "set yrange [0:{}]", has_values(figure) ? "*" : "1");
}

void add_curves(Script& script, const Figure& figure) {
  add(script, "set grid xtics");
  add(script, "set xrange [{:.6g}:{:.6g}]", figure.x.front(), figure.x.back());
  if (figure.y) {
    add(script, "set yrange [{:.6g}:{:.6g}]", figure.y->begin, figure.y->end);
    add(script, "set ytics {:.6g}", figure.y->step);
  } else {
    add_free_y_range(script, figure);
  }
  for (std::size_t i = 0; i < figure.series.size(); ++i) {
    add(script, "{} $data using 1:{} with lines linewidth 2.2 dashtype {} linecolor rgb '{}' title {}{}",
        i == 0 ? "plot" : "    ", i + 2, kDashes[(i / kColours.size()) % kDashes.size()], series_colour(i),
        gnuplot_quoted(legend_entry(figure.series[i])), i + 1 < figure.series.size() ? ", \\" : "");
  }
}

void add_bars(Script& script, const Figure& figure) {
  std::string tics;
  for (std::size_t i = 0; i < figure.categories.size(); ++i) {
    tics += fmt::format("{}{} {}", i == 0 ? "" : ", ", gnuplot_quoted(figure.categories[i]), i);
  }
  add(script, "set style data histograms");
  add(script, "set style histogram clustered gap 1");
  add(script, "set boxwidth 0.9 relative");
  add_free_y_range(script, figure);
  add(script, "set xrange [-0.6:{:.1f}]", static_cast<double>(figure.categories.size()) - 0.4);
  add(script, "set xtics ({}) rotate by 45 right scale 0", tics);
  for (std::size_t i = 0; i < figure.series.size(); ++i) {
    add(script, "{} $data using {} linecolor rgb '{}' fillstyle solid {} noborder title {}{}",
        i == 0 ? "plot" : "    ", i + 2, series_colour(i),
        kDensities[(i / kColours.size()) % kDensities.size()], gnuplot_quoted(legend_entry(figure.series[i])),
        i + 1 < figure.series.size() ? ", \\" : "");
  }
}

void add_plot(Script& script, const Figure& figure) {
  add_data(script, figure);
  add_frame(script, figure);
  if (figure.kind == FigureKind::curves) {
    add_curves(script, figure);
  } else {
    add_bars(script, figure);
  }
}

/// Of the parts of an SVG that are named, so that several may stand in one page.
std::string identifier_of(std::string name) {
  std::ranges::replace_if(
      name, [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return name;
}

void add_svg(Script& script, const Figure& figure, const std::filesystem::path& file) {
  add(script, "reset");
  add(script, "set terminal svg noenhanced size {},{} dynamic name {} font '{},13'", width_of(figure),
      height_of(figure), gnuplot_quoted(identifier_of(figure.name)), kFont);
  add(script, "set output {}", gnuplot_quoted(file.string()));
  add_plot(script, figure);
  add(script, "unset output");
}

void add_png(Script& script, const Figure& figure, const std::filesystem::path& file) {
  constexpr int kScale = 2;  // of pixels and fonts, for sharp print
  add(script, "reset");
  add(script, "set terminal pngcairo noenhanced size {},{} fontscale {} linewidth {} font '{},10'",
      kScale * width_of(figure), kScale * height_of(figure), kScale, kScale, kFont);
  add(script, "set output {}", gnuplot_quoted(file.string()));
  add_plot(script, figure);
  add(script, "unset output");
}

void check_figure(const Figure& figure) {
  const std::size_t places = figure.kind == FigureKind::bars ? figure.categories.size() : figure.x.size();
  if (figure.series.empty() || places == 0) fail("figure {}: nothing to draw", figure.name);
  for (const Series& series : figure.series) {
    if (series.values.size() != places) {
      fail("figure {}: {} values of {}, expected {}", figure.name, series.values.size(), series.name, places);
    }
  }
}

/// The picture that gnuplot wrote. Both formats end with a mark: refuses one that it left unfinished (a full
/// disk).
std::string whole_picture(const std::filesystem::path& written, const std::filesystem::path& named) {
  std::string content = read_text_file(written);
  const std::string_view end_mark = named.extension() == ".svg" ? "</svg>" : "IEND";
  constexpr std::size_t kTail = 16;
  if (content.find(end_mark, std::max(content.size(), kTail) - kTail) == std::string::npos) {
    fail("{}: cannot write: gnuplot left it incomplete", named.string());
  }
  return content;
}

}  // namespace

void write_figures(std::span<const Figure> figures, const std::filesystem::path& folder) {
  const ScratchFolder scratch;
  Script script;
  std::vector<std::string> names;
  for (const Figure& figure : figures) {
    check_figure(figure);
    names.push_back(figure.name + ".svg");
    add_svg(script, figure, scratch.path() / names.back());
    names.push_back(figure.name + ".png");
    add_png(script, figure, scratch.path() / names.back());
  }
  run_gnuplot(std::string_view(script.data(), script.size()));
  for (const std::string& name : names) {
    write_text_file(folder / name, whole_picture(scratch.path() / name, folder / name));
  }
}

std::string series_colour(std::size_t index) {
  return kColours[index % kColours.size()];
}

}  // namespace knuckle
