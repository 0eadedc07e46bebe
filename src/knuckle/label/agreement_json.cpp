// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/agreement_json.h"

#include <cmath>

#include <nlohmann/json.hpp>

namespace knuckle {
namespace {

using nlohmann::ordered_json;

ordered_json number(double value) {
  return std::isnan(value) ? ordered_json() : ordered_json(value);
}

ordered_json json_of(const LandmarkAgreement& agreement) {
  return {{"hands", agreement.hands},
          {"mean_mm", number(agreement.mean_mm)},
          {"largest_mm", number(agreement.largest_mm)},
          {"of_other_visibility", agreement.of_other_visibility}};
}

ordered_json json_of(const HandAgreement& agreement) {
  return {{"frame", agreement.hand.frame},
          {"side", agreement.hand.side == HandSide::left ? "left" : "right"},
          {"landmarks", agreement.landmarks},
          {"mean_mm", number(agreement.mean_mm)},
          {"largest_mm", number(agreement.largest_mm)},
          {"mask_iou", number(agreement.mask_iou)}};
}

ordered_json json_of(const ComparedAuthor& author) {
  return {{"name", author.name},
          {"frames", author.times.frames},
          {"median_s", number(author.times.median_s)},
          {"percentile90_s", number(author.times.percentile90_s)},
          {"total_s", author.times.total_s}};
}

}  // namespace

std::string to_json(const LabelAgreement& agreement, const Convention& convention,
                    const std::array<ComparedAuthor, 2>& authors) {
  ordered_json all{{"convention", convention.name}, {"hands", agreement.hands}};
  for (const ComparedAuthor& author : authors) all["authors"].push_back(json_of(author));
  all["all"] = json_of(agreement.all);
  for (std::size_t i = 0; i < agreement.landmarks.size(); ++i)
    all["landmarks"][std::string(name_of(convention.landmarks[i]))] = json_of(agreement.landmarks[i]);
  all["frames"] = ordered_json::array();
  for (const HandAgreement& hand : agreement.each) all["frames"].push_back(json_of(hand));
  return all.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace knuckle
