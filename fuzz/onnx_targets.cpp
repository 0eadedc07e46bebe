// SPDX-License-Identifier: Apache-2.0
// Networks of other engines.
#include "fuzz_target.h"

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "knuckle/core/landmarks.h"
#include "knuckle/estimate/exported_estimator.h"
#include "knuckle/estimate/foreign_estimator.h"
#include "knuckle/net/exported_network.h"
#include "knuckle/net/onnx/onnx_check.h"
#include "knuckle/net/onnx/onnx_engine.h"
#include "knuckle/net/onnx/onnx_file.h"

namespace knuckle::fuzz {

/// What passes the check is written again to the same model, and the engine, where there is one, runs it or
/// says why not; it is to crash on nothing that the check lets pass.
void run_onnx(Bytes bytes) {
  constexpr OnnxLimits kSmall{.numbers = 1 << 18, .work = 1 << 22};
  const OnnxModel model = checked_onnx(parse_onnx(as_text(bytes), "fuzz.onnx"), "fuzz.onnx", kSmall);
  const std::string written = onnx_bytes(model);
  if (onnx_bytes(parse_onnx(written, "fuzz.onnx")) != written)
    throw std::logic_error("written otherwise than read");
  if (!onnx_support().is_there) return;
  const std::vector<float> input(static_cast<std::size_t>(count_of(model.inputs.front().shape)), 0.5f);
  const std::unique_ptr<OnnxEngine> engine = create_onnx_engine(model, "fuzz.onnx");
  try {
    (void)engine->run(input);
  } catch (const std::runtime_error& error) {
    if (std::string_view(error.what()).find('\n') != std::string_view::npos)
      throw std::logic_error("not one line");
  }
}

namespace {

/// The estimator that a pipeline makes of such a network: one of ours by its metadata, of others one that
/// gives x, y, z of each landmark.
std::unique_ptr<Estimator> estimator_of(const OnnxModel& model) {
  const std::optional<NetworkOptions> network = exported_options(model, "fuzz.onnx");
  OnnxNetwork file(model, "fuzz.onnx");
  if (network)
    return std::make_unique<ExportedEstimator>(std::move(file), *network, NetworkEstimatorOptions{});
  const bool maps = file.outputs().size() > 1;
  ForeignNetworkOptions options;
  options.gives = maps ? "heat_maps" : "xyz";
  if (maps) options.landmarks_output = file.outputs().front().name;
  return std::make_unique<ForeignEstimator>(std::move(file), convention_from_name("icg20"), options, 1);
}

}  // namespace

/// A network as an estimator, which sees a hand.
void run_onnx_estimator(Bytes bytes) {
  if (!onnx_support().is_there) return;
  constexpr OnnxLimits kSmall{.numbers = 1 << 18, .work = 1 << 22};
  const std::unique_ptr<Estimator> estimator =
      estimator_of(checked_onnx(parse_onnx(as_text(bytes), "fuzz.onnx"), "fuzz.onnx", kSmall));
  const int size = estimator->patches().options().size_px;
  HandPatch patch{.pixels = Image<float>(size, size, 1.0F), .geometry = {}, .camera = {}};
  patch.geometry = {.size_px = size, .centre_u = 30, .centre_v = 20, .mean_depth_mm = 500};
  patch.camera = {CameraModel::projective, 64, 48, 60, 60, 32, 24, {}};
  patch.pixels(size / 2, size / 2) = 0.0F;
  const PatchPose pose = estimator->estimate(patch);
  if (pose.joints.size() != estimator->convention().landmarks.size())
    throw std::logic_error("a landmark was not seen");
}

}  // namespace knuckle::fuzz
