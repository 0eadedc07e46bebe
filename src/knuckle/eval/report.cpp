// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/report.h"

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

}  // namespace

std::string report_html(const Report& report, const ReportFigures& figures) {
  std::string page = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  page += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  page +=
      "<title>" + html_escaped(report.title) + "</title>\n<style>" + std::string(kReportStyle) + "</style>\n";
  page += "</head>\n<body>\n" + head_section(report);
  if (report.evaluation) page += score_section(*report.evaluation) + landmark_section(*report.evaluation);
  if (!report.segmentation.empty()) page += segmentation_section(report.segmentation, figures.segmentation);
  if (!figures.poses.empty()) page += figure_section(figures.poses);
  if (report.evaluation) page += joint_section(*report.evaluation);
  if (!report.gallery.empty()) page += gallery_section(report.gallery);
  if (report.evaluation) page += reading_section();
  return page + "</body>\n</html>\n";
}

std::filesystem::path write_report(const Report& report, const std::filesystem::path& folder) {
  make_folder(folder);
  const ReportFigures figures = draw_figures(report, folder / "figures");
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
  std::filesystem::path page = folder / "report.html";
  write_text_file(page, report_html(report, figures));
  return page;
}

}  // namespace knuckle
