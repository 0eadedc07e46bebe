// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/training_source.h"

#include <cstddef>

namespace knuckle {

std::string training_source(const OptionTable& document) {
  const std::string text = document.required_text("source");
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) return text;  // the opener says what is wrong with it
  return text.substr(0, colon + 1) + document.resolved_path(text.substr(colon + 1)).string();
}

}  // namespace knuckle
