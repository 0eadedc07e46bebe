// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "knuckle/label/label_session.h"

namespace knuckle {

/// What does not change while somebody labels.
struct LabelInfo {
  std::string version;         ///< of the program
  std::string source;          ///< as the user named it
  std::string file;            ///< where the labels go
  std::string author;          ///< who labels
  std::string estimator = {};  ///< the pipeline that finds hands first; empty: none does
};

/// The answer to /api/info: a JSON object.
std::string label_info_message(const LabelInfo& info, const LabelHead& head);

/// The answer to /api/frame: an image_message; its header has the keys of an answer to /api/labels, too.
std::vector<std::uint8_t> labelled_frame_message(const LabelledFrame& labelled, const Convention& convention);

/// The answer to /api/labels: a frame record of the labels (`record`), the flesh of the fitted hand model
/// (`surface`), `labels` with the state of each landmark, and what came of the request.
std::string label_answer_message(const LabelAnswer& answer, const Convention& convention,
                                 const std::string& fault, std::size_t waiting);

/// The answer to /api/standings: `states`, a letter per frame (- nothing, e estimated, p propagated,
/// c corrected, v verified); `doubts`, millimetres per frame; how long verified frames took.
std::string standings_message(const std::vector<FrameStanding>& standings,
                              const std::vector<double>& seconds);

/// The frame made small for the film strip, 96 px wide at most, without infrared.
std::vector<std::uint8_t> thumbnail_message(const Frame& frame);

}  // namespace knuckle
