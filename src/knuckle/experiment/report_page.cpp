// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/report_page.h"

#include <fmt/format.h>

#include "knuckle/eval/report/report_sections.h"
#include "knuckle/experiment/claims.h"
#include "knuckle/experiment/page_sections.h"
#include "knuckle/experiment/paper_figures.h"
#include "knuckle/experiment/scores.h"
#include "knuckle/experiment/tables.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

void write_tables(const ExperimentScores& scores, const std::vector<Claim>& claims,
                  const ExperimentFolder& folder) {
  make_folder(folder.tables());
  make_folder(folder.timings());
  write_text_file(folder.tables() / "segmentation.csv", segmentation_csv(scores));
  write_text_file(folder.tables() / "poses.csv", poses_csv(scores));
  write_text_file(folder.tables() / "trainings.csv", trainings_csv(scores));
  write_text_file(folder.timings() / "frames.csv", frame_times_csv(scores));
  write_text_file(folder.timings() / "trainings.csv", training_times_csv(scores));
  // One of the claims is about speed.
  if (!claims.empty()) write_text_file(folder.timings() / "claims.csv", claims_csv(claims));
}

/// The page of one sequence, as `knuckle evaluate` writes it.
void write_details(const SequenceScores& scores, const std::filesystem::path& folder) {
  Report report;
  report.title = scores.title;
  report.evaluation = scores.evaluation;
  report.segmentation = scores.segmentation;
  report.gallery = scores.gallery;
  write_report(report, folder);
}

}  // namespace

void write_experiment_report(const ExperimentPlan& plan, std::span<const std::string> sources, double scale,
                             const ExperimentFolder& folder) {
  const ExperimentScores scores = scored(plan, sources, folder);
  const std::vector<Claim> claims = plan.claims == "scia15" ? scia15_claims(scores) : std::vector<Claim>{};
  write_tables(scores, claims, folder);
  for (std::size_t i = 0; i < scores.sequences.size(); ++i) {
    write_details(scores.sequences[i], folder.details(plan.sequences[i]));
  }
  std::string body = summary_section(plan, scores, scale);
  if (!claims.empty()) body += claims_section(claims);
  if (!plan.segmentation.empty()) body += figure4_section(scores, drawn(figure4(scores), folder.figures()));
  if (!plan.estimation.empty()) {
    const Figure5 figures = figure5(scores);
    body +=
        figure5_section(scores, {.joints_2d = drawn(figures.joints_2d, folder.figures()),
                                 .joints_3d = drawn(figures.joints_3d, folder.figures()),
                                 .all_joints_within = drawn(figures.all_joints_within, folder.figures())});
    body += examples_section(scores);
  }
  body += times_section(scores) + files_section(scores);
  write_text_file(folder.report(), html_page(plan.title, body));
}

}  // namespace knuckle
