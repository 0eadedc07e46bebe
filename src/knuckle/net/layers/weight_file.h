// SPDX-License-Identifier: Apache-2.0
// Private to the networks' modules.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/net/layers/weight_arrays.h"
#include "knuckle/storage/model_file.h"

namespace knuckle {

// A network's file is a model's (storage/model_file.h): the value `options`, its options as TOML; the array
// `weights`, all arrays of half precision one after another, as bits; and `norms`, the statistics of batch
// norms in single precision, where there are any.

/// What a file says it is.
struct WeightFormat {
  std::string_view name;  ///< of the kind of network
  int version;            ///< that is written and read
};

/// Writes a network, atomically: the same network makes the same bytes. Throws an Error that names the file
/// where it cannot be written.
void save_weights(const std::filesystem::path& path, const WeightFormat& format,
                  const std::string& options_toml, const WeightArrays& weights);

/// Reads a network's file in steps that check it before memory is taken. All faults are Errors that name the
/// file.
class WeightFile {
 public:
  /// Throws an Error where the file is of another kind or version.
  WeightFile(ModelFile file, const WeightFormat& format);

  /// The options, which the caller makes sense of; errors in them name `origin()`.
  std::string options_toml() const;
  const std::string& origin() const { return file_.origin(); }

  /// Throws an Error unless the file holds as many numbers as these arrays. Call it before there is room for
  /// them: a file may ask for more than there is.
  void require(const std::vector<NetworkArray>& arrays) const;
  /// Reads all numbers. Throws an Error where one is not finite, or a variance is negative.
  void read(WeightArrays& weights) const;

 private:
  ModelFile file_;
};

}  // namespace knuckle
