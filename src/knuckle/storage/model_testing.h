// SPDX-License-Identifier: Apache-2.0
// Helpers for tests only; not part of the library.
#pragma once

#include <functional>

#include "knuckle/storage/model_file.h"

namespace knuckle::testing {

/// The model file "test.model" that `write` fills.
inline ModelFile written_model(const std::function<void(ModelWriter&)>& write) {
  ModelWriter writer("knuckle-test", 1);
  write(writer);
  const std::vector<std::uint8_t> bytes = writer.bytes();
  return ModelFile::parse({bytes.begin(), bytes.end()}, "test.model");
}

/// Writes a model's file again with changes, and a sum that fits.
inline void change_model(const std::filesystem::path& path, const std::function<void(ModelWriter&)>& change) {
  ModelWriter writer = ModelFile::open(path).writer();
  change(writer);
  writer.save(path);
}

}  // namespace knuckle::testing
