// SPDX-License-Identifier: Apache-2.0
#include "knuckle/refine/refiner_factory.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"
#include "knuckle/refine/depth_lookup.h"

namespace knuckle {
namespace {

// The table of methods: their names here, what makes them below.
constexpr std::array<std::string_view, 1> kNames{"depth_lookup"};

template <class Method, class Options>
std::unique_ptr<Refiner> create(const OptionTable& table) {
  Options options;
  table.read(options);
  table.finish();
  return std::make_unique<Method>(options);
}

using Create = std::unique_ptr<Refiner> (*)(const OptionTable& table);
constexpr std::array<Create, kNames.size()> kCreate{create<DepthLookup, DepthLookupOptions>};

}  // namespace

std::span<const std::string_view> refiner_names() {
  return kNames;
}

std::unique_ptr<Refiner> create_refiner(std::string_view name, const OptionTable& table) {
  const auto place = std::ranges::find(kNames, name);
  if (place == kNames.end()) {
    fail("there is no refinement method \"{}\"; known: {}", name,
         joined(std::vector<std::string>(kNames.begin(), kNames.end())));
  }
  return kCreate[static_cast<std::size_t>(place - kNames.begin())](table);
}

std::unique_ptr<Refiner> create_refiner(const OptionTable& table) {
  table.required_text("method");  // says where it is missing
  return create_refiner(table.choice_or("method", "", kNames), table);
}

}  // namespace knuckle
