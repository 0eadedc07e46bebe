// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/report/report_sections.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include <fmt/format.h>

#include "knuckle/core/text.h"
#include "knuckle/data/readers/png_encoder.h"
#include "knuckle/eval/pictures/angle_figures.h"
#include "knuckle/eval/pictures/drawing.h"
#include "knuckle/eval/pictures/surface_picture.h"
#include "knuckle/eval/report/report_style.h"

namespace knuckle {
namespace {

template <class... Arguments>
void add(std::string& html, fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  fmt::format_to(std::back_inserter(html), format, std::forward<Arguments>(arguments)...);
}

std::string names_of(const std::vector<Landmark>& landmarks) {
  std::vector<std::string> names;
  for (const Landmark landmark : landmarks) names.emplace_back(name_of(landmark));
  return joined(names);
}

std::vector<Landmark> compared(const MethodScore& method) {
  std::vector<Landmark> landmarks;
  for (const JointScore& joint : method.joints) landmarks.push_back(joint.landmark);
  return landmarks;
}

std::string swatch(const std::string& colour) {
  return fmt::format("<span class=\"swatch\" style=\"background:{}\"></span>", colour);
}

/// The value with its digits; a dash where it is not known.
std::string number(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : "\u2013";
}

/// The value to print in bold: the best of several that differ in print, NaN where there is none.
double best_of(const NumberColumn& column) {
  const std::vector<double>& values = column.values;
  const auto differs = [&](double value) {
    return number(value, column.digits) != number(values.front(), column.digits);
  };
  if (column.better == Better::neither || std::ranges::none_of(values, differs)) return kNaN;
  double best = kNaN;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    const bool is_better = column.better == Better::lower ? value < best : value > best;
    if (std::isnan(best) || is_better) best = value;
  }
  return best;
}

template <class Score>
std::vector<std::string> method_heads(const std::vector<Score>& scores) {
  std::vector<std::string> heads;
  for (std::size_t i = 0; i < scores.size(); ++i) heads.push_back(method_head(scores[i].name, i));
  return heads;
}

/// A column with one value per score.
template <class Score, class Value>
NumberColumn column(std::string head, const std::vector<Score>& scores, Value value, int digits,
                    Better better) {
  NumberColumn result{std::move(head), {}, digits, better};
  for (const Score& score : scores) result.values.push_back(static_cast<double>(std::invoke(value, score)));
  return result;
}

std::string score_table(const std::vector<MethodScore>& methods) {
  const bool is_same = compare_the_same(methods);
  const Better lower = is_same ? Better::lower : Better::neither;
  const Better higher = is_same ? Better::higher : Better::neither;
  std::vector<NumberColumn> columns = {
      column("missing<br>frames", methods, &MethodScore::missing, 0, lower),
      column("mean 3D<br>(mm)", methods, &MethodScore::mean_3d_mm, 2, lower),
      column("median 3D<br>(mm)", methods, &MethodScore::median_3d_mm, 2, lower),
      column("mean 2D<br>(px)", methods, &MethodScore::mean_2d_px, 2, lower),
      column("median 2D<br>(px)", methods, &MethodScore::median_2d_px, 2, lower),
  };
  for (std::size_t i = 0; i < kTableThresholdsMm.size(); ++i) {
    const auto percent = [i](const MethodScore& method) {
      return 100.0 * method.frames_all_joints_within[i];
    };
    columns.push_back(column(fmt::format("all joints<br>&le; {} mm (%)", kTableThresholdsMm[i]), methods,
                             percent, 1, higher));
  }
  columns.push_back(column("PCK area<br>0&ndash;50 mm", methods, &MethodScore::auc_pck_0_50, 3, higher));
  return number_table("method", method_heads(methods), columns);
}

/// What the colours of a difference mean.
std::string difference_legend() {
  return fmt::format(
      "<p>Difference of the fitted surface to the depth image: {}measured depth lies {} mm or more "
      "before the surface &ensp; {}on it &ensp; {}{} mm or more behind it &ensp; {}nothing was "
      "measured</p>\n",
      swatch(hex_code(kMeasuredBefore)), kDifferenceMm, swatch(hex_code(kAlike)),
      swatch(hex_code(kMeasuredBehind)), kDifferenceMm, swatch(hex_code(kNotMeasured)));
}

}  // namespace

std::string html_page(std::string_view title, std::string_view body) {
  std::string page = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  page += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  add(page, "<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n{}</body>\n</html>\n",
      html_escaped(title), kReportStyle, body);
  return page;
}

std::string number_table(const std::string& corner, const std::vector<std::string>& row_heads,
                         const std::vector<NumberColumn>& columns) {
  std::string html = fmt::format("<div class=\"scroll\"><table>\n<thead><tr><th>{}</th>", corner);
  for (const NumberColumn& column : columns) add(html, "<th>{}</th>", column.head);
  html += "</tr></thead>\n<tbody>\n";
  for (std::size_t row = 0; row < row_heads.size(); ++row) {
    add(html, "<tr><td>{}</td>", row_heads[row]);
    for (const NumberColumn& column : columns) {
      const std::string text = number(column.values[row], column.digits);
      const bool is_best =
          text == number(best_of(column), column.digits) && std::isfinite(column.values[row]);
      add(html, "<td{}>{}</td>", is_best ? " class=\"best\"" : "", text);
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string method_head(const std::string& name, std::size_t index) {
  return swatch(series_colour(index)) + html_escaped(name);
}

std::string head_section(const Report& report) {
  std::string html = "<h1>" + html_escaped(report.title) + "</h1>\n<dl class=\"facts\">\n";
  const auto add_fact = [&](std::string_view label, std::string_view value) {
    add(html, "<dt>{}</dt><dd>{}</dd>\n", html_escaped(label), html_escaped(value));
  };
  for (const ReportFact& fact : report.facts) add_fact(fact.label, fact.value);
  if (report.evaluation && !report.evaluation->methods.empty()) {
    const MethodScore& first = report.evaluation->methods.front();
    add_fact("truth", report.evaluation->truth);
    add_fact("convention", fmt::format("{} ({} landmarks)", report.evaluation->convention.name,
                                       report.evaluation->convention.size()));
    add_fact("frames", fmt::format("{}, {} of them with truth", first.frames, first.scored_frames));
  }
  return html + "</dl>\n";
}

std::string table_section(const ReportTable& shown) {
  std::string html =
      fmt::format("<h2>{}</h2>\n<div class=\"scroll\"><table>\n<thead><tr>", html_escaped(shown.title));
  for (const std::string& head : shown.heads) add(html, "<th>{}</th>", html_escaped(head));
  html += "</tr></thead>\n<tbody>\n";
  for (const std::vector<std::string>& row : shown.rows) {
    html += "<tr>";
    for (const std::string& cell : row) add(html, "<td>{}</td>", html_escaped(cell));
    html += "</tr>\n";
  }
  html += "</tbody></table></div>\n";
  if (!shown.note.empty()) add(html, "<p>{}</p>\n", html_escaped(shown.note));
  return html;
}

std::string score_section(const Evaluation& evaluation) {
  return "<h2>Scores</h2>\n" + score_table(evaluation.methods);
}

std::string common_section(const Evaluation& evaluation) {
  if (evaluation.in_common.empty()) return {};
  const std::vector<Landmark> common = compared(evaluation.in_common.front());
  return "<h2>Scores in what all share</h2>\n" + score_table(evaluation.in_common) +
         fmt::format("<p>In the {} landmarks that all methods and the truth have: {}.</p>\n", common.size(),
                     names_of(common));
}

std::string difference_section(const Evaluation& evaluation) {
  ReportTable table{
      "Differences",
      {"method", "against", "frames of both", "mean 3D (mm)", "95 % interval (mm)", "p"},
      {},
      "Error of the first less that of the second, frame by frame where both have a pose, by a paired "
      "bootstrap over blocks of frames: neighbours are alike. An interval without 0, or a small p, "
      "says that chance alone would hardly make such a difference."};
  for (const MethodDifference& found : evaluation.differences) {
    if (!std::isfinite(found.mean_mm)) continue;
    table.rows.push_back({evaluation.methods[found.first].name, evaluation.methods[found.second].name,
                          std::to_string(found.frames), fmt::format("{:+.2f}", found.mean_mm),
                          fmt::format("{:+.2f} to {:+.2f}", found.low_mm, found.high_mm),
                          fmt::format("{:.3f}", found.p_value)});
  }
  return table.rows.empty() ? std::string() : table_section(table);
}

std::string motion_section(const Evaluation& evaluation) {
  const std::vector<MethodScore>& methods = evaluation.methods;
  const auto moves = [](const MethodScore& method) { return method.motion.frames > 0; };
  if (std::ranges::none_of(methods, moves)) return {};
  const Better lower = compare_the_same(evaluation.methods) ? Better::lower : Better::neither;
  const auto of = [&](std::string head, double MotionScore::*value, double factor, int digits,
                      Better better) {
    const auto scaled = [=](const MethodScore& method) { return factor * (method.motion.*value); };
    return column(std::move(head), methods, scaled, digits, better);
  };
  return "<h2>Motion</h2>\n" +
         number_table(
             "method", method_heads(methods),
             {of("acceleration<br>(mm/frame&sup2;)", &MotionScore::acceleration_mm, 1, 2, lower),
              of("of the truth", &MotionScore::true_acceleration_mm, 1, 2, Better::neither),
              of("its error", &MotionScore::acceleration_error_mm, 1, 2, lower),
              of("lag<br>(frames)", &MotionScore::lag_frames, 1, 2, Better::neither),
              of("jitter of a<br>still hand (mm)", &MotionScore::jitter_mm, 1, 2, lower),
              of("of its worst<br>joint (mm)", &MotionScore::worst_jitter_mm, 1, 2, lower),
              of("bones&rsquo; lengths<br>differ by (%)", &MotionScore::bone_deviation, 100, 2, lower)});
}

std::string landmark_section(const Evaluation& evaluation) {
  std::string html = "<h2>Landmarks compared</h2>\n";
  const bool is_same = compare_the_same(evaluation.methods);
  if (!is_same) {
    html +=
        "<p><strong>The methods were compared in different landmarks:</strong> their numbers do not compare "
        "with each other.</p>\n";
  }
  html += "<ul>\n";
  for (const MethodScore& method : evaluation.methods) {
    add(html, "<li>{}{} of {}: {}.",
        is_same ? "" : "<strong>" + html_escaped(method.name) + "</strong>: ", method.joints.size(),
        evaluation.convention.size(), names_of(compared(method)));
    if (is_same) break;
    html += "</li>\n";
  }
  if (is_same) html += "</li>\n";
  for (const MethodScore& method : evaluation.methods) {
    const std::string name = html_escaped(method.name);
    if (!method.only_in_truth.empty()) {
      add(html, "<li>Dropped, as {} does not predict them: {}.</li>\n", name, names_of(method.only_in_truth));
    }
    if (!method.only_in_predictions.empty()) {
      add(html, "<li>Dropped, as only {} has them: {}.</li>\n", name, names_of(method.only_in_predictions));
    }
  }
  return html + "</ul>\n";
}

std::string segmentation_section(const std::vector<SegmentationScore>& scores,
                                 const std::vector<DrawnFigure>& figures) {
  constexpr std::size_t kHalf = 50;  // the threshold t = 0.5
  const auto above_half = [](const SegmentationScore& score) {
    return 100.0 * score.fraction_above.at(kHalf);
  };
  return "<h2>Segmentation</h2>\n" +
         number_table("method", method_heads(scores),
                      {column("frames", scores, &SegmentationScore::frames, 0, Better::neither),
                       column("missing<br>frames", scores, &SegmentationScore::missing, 0, Better::lower),
                       column("mean overlap r", scores, &SegmentationScore::mean_iou, 3, Better::higher),
                       column("median overlap r", scores, &SegmentationScore::median_iou, 3, Better::higher),
                       column("frames with<br>r &gt; 0.5 (%)", scores, above_half, 1, Better::higher)}) +
         figure_grid(figures, "figures single");
}

std::string followed_section(const std::vector<FollowedScore>& scores,
                             const std::vector<DrawnFigure>& figures) {
  const auto share = [](std::int64_t part, std::int64_t whole) {
    return whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : kNaN;
  };
  const auto found = [&](const FollowedScore& score) { return share(score.found, score.hands); };
  const auto sided = [&](const FollowedScore& score) { return share(score.right_side, score.found); };
  const auto off = [](const FollowedScore& score) { return 100.0 * score.reliability.error; };
  const auto visible = [](const FollowedScore& score) { return score.occlusion.front().mean_3d_mm; };
  const auto hidden = [](const FollowedScore& score) { return hidden_of(score.occlusion).mean_3d_mm; };
  return "<h2>Hands that were followed</h2>\n" +
         number_table(
             "method", method_heads(scores),
             {column("hands", scores, &FollowedScore::hands, 0, Better::neither),
              column("found (%)", scores, found, 1, Better::higher),
              column("with the right<br>side (%)", scores, sided, 1, Better::higher),
              column("invented", scores, &FollowedScore::invented, 0, Better::lower),
              column("exchanged<br>ids", scores, &FollowedScore::switches, 0, Better::lower),
              column("times lost", scores, &FollowedScore::losses, 0, Better::lower),
              column("longest loss<br>(frames)", scores, &FollowedScore::longest_loss, 0, Better::lower),
              column("mean 3D of<br>those found (mm)", scores, &FollowedScore::mean_3d_mm, 2, Better::lower),
              column("visible<br>landmarks (mm)", scores, visible, 2, Better::lower),
              column("hidden<br>landmarks (mm)", scores, hidden, 2, Better::lower),
              column("confidences<br>off by (%)", scores, off, 1, Better::lower)}) +
         fmt::format("<p>A hand of which less than {:.0f} % is seen need not be found.</p>\n",
                     100.0 * kLeastVisible) +
         (figures.empty() ? "" : figure_grid(figures, "figures single"));
}

std::string figure_grid(const std::vector<DrawnFigure>& figures, std::string_view style) {
  std::string html = fmt::format("<div class=\"{}\">\n", style);
  for (const DrawnFigure& drawn : figures) {
    add(html, "<figure{}>{}</figure>\n", drawn.figure.kind == FigureKind::bars ? " class=\"wide\"" : "",
        inline_svg(drawn.svg, drawn.figure.title));
  }
  return html + "</div>\n";
}

std::string figure_section(const std::vector<DrawnFigure>& figures) {
  return "<h2>Figures</h2>\n" + figure_grid(figures);
}

std::string angle_section(const std::vector<DrawnFigure>& figures) {
  return fmt::format(
      "<details><summary>Angles of the joints over time</summary>\n<p>Of hands that a hand model was fitted "
      "to; of more than {} those that were fitted in most frames.</p>\n{}</details>\n",
      kMostAngleHands, figure_grid(figures));
}

std::string joint_section(const Evaluation& evaluation) {
  std::vector<NumberColumn> columns;
  for (const MethodScore& method : evaluation.methods)
    columns.push_back({html_escaped(method.name), {}, 2, Better::neither});
  std::vector<std::string> heads;
  for (const Landmark landmark : evaluation.convention.landmarks) {
    heads.emplace_back(name_of(landmark));
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const std::vector<JointScore>& joints = evaluation.methods[i].joints;
      const auto joint = std::ranges::find(joints, landmark, &JointScore::landmark);
      columns[i].values.push_back(joint == joints.end() ? kNaN : joint->mean_3d_mm);
    }
  }
  return "<details><summary>Mean 3D error of each joint (mm)</summary>\n" +
         number_table("joint", heads, columns) + "</details>\n";
}

std::string gallery_section(const std::vector<GalleryRow>& rows) {
  std::string html = "<h2>Frames</h2>\n";
  add(html, "<p>{}estimate &ensp; ", swatch(hex_code(kEstimateColour)));
  if (std::ranges::any_of(rows, &GalleryRow::shows_truth)) {
    add(html, "{}truth &ensp; ", swatch(hex_code(kTruthColour)));
  }
  html += "Near depth is bright.</p>\n";
  if (std::ranges::any_of(rows, &GalleryRow::shows_difference)) html += difference_legend();
  html += "<div class=\"gallery\">\n";
  for (const GalleryRow& row : rows) {
    add(html, "<section class=\"frame\" style=\"--pictures:{}\"><h3>{}</h3>\n<div class=\"pictures\">\n",
        row.pictures.size(), html_escaped(row.caption));
    for (const GalleryPicture& picture : row.pictures) {
      add(html,
          "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption><span>{0}</span>"
          "<span>{2}</span></figcaption></figure>\n",
          html_escaped(picture.caption), base64(encode_png(picture.picture)), html_escaped(picture.note));
    }
    html += "</div></section>\n";
  }
  return html + "</div>\n";
}

std::string reading_section() {
  return R"html(<h2>How to read this</h2>
<ul>
<li>3D errors are distances in camera coordinates, 2D errors distances in the image. Means and medians are over all
joints of all frames with a prediction.</li>
<li>A frame without a complete prediction counts as <em>missing</em>. It enters no mean, but fails at every distance: fractions
are of all frames with truth.</li>
<li>A joint that the truth does not know is left out.</li>
<li><em>All joints &le; D</em>: fraction of frames whose worst joint is at most D off. <em>PCK</em>: fraction of joints
at most D off; its area from 0 to 50 mm is 1 for a perfect method.</li>
<li><em>Acceleration</em>: mean length of the second differences of joints from frame to frame; a method that trembles has more than
the truth. <em>Lag</em>: the shift at which estimates fit the truth best; below 0: early.</li>
</ul>
)html";
}

}  // namespace knuckle
