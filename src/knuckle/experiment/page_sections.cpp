// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/page_sections.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include <fmt/format.h>

#include "knuckle/core/text.h"
#include "knuckle/eval/report/report_sections.h"

namespace knuckle {
namespace {

template <class... Arguments>
void add(std::string& html, fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  fmt::format_to(std::back_inserter(html), format, std::forward<Arguments>(arguments)...);
}

/// A number of one method on one sequence.
using Measure = std::function<double(const SequenceScores& sequence, std::size_t method)>;

std::vector<std::string> method_heads_of(const std::vector<std::string>& methods) {
  std::vector<std::string> heads;
  for (std::size_t i = 0; i < methods.size(); ++i) heads.push_back(method_head(methods[i], i));
  return heads;
}

/// Methods x sequences.
std::string methods_table(const ExperimentScores& scores, const std::string& title,
                          const std::vector<std::string>& methods, int digits, Better better,
                          const Measure& measure) {
  std::vector<NumberColumn> columns;
  for (const SequenceScores& sequence : scores.sequences) {
    NumberColumn column{html_escaped(sequence.title), {}, digits, better};
    for (std::size_t i = 0; i < methods.size(); ++i) column.values.push_back(measure(sequence, i));
    columns.push_back(column);
  }
  return fmt::format("<h3>{}</h3>\n", title) + number_table("method", method_heads_of(methods), columns);
}

/// A title as narrow HTML: a line per word.
std::string in_lines(const std::string& title) {
  std::vector<std::string> words;
  for (const std::string_view word : split(title, ' ')) words.push_back(html_escaped(word));
  return joined(words, "<br>");
}

/// Frames with all joints within each of some distances: methods x (sequences x distances).
std::string all_joints_table(const ExperimentScores& scores, const std::vector<std::string>& methods) {
  std::vector<NumberColumn> columns;
  for (const SequenceScores& sequence : scores.sequences) {
    for (std::size_t k = 0; k < kTableThresholdsMm.size(); ++k) {
      NumberColumn column{
          .head = fmt::format("{}<br>&le; {} mm", in_lines(sequence.title), kTableThresholdsMm[k]),
          .values = {},
          .digits = 1,
          .better = Better::higher};
      for (const MethodScore& score : sequence.evaluation->methods) {
        column.values.push_back(100.0 * score.frames_all_joints_within[k]);
      }
      columns.push_back(column);
    }
  }
  return "<h3>Frames with all joints within a distance (%)</h3>\n" +
         number_table("method", method_heads_of(methods), columns);
}

std::vector<std::string> segmentation_names(const ExperimentScores& scores) {
  std::vector<std::string> names;
  for (const SegmentationScore& score : scores.sequences.front().segmentation) names.push_back(score.name);
  return names;
}

std::vector<std::string> estimation_names(const ExperimentScores& scores) {
  std::vector<std::string> names;
  if (!scores.sequences.front().evaluation) return names;
  for (const MethodScore& score : scores.sequences.front().evaluation->methods) names.push_back(score.name);
  return names;
}

std::int64_t frame_count(const SequenceScores& sequence) {
  if (sequence.evaluation) return sequence.evaluation->methods.front().frames;
  return sequence.segmentation.empty() ? 0 : sequence.segmentation.front().frames;
}

std::string readable_time(const std::optional<double>& seconds) {
  if (!seconds) return "\u2013";
  if (*seconds < 100.0) return fmt::format("{:.1f} s", *seconds);
  if (*seconds < 6000.0) return fmt::format("{:.1f} min", *seconds / 60.0);
  return fmt::format("{:.1f} h", *seconds / 3600.0);
}

std::string trainings_table(const ExperimentScores& scores) {
  ReportTable table{
      .title = "Training",
      .heads = {"model", "origin", "samples seen", "time", "validation error (mm)"},
      .rows = {},
      .note =
          "Samples, time and validation are those of a network's metrics: validation is not in the "
          "time, and the error is the least mean over the joints. A forest's time is that of its "
          "last run, from frames to file."};
  for (const TrainingRecord& training : scores.trainings) {
    table.rows.push_back(
        {training.model, training.given.empty() ? "trained here" : training.given.string(),
         training.samples ? fmt::format("{}", *training.samples) : "\u2013", readable_time(training.seconds),
         std::isfinite(training.validation_mm) ? fmt::format("{:.1f}", training.validation_mm) : "\u2013"});
  }
  return table_section(table);
}

std::string css_class(Verdict verdict) {
  std::string name = name_of(verdict);
  std::ranges::replace(name, ' ', '-');
  return name;
}

}  // namespace

std::string summary_section(const ExperimentPlan& plan, const ExperimentScores& scores, double scale) {
  std::vector<std::string> sequences;
  for (const SequenceScores& sequence : scores.sequences) {
    sequences.push_back(fmt::format("{} ({} frames)", sequence.title, frame_count(sequence)));
  }
  Report head;
  head.title = plan.title;
  head.facts = {{"sequences", joined(sequences)}};
  if (!plan.segmentation.empty()) head.facts.push_back({"segmentation", joined(segmentation_names(scores))});
  if (!plan.estimation.empty()) {
    head.facts.push_back({"pose estimation", joined(estimation_names(scores))});
    head.facts.push_back({"landmarks", fmt::format("{} ({})", plan.convention.name, plan.convention.size())});
  }
  std::string html = head_section(head);
  if (scale < 1.0) {
    add(html,
        "<p class=\"warning\"><strong>Made small, at scale {}:</strong> fewer frames, smaller models, "
        "shorter "
        "training. This shows that all parts work; how good the methods are it does not show.</p>\n",
        scale);
  }
  return html;
}

std::string claims_section(const std::vector<Claim>& claims) {
  std::string html =
      "<h2>The paper&#39;s claims</h2>\n<p>What the paper says of its results, and whether the numbers of "
      "this run "
      "bear it out: on every sequence (<em>agrees</em>), on some (<em>in part</em>), or on none "
      "(<em>disagrees</em>).</p>\n<div class=\"scroll\"><table class=\"texts\">\n"
      "<thead><tr><th>claim</th><th>here</th><th>numbers</th></tr></thead>\n<tbody>\n";
  for (std::size_t i = 0; i < claims.size(); ++i) {
    const Claim& claim = claims[i];
    add(html,
        "<tr><td><strong>{}. {}</strong><br><span class=\"soft\">{}</span></td>"
        "<td class=\"verdict {}\">{}</td><td>",
        i + 1, html_escaped(claim.statement), html_escaped(claim.test), css_class(claim.verdict),
        name_of(claim.verdict));
    for (std::size_t line = 0; line < claim.evidence.size(); ++line) {
      add(html, "{}{}", line == 0 ? "" : "<br>", html_escaped(claim.evidence[line]));
    }
    html += "</td></tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string figure4_section(const ExperimentScores& scores, const std::vector<DrawnFigure>& panels) {
  const std::vector<std::string> methods = segmentation_names(scores);
  std::string html =
      "<h2>Figure 4: how well the hand is found</h2>\n"
      "<p>Segmentation marks the pixels of the hand. Around them lies a box, and another around the true "
      "joints; "
      "r is the area that both share over the area that either covers: 1 where they are the same, 0 where "
      "they are "
      "apart. A curve shows in how many frames r is greater than t. The higher a curve stays on its way to "
      "the "
      "right, the tighter the method fits; one that starts below 100% misses the hand altogether in some "
      "frames. "
      "No method reaches r = 1, since flesh reaches beyond the joints. Each method starts at the point "
      "nearest to "
      "the camera.</p>\n";
  html += figure_grid(panels);
  const auto score = [](const SequenceScores& sequence, std::size_t i) -> const SegmentationScore& {
    return sequence.segmentation[i];
  };
  html += methods_table(scores, "Mean overlap r of all frames", methods, 3, Better::higher,
                        [&](const auto& sequence, std::size_t i) { return score(sequence, i).mean_iou; });
  html += methods_table(
      scores, "Frames in which no hand was found", methods, 0, Better::lower,
      [&](const auto& sequence, std::size_t i) { return static_cast<double>(score(sequence, i).missing); });
  html +=
      methods_table(scores, "Overlap of the pixels themselves with the true mask", methods, 3, Better::higher,
                    [](const auto& sequence, std::size_t i) { return sequence.mask_iou[i]; });
  return html;
}

std::string figure5_section(const ExperimentScores& scores, const DrawnFigure5& rows) {
  const std::vector<std::string> methods = estimation_names(scores);
  const auto score = [](const SequenceScores& sequence, std::size_t i) -> const MethodScore& {
    return sequence.evaluation->methods[i];
  };
  std::string html =
      "<h2>Figure 5: how well the pose is estimated</h2>\n"
      "<p>All methods see the hand that mean shift cuts out, started at the true palm as in the paper, so "
      "that only "
      "the estimation differs.</p>\n"
      "<h3>First row: mean error of each joint in the image</h3>\n"
      "<p>How many pixels an estimated joint lies beside the true one, on average over the frames; lower is "
      "better. "
      "Pixels of different sensors do not compare: a pixel is wider the farther the hand and the shorter the "
      "lens.</p>\n";
  html += figure_grid(rows.joints_2d);
  html += methods_table(scores, "Mean 2D error of all joints (px)", methods, 2, Better::lower,
                        [&](const auto& sequence, std::size_t i) { return score(sequence, i).mean_2d_px; });
  html +=
      "<h3>Second row: mean error of each joint in space</h3>\n"
      "<p>The same in millimetres, depth included. These compare across sensors.</p>\n";
  html += figure_grid(rows.joints_3d);
  html += methods_table(scores, "Mean 3D error of all joints (mm)", methods, 2, Better::lower,
                        [&](const auto& sequence, std::size_t i) { return score(sequence, i).mean_3d_mm; });
  html +=
      "<h3>Third row: frames in which every joint is right</h3>\n"
      "<p>A frame counts only if its worst joint is at most D off: the hardest of the measures, for one "
      "finger "
      "that is wrong spoils the frame. Higher is better.</p>\n";
  html += figure_grid(rows.all_joints_within);
  html += all_joints_table(scores, methods);
  return html;
}

std::string examples_section(const ExperimentScores& scores) {
  std::vector<GalleryRow> rows;
  for (const SequenceScores& sequence : scores.sequences) {
    if (sequence.gallery.empty()) continue;
    rows.push_back(sequence.gallery.front());
    rows.back().caption = sequence.title + ": " + rows.back().caption;
  }
  return rows.empty() ? std::string() : gallery_section(rows);
}

std::string times_section(const ExperimentScores& scores) {
  std::string html =
      "<h2>Times</h2>\n<p>Medians over the frames. A frame is worked on by one thread, while other threads "
      "work on "
      "other frames.</p>\n";
  if (!segmentation_names(scores).empty()) {
    html +=
        methods_table(scores, "Segmentation of a frame (ms)", segmentation_names(scores), 2, Better::lower,
                      [](const auto& sequence, std::size_t i) { return sequence.segmentation_ms[i]; });
  }
  if (!estimation_names(scores).empty()) {
    html += methods_table(scores, "Estimation of a hand, after segmentation (ms)", estimation_names(scores),
                          2, Better::lower,
                          [](const auto& sequence, std::size_t i) { return sequence.estimation_ms[i]; });
  }
  if (!scores.trainings.empty()) html += trainings_table(scores);
  return html;
}

std::string files_section(const ExperimentScores& scores) {
  std::string html = "<h2>More</h2>\n<ul>\n";
  for (const SequenceScores& sequence : scores.sequences) {
    add(html,
        "<li><a href=\"{}/report.html\">{}</a>: all measures, joint by joint, with pictures of "
        "frames.</li>\n",
        html_escaped(sequence.name), html_escaped(sequence.title));
  }
  html +=
      "<li><code>tables/</code>: these tables as CSV; <code>timings/</code>: what differs from run to run; "
      "<code>figures/</code>: the figures as SVG and PNG.</li>\n</ul>\n";
  return html + reading_section();
}

}  // namespace knuckle
