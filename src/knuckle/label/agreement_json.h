// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>

#include "knuckle/label/label_agreement.h"
#include "knuckle/label/label_times.h"

namespace knuckle {

/// One of the two authors that are compared.
struct ComparedAuthor {
  std::string name;
  LabelTimes times;
};

/// The disagreement of two authors as a JSON object, for programs: what is not known is null.
std::string to_json(const LabelAgreement& agreement, const Convention& convention,
                    const std::array<ComparedAuthor, 2>& authors);

}  // namespace knuckle
