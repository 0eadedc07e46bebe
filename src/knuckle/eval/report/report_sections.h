// SPDX-License-Identifier: Apache-2.0
// The parts of the report's page, as HTML.
#pragma once

#include <string>
#include <vector>

#include "knuckle/eval/report/html.h"
#include "knuckle/eval/report/report.h"

namespace knuckle {

/// A whole page: `body` in the report's style.
std::string html_page(std::string_view title, std::string_view body);

/// Title and facts.
std::string head_section(const Report& report);

/// Which of a column's numbers is printed in bold.
enum class Better { lower, higher, neither };

/// A column of a table: a number for each row, NaN where it is not known.
struct NumberColumn {
  std::string head;  ///< HTML
  std::vector<double> values;
  int digits = 1;
  Better better = Better::lower;
};

/// `row_heads` are HTML.
std::string number_table(const std::string& corner, const std::vector<std::string>& row_heads,
                         const std::vector<NumberColumn>& columns);
/// The head of a method's row, with the colour that it has as the `index`-th series of a figure.
std::string method_head(const std::string& name, std::size_t index);

/// A table of its own, with heading and note.
std::string table_section(const ReportTable& shown);

/// Methods x measures, the best of each measure in bold.
std::string score_section(const Evaluation& evaluation);

/// The same in the landmarks that all methods share; empty where the methods share all.
std::string common_section(const Evaluation& evaluation);

/// Pairs of methods, and how sure it is that they differ; empty where there are none.
std::string difference_section(const Evaluation& evaluation);

/// How estimates move from frame to frame; empty where no frames follow each other.
std::string motion_section(const Evaluation& evaluation);

/// Which landmarks were compared, and which were dropped.
std::string landmark_section(const Evaluation& evaluation);

/// Overlap of estimated and true boxes, a row per method, and the figures that belong to it.
std::string segmentation_section(const std::vector<SegmentationScore>& scores,
                                 const std::vector<DrawnFigure>& figures);

/// How all hands were found and followed, a row per method, and how far their joints' confidences are true.
std::string followed_section(const std::vector<FollowedScore>& scores,
                             const std::vector<DrawnFigure>& figures);

/// Figures side by side; bars take the whole width.
std::string figure_grid(const std::vector<DrawnFigure>& figures, std::string_view style = "figures");

/// Curves and bars of the pose errors.
std::string figure_section(const std::vector<DrawnFigure>& figures);

/// The angles of fitted hands over time.
std::string angle_section(const std::vector<DrawnFigure>& figures);

/// Joints x methods: mean 3D error.
std::string joint_section(const Evaluation& evaluation);

/// Pictures of single frames: truth and predictions over the depth image.
std::string gallery_section(const std::vector<GalleryRow>& rows);

/// What the measures mean.
std::string reading_section();

}  // namespace knuckle
