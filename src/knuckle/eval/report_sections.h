// SPDX-License-Identifier: Apache-2.0
// The parts of the report's page, as HTML.
#pragma once

#include <string>
#include <vector>

#include "knuckle/eval/html.h"
#include "knuckle/eval/report.h"

namespace knuckle {

/// Title and facts.
std::string head_section(const Report& report);

/// A table of its own, with heading and note.
std::string table_section(const ReportTable& shown);

/// Methods x measures, the best of each measure in bold.
std::string score_section(const Evaluation& evaluation);

/// Which landmarks were compared, and which were dropped.
std::string landmark_section(const Evaluation& evaluation);

/// Overlap of estimated and true boxes, a row a method, and the figures that belong to it.
std::string segmentation_section(const std::vector<SegmentationScore>& scores,
                                 const std::vector<DrawnFigure>& figures);

/// Curves and bars of the pose errors.
std::string figure_section(const std::vector<DrawnFigure>& figures);

/// Joints x methods: mean 3D error.
std::string joint_section(const Evaluation& evaluation);

/// Pictures of single frames: truth and predictions over the depth image.
std::string gallery_section(const std::vector<GalleryRow>& rows);

/// What the measures mean.
std::string reading_section();

}  // namespace knuckle
