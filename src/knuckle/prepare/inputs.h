// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace knuckle {

struct Manifest;
class OptionTable;

/// A model that a pipeline file names.
struct PipelineModel {
  std::string table;  ///< segmentation | estimator
  std::string file;   ///< as it stands there
};

/// The models that a pipeline file names.
std::vector<PipelineModel> models_named_in(const OptionTable& pipeline);

/// All that an outcome depends on, as lines of text: where they are the same again, it need not be made
/// again.
class Inputs {
 public:
  Inputs& add(std::string_view name, std::string_view value);
  /// The content of a file; of all files below a folder. Throws an Error that names what is missing.
  Inputs& add_content(std::string_view name, const std::filesystem::path& path);
  /// The content of a file, or that there is none.
  Inputs& add_content_if_there(std::string_view name, const std::filesystem::path& path);
  /// A source of frames: its kind and settings, and the content of its file or folder, wherever that lies; of
  /// a manifest the body that it shows, too.
  Inputs& add_source(std::string_view name, const std::string& source);
  /// A pipeline file with the models that it names.
  Inputs& add_pipeline(const std::filesystem::path& pipeline);
  /// The models that a pipeline file names.
  Inputs& add_models(const std::filesystem::path& pipeline);

  const std::string& text() const { return text_; }

 private:
  /// The body that a manifest shows.
  Inputs& add_body(std::string_view name, const Manifest& manifest);

  std::string text_;
};

}  // namespace knuckle
