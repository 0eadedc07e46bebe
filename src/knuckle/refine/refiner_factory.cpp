// SPDX-License-Identifier: Apache-2.0
#include "knuckle/refine/refiner_factory.h"

#include <array>
#include <string_view>

#include "knuckle/core/error.h"
#include "knuckle/core/named_table.h"
#include "knuckle/refine/depth_lookup.h"
#include "knuckle/refine/hand_model.h"
#include "knuckle/refine/inverse_kinematics.h"

namespace knuckle {
namespace {

template <class Method, class Options>
std::unique_ptr<Refiner> create(const OptionTable& table) {
  Options options;
  table.read(options);
  table.finish();
  return std::make_unique<Method>(options);
}

struct RefinementMethod {
  std::string_view name;
  /// Reads all keys of the table but `method`.
  std::unique_ptr<Refiner> (*create)(const OptionTable& table);
};

constexpr std::array kMethods{
    RefinementMethod{"depth_lookup", create<DepthLookup, DepthLookupOptions>},
    RefinementMethod{"hand_model", create<HandModel, HandModelOptions>},
    RefinementMethod{"inverse_kinematics", create<InverseKinematics, InverseKinematicsOptions>},
};
constexpr auto kNames = names_of(kMethods);

}  // namespace

std::span<const std::string_view> refiner_names() {
  return kNames;
}

std::unique_ptr<Refiner> create_refiner(std::string_view name, const OptionTable& table) {
  const RefinementMethod* const method = row_named(kMethods, name);
  if (method == nullptr) fail("{}", unknown_name("refinement method", name, kNames));
  return method->create(table);
}

std::unique_ptr<Refiner> create_refiner(const OptionTable& table) {
  table.required_text("method");  // says where it is missing
  return create_refiner(table.choice_or("method", "", kNames), table);
}

}  // namespace knuckle
