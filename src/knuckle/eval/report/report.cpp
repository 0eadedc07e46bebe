// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/report/report.h"

#include <algorithm>

#include "knuckle/core/text_file.h"
#include "knuckle/eval/metrics/score_files.h"
#include "knuckle/eval/pictures/score_figures.h"
#include "knuckle/eval/report/report_sections.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

ReportFigures draw_figures(const Report& report, const std::filesystem::path& folder) {
  ReportFigures figures;
  if (report.evaluation) figures.poses = drawn(figures_of(*report.evaluation), folder);
  if (!report.segmentation.empty())
    figures.segmentation = drawn({overlap_figure(report.segmentation)}, folder);
  const bool has_confidences = std::ranges::any_of(
      report.followed, [](const FollowedScore& score) { return score.reliability.joints > 0; });
  if (has_confidences) figures.followed = drawn({reliability_figure(report.followed)}, folder);
  if (!report.angles.empty()) figures.angles = drawn(report.angles, folder);
  return figures;
}

void write_scores(const Report& report, const std::filesystem::path& folder) {
  if (report.evaluation || !report.segmentation.empty() || !report.followed.empty()) {
    write_text_file(folder / "metrics.json",
                    to_json(report.evaluation, report.segmentation, report.followed));
  }
  if (report.evaluation) {
    write_text_file(folder / "curves.csv", curves_csv(*report.evaluation));
    write_text_file(folder / "joints.csv", joints_csv(*report.evaluation));
    write_text_file(folder / "frames.csv", frames_csv(*report.evaluation));
  }
  if (!report.segmentation.empty()) {
    write_text_file(folder / "overlaps.csv", overlaps_csv(report.segmentation));
  }
}

}  // namespace

std::vector<DrawnFigure> drawn(const std::vector<Figure>& figures, const std::filesystem::path& folder) {
  make_folder(folder);
  write_figures(figures, folder);
  std::vector<DrawnFigure> result;
  for (const Figure& figure : figures) {
    result.push_back({figure, read_text_file(folder / (figure.name + ".svg"))});
  }
  return result;
}

std::string report_html(const Report& report, const ReportFigures& figures) {
  std::string html = head_section(report);
  if (report.evaluation) {
    html += score_section(*report.evaluation) + common_section(*report.evaluation) +
            difference_section(*report.evaluation) + motion_section(*report.evaluation) +
            landmark_section(*report.evaluation);
  }
  if (!report.segmentation.empty()) html += segmentation_section(report.segmentation, figures.segmentation);
  if (!report.followed.empty()) html += followed_section(report.followed, figures.followed);
  if (!figures.angles.empty()) html += angle_section(figures.angles);
  if (!figures.poses.empty()) html += figure_section(figures.poses);
  if (report.evaluation) html += joint_section(*report.evaluation);
  if (!report.gallery.empty()) html += gallery_section(report.gallery);
  if (report.evaluation) html += reading_section();
  return html_page(report.title, html);
}

std::filesystem::path write_report(const Report& report, const std::filesystem::path& folder) {
  make_folder(folder);
  const ReportFigures figures = draw_figures(report, folder / "figures");
  write_scores(report, folder);
  std::filesystem::path page = folder / "report.html";
  write_text_file(page, report_html(report, figures));
  return page;
}

}  // namespace knuckle
