// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/writers/icg_writer.h"

#include <algorithm>
#include <string>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/data/readers/csv_image.h"
#include "knuckle/data/readers/exr_image.h"
#include "knuckle/data/readers/icg_format.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/data/truth.h"
#include "knuckle/storage/file_io.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

constexpr Rgb kHandColour{255, 0, 0};
constexpr Rgb kOtherColour{128, 128, 128};

Image<float> depth_in_metres(const Image<float>& depth_mm) {
  Image<float> metres = depth_mm;
  for (float& depth : metres.pixels()) depth = depth > 0 ? depth / 1000.0f : kIcgBackgroundMetres;
  return metres;
}

Image<Rgb> coloured(const Frame& frame) {
  Image<Rgb> colours(frame.mask.width(), frame.mask.height());
  for (std::size_t i = 0; i < colours.size(); ++i) {
    if (frame.mask.data()[i] != 0) {
      colours.data()[i] = kHandColour;
    } else if (frame.depth_mm.data()[i] > 0) {
      colours.data()[i] = kOtherColour;
    }
  }
  return colours;
}

std::string annotation_text(const HandPose& truth) {
  const HandPose pose = with_pixel_origin(converted(truth, convention_from_name("icg20")),
                                          PixelOrigin::centre, PixelOrigin::corner);
  std::string text;
  for (const ImagePoint& joint : pose.joints) {
    text +=
        joint.is_missing() ? "nan nan nan\n" : fmt::format("{} {} {}\n", joint.u, joint.v, joint.depth_mm);
  }
  return text;
}

}  // namespace

IcgWriter::IcgWriter(fs::path folder, const FrameWriterOptions& options)
    : folder_(std::move(folder)), ledger_(folder_.string(), options) {
  if (fs::exists(folder_ / kIcgCalibrationNames[0]))
    fail("{}: already holds a data set; remove it or choose another folder", folder_.string());
  make_folder(folder_);
}

void IcgWriter::write(std::int64_t index, const Frame& frame) {
  if (frame.camera.model != CameraModel::projective)
    fail("{}: frame {}: the icg format holds projective cameras only", folder_.string(), index);
  ledger_.enter(index, frame);
  const std::string stem = fmt::format("{:08}_0", index);  // no time stamp is known
  write_exr(folder_ / (stem + "_depth_0002.exr"), depth_in_metres(frame.depth_mm));
  if (!frame.mask.empty()) write_png(folder_ / (stem + "_rgb_0002.png"), coloured(frame));
  if (!frame.infrared.empty()) {
    Image<float> infrared(frame.infrared.width(), frame.infrared.height());
    std::ranges::copy(frame.infrared.pixels(), infrared.pixels().begin());
    write_csv_image(folder_ / (stem + "_infrared.csv"), infrared);
  }
  if (frame.truth) write_text_file(folder_ / (stem + "_anno_blender.txt"), annotation_text(*frame.truth));
  ledger_.note_written(index);
}

void IcgWriter::finish() {
  ledger_.require_complete();
  const fs::path calibration = folder_ / kIcgCalibrationNames[0];
  write_text_file(calibration, icg_calibration_text(ledger_.layout()->camera));
}

}  // namespace knuckle
