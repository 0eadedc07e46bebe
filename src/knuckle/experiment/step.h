// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace knuckle {

/// All that the outcome of a step depends on, as lines of text.
class StepInputs {
 public:
  StepInputs& add(std::string_view name, std::string_view value);
  /// The content of a file; of all files below a folder. Throws an Error that names what is missing.
  StepInputs& add_content(std::string_view name, const std::filesystem::path& path);

  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// The XXH3 hash (128 bits, hexadecimal) of a file's content. Throws an Error that names the file.
std::string content_hash(const std::filesystem::path& file);

/// What became of a step.
enum class StepOutcome {
  done,  ///< the work was done
  kept,  ///< the output was there, made from the same inputs
};

/// Does `work`, which writes `output` (whole or not at all), unless that was made from the same inputs
/// before. The inputs are kept beside it as `OUTPUT.inputs`, so that a run that was stopped or changed redoes
/// only what it must.
StepOutcome run_step(const std::filesystem::path& output, const StepInputs& inputs,
                     const std::function<void()>& work);

}  // namespace knuckle
