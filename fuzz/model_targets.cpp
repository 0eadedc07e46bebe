// SPDX-License-Identifier: Apache-2.0
// Models: their container, and what their numbers mean.
#include "fuzz_target.h"

#include <vector>

#include "knuckle/estimate/pose_forest.h"
#include "knuckle/hand/body_file.h"
#include "knuckle/net/network_file.h"
#include "knuckle/segment/detector/detector_file.h"
#include "knuckle/segment/segmentation_forest.h"
#include "knuckle/storage/model_file.h"
#include "knuckle/storage/zip_archive.h"

namespace knuckle::fuzz {
void run_zip(Bytes bytes) {
  for (const ZipEntry& entry : parse_zip(bytes, "fuzz.zip").entries) content_of(entry, "fuzz.zip");
}

void run_model(Bytes bytes) {
  const ModelFile file = ModelFile::parse(with_sum(bytes), "fuzz.model");
  (void)file.writer().bytes();
}

void run_pose_forest(Bytes bytes) {
  const PoseForestModel model = read_pose_forest(ModelFile::parse(with_sum(bytes), "fuzz.model"));
  const std::vector<float> features(static_cast<std::size_t>(model.forest.feature_count()), 0.5F);
  (void)model.forest.predict(features);
}

void run_segmentation_forest(Bytes bytes) {
  const PixelForest forest = read_segmentation_forest(ModelFile::parse(with_sum(bytes), "fuzz.model"));
  const Camera camera{CameraModel::projective, 24, 18, 20.0, 20.0, 12.0, 9.0, {}};
  (void)forest.above(Image<float>(24, 18, 600.0F), camera, 0.5F);
}

void run_body(Bytes bytes) {
  (void)body_hash(read_body(ModelFile::parse(with_sum(bytes), "fuzz.model")));
}

void run_detector(Bytes bytes) {
  (void)detector_options_as_toml(
      read_detector_weights(ModelFile::parse(with_sum(bytes), "fuzz.pt")).options());
}

void run_network(Bytes bytes) {
  (void)read_network_weights(ModelFile::parse(with_sum(bytes), "fuzz.pt"));
}

}  // namespace knuckle::fuzz
