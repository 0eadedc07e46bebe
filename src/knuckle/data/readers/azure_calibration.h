// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "knuckle/core/camera.h"

namespace knuckle {

/// The depth camera of an Azure Kinect from the calibration that its recordings hold: the JSON that the
/// device gives, with focal lengths and centre as parts of the sensor's 1024 x 1024 pixels. `mode` is the
/// depth mode, which crops these or joins 2 x 2 of them to one: NFOV_UNBINNED, NFOV_2X2BINNED, WFOV_UNBINNED,
/// WFOV_2X2BINNED.
///
/// The lens is Brown and Conrady's, which is OpenCV's rational one ("Azure Kinect DK: Use calibration
/// functions"). Throws an Error that starts with `where` where the text is no such calibration, has no depth
/// camera, another lens, or where the mode is another.
Camera parse_azure_calibration(std::string_view json, std::string_view mode, std::string_view where);

}  // namespace knuckle
