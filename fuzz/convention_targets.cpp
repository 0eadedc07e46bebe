// SPDX-License-Identifier: Apache-2.0
// Conventions of one's own, and where landmarks lie.
#include "fuzz_target.h"

#include <stdexcept>

#include "knuckle/core/own_convention.h"
#include "knuckle/hand/landmark_definition.h"

namespace knuckle::fuzz {

/// As networks and ONNX files tell a convention. What is read is told as a text that is read as the same.
void run_convention(Bytes bytes) {
  const Convention& read = convention_from_text(as_text(bytes));
  if (convention_from_text(convention_text(read)) != read)
    throw std::logic_error("a convention is not read as it was told");
}

/// A definition of landmarks, which may bring a convention with it; then where they lie on a hand.
void run_landmarks(Bytes bytes) {
  const FuzzFile file(bytes, ".toml");
  const LandmarkDefinition definition = LandmarkDefinition::load(file.path());
  SupersetPoints hand;
  for (std::size_t i = 0; i < hand.size(); ++i) {
    const auto number = static_cast<double>(i);
    hand[i] = {number * number, 100.0 - number, 500.0 + 3.0 * number};
  }
  if (definition.on(hand, HandSide::left).size() != definition.convention.landmarks.size())
    throw std::logic_error("a landmark lies nowhere");
  const std::string told = definition.as_toml();
  const FuzzFile again(as_bytes_of(told), ".toml");
  if (LandmarkDefinition::load(again.path()).as_toml() != told)
    throw std::logic_error("a definition is not read as it was written");
}

}  // namespace knuckle::fuzz
