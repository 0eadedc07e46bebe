// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace knuckle {

/// All that the outcome of a step depends on, as lines of text.
class StepInputs {
 public:
  StepInputs& add(std::string_view name, std::string_view value);
  /// The content of a file; of all files below a folder. Throws an Error that names what is missing.
  StepInputs& add_content(std::string_view name, const std::filesystem::path& path);
  /// The content of a file, or that there is none.
  StepInputs& add_content_if_there(std::string_view name, const std::filesystem::path& path);
  /// A source of frames: what it is called, and the content of its file or folder.
  StepInputs& add_source(std::string_view name, const std::string& source);
  /// A pipeline file with the models that it names.
  StepInputs& add_pipeline(const std::filesystem::path& pipeline);

  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// The XXH3 hash (128 bits, hexadecimal) of a file's content. Throws an Error that names the file.
std::string content_hash(const std::filesystem::path& file);

}  // namespace knuckle
