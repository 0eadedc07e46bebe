// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knuckle/eval/metrics/evaluation.h"
#include "knuckle/eval/metrics/followed_hands.h"
#include "knuckle/eval/metrics/segmentation_metrics.h"
#include "knuckle/eval/pictures/figures.h"
#include "knuckle/eval/pictures/gallery.h"

namespace knuckle {

/// A line of the report's head, as in "source: folder:recording".
struct ReportFact {
  std::string label;
  std::string value;
};

/// A table as it is shown; all cells are plain text.
struct ReportTable {
  std::string title;
  std::vector<std::string> heads;
  std::vector<std::vector<std::string>> rows;  ///< one cell a head
  std::string note;                            ///< below the table; may be empty
};

/// What a report tells. Every part may be empty: without truth there is only the gallery.
struct Report {
  std::string title = "Hand pose evaluation";
  std::vector<ReportFact> facts;
  std::optional<Evaluation> evaluation;
  std::vector<SegmentationScore> segmentation;
  std::vector<FollowedScore> followed;
  std::vector<Figure> angles;  ///< of fitted hands over time (angle_figures)
  std::vector<GalleryRow> gallery;
};

/// A figure of the report: its description and the SVG file drawn from it.
struct DrawnFigure {
  Figure figure;
  std::string svg;
};

/// The figures of a report, each in its section.
struct ReportFigures {
  std::vector<DrawnFigure> poses;
  std::vector<DrawnFigure> segmentation;
  std::vector<DrawnFigure> followed;
  std::vector<DrawnFigure> angles;
};

/// Writes the files of figures into `folder` (made where it is missing) and keeps them for a page.
std::vector<DrawnFigure> drawn(const std::vector<Figure>& figures, const std::filesystem::path& folder);

/// The report as an HTML page that needs no other file: figures as inline SVG, pictures as PNG inside.
std::string report_html(const Report& report, const ReportFigures& figures);

/// Writes into `folder` (made where it is missing) `report.html`, and beside it `figures/NAME.svg` and
/// `.png`, `metrics.json`, `curves.csv` and `joints.csv` where the report has an evaluation, `metrics.json`
/// and `overlaps.csv` where it has boxes. Returns the path of the page, which is written last. Throws an
/// Error where gnuplot is missing or a file cannot be written.
std::filesystem::path write_report(const Report& report, const std::filesystem::path& folder);

}  // namespace knuckle
