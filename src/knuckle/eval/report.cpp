// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/report.h"

#include <algorithm>

#include "knuckle/core/file_io.h"
#include "knuckle/eval/report_sections.h"
#include "knuckle/eval/report_style.h"
#include "knuckle/eval/score_figures.h"
#include "knuckle/eval/score_files.h"

namespace knuckle {
namespace {

std::vector<DrawnFigure> drawn_figures(const std::vector<Figure>& figures,
                                       const std::filesystem::path& folder) {
  std::vector<DrawnFigure> drawn;
  for (const Figure& figure : figures)
    drawn.push_back({figure, read_text_file(folder / (figure.name + ".svg"))});
  return drawn;
}

ReportFigures draw_figures(const Report& report, const std::filesystem::path& folder) {
  std::vector<Figure> poses;
  std::vector<Figure> segmentation;
  if (report.evaluation) poses = figures_of(*report.evaluation);
  if (!report.segmentation.empty()) segmentation.push_back(overlap_figure(report.segmentation));
  std::vector<Figure> all = poses;
  all.insert(all.end(), segmentation.begin(), segmentation.end());
  if (all.empty()) return {};
  make_folder(folder);
  write_figures(all, folder);
  return {drawn_figures(poses, folder), drawn_figures(segmentation, folder)};
}

void write_scores(const Report& report, const std::filesystem::path& folder) {
  if (report.evaluation || !report.segmentation.empty()) {
    write_text_file(folder / "metrics.json", to_json(report.evaluation, report.segmentation));
  }
  if (report.evaluation) {
    write_text_file(folder / "curves.csv", curves_csv(*report.evaluation));
    write_text_file(folder / "joints.csv", joints_csv(*report.evaluation));
  }
  if (!report.segmentation.empty()) {
    write_text_file(folder / "overlaps.csv", overlaps_csv(report.segmentation));
  }
}

std::string part_html(const ReportPart& part) {
  const auto& [report, figures] = part;
  std::string html = head_section(report);
  for (const ReportTable& shown : report.tables) html += table_section(shown);
  if (report.evaluation) html += score_section(*report.evaluation) + landmark_section(*report.evaluation);
  if (!report.segmentation.empty()) html += segmentation_section(report.segmentation, figures.segmentation);
  if (!figures.poses.empty()) html += figure_section(figures.poses);
  if (report.evaluation) html += joint_section(*report.evaluation);
  if (!report.gallery.empty()) html += gallery_section(report.gallery);
  return html;
}

}  // namespace

std::string report_html(std::span<const ReportPart> parts) {
  std::string page = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  page += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  page += "<title>" + html_escaped(parts.front().report.title) + "</title>\n<style>" +
          std::string(kReportStyle) + "</style>\n</head>\n<body>\n";
  for (const ReportPart& part : parts) page += part_html(part);
  const bool has_scores =
      std::ranges::any_of(parts, [](const ReportPart& part) { return part.report.evaluation.has_value(); });
  return page + (has_scores ? reading_section() : "") + "</body>\n</html>\n";
}

std::filesystem::path write_report(const Report& report, const std::filesystem::path& folder) {
  return write_report(std::span(&report, 1), folder);
}

std::filesystem::path write_report(std::span<const Report> reports, const std::filesystem::path& folder) {
  make_folder(folder);
  std::vector<ReportPart> parts;
  for (const Report& report : reports) {
    const std::filesystem::path own_folder = folder / report.id;
    make_folder(own_folder);
    parts.push_back({report, draw_figures(report, own_folder / "figures")});
    write_scores(report, own_folder);
  }
  std::filesystem::path page = folder / "report.html";
  write_text_file(page, report_html(parts));
  return page;
}

}  // namespace knuckle
