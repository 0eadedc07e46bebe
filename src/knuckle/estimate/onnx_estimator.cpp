// SPDX-License-Identifier: Apache-2.0
#include "knuckle/estimate/onnx_estimator.h"

#include <array>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/own_convention.h"
#include "knuckle/estimate/exported_estimator.h"
#include "knuckle/estimate/foreign_estimator.h"
#include "knuckle/net/exported_network.h"
#include "knuckle/net/onnx/onnx_file.h"

namespace knuckle {
namespace {

constexpr std::array<std::string_view, 2> kPatchModes = {"cube", "hand"};

std::unique_ptr<Estimator> load_foreign(OnnxModel model, const std::filesystem::path& path,
                                        const OptionTable& table) {
  if (!table.has("convention")) {
    table.fail_at(
        "model", fmt::format("{} is not of `knuckle export`: say what it wants and gives, `convention` first "
                             "(docs/onnx.md)",
                             path.string()));
  }
  ForeignNetworkOptions options = foreign_defaults(table.choice_or("patch", "cube", kPatchModes));
  table.read(options);
  NetworkEstimatorOptions looks;
  if (options.patch == "hand") looks.passes = 1;
  table.read(looks);
  const Convention& convention = convention_from_key(table, "convention", "");
  return std::make_unique<ForeignEstimator>(OnnxNetwork(std::move(model), path.string()), convention,
                                            std::move(options), looks.passes);
}

}  // namespace

std::unique_ptr<Estimator> load_onnx_estimator(const OptionTable& table) {
  const std::filesystem::path path = table.resolved_path(table.required_text("model"));
  OnnxModel model = load_onnx(path);
  std::optional<NetworkOptions> network = exported_options(model, path.string());
  if (!network) return load_foreign(std::move(model), path, table);
  NetworkEstimatorOptions looks;
  table.read(looks);
  return std::make_unique<ExportedEstimator>(OnnxNetwork(std::move(model), path.string()),
                                             *std::move(network), looks);
}

}  // namespace knuckle
