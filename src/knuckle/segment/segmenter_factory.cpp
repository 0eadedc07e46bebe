// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/segmenter_factory.h"

#include <array>
#include <filesystem>
#include <string_view>

#include "knuckle/core/error.h"
#include "knuckle/core/named_table.h"
#include "knuckle/segment/detector/detector_segmenter.h"
#include "knuckle/segment/forest_segmenter.h"
#include "knuckle/segment/mean_shift_segmenter.h"
#include "knuckle/segment/segmentation_forest.h"
#include "knuckle/segment/threshold_segmenter.h"

namespace knuckle {
namespace {

template <class Method, class Options>
std::unique_ptr<Segmenter> create(const OptionTable& table) {
  Options options;
  table.read(options);
  table.finish();
  return std::make_unique<Method>(options);
}

/// The model is named by a path relative to the table's file.
std::unique_ptr<Segmenter> create_forest(const OptionTable& table) {
  ForestSegmenterOptions options;
  const std::filesystem::path model = table.resolved_path(table.required_text("model"));
  table.read(options);
  table.finish();
  return std::make_unique<ForestSegmenter>(load_segmentation_forest(model), options);
}

std::unique_ptr<Segmenter> create_detector(const OptionTable& table) {
  DetectorSegmenterOptions options;
  const std::filesystem::path model = table.resolved_path(table.required_text("model"));
  table.read(options);
  table.finish();
  return std::make_unique<DetectorSegmenter>(load_detector_weights(model), options);
}

struct SegmentationMethod {
  std::string_view name;
  /// Reads all keys of the table but `method`.
  std::unique_ptr<Segmenter> (*create)(const OptionTable& table);
};

constexpr std::array kMethods{
    SegmentationMethod{"mean_shift", create<MeanShiftSegmenter, MeanShiftSegmenterOptions>},
    SegmentationMethod{"threshold", create<ThresholdSegmenter, ThresholdSegmenterOptions>},
    SegmentationMethod{"forest", create_forest},
    SegmentationMethod{"detector", create_detector},
};
constexpr auto kNames = names_of(kMethods);

}  // namespace

std::span<const std::string_view> segmenter_names() {
  return kNames;
}

std::unique_ptr<Segmenter> create_segmenter(std::string_view name, const OptionTable& table) {
  const SegmentationMethod* const method = row_named(kMethods, name);
  if (method == nullptr) fail("{}", unknown_name("segmentation method", name, kNames));
  return method->create(table);
}

std::unique_ptr<Segmenter> create_segmenter(const OptionTable& table) {
  return create_segmenter(table.choice_or("method", kMethods.front().name, kNames), table);
}

}  // namespace knuckle
