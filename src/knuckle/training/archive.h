// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <torch/serialize.h>

#include "knuckle/training/torch_errors.h"

namespace knuckle {

/// Writes an archive atomically; the same content gives the same bytes. Throws an Error that names the file
/// where it cannot be written; a former file of that name then stays.
void save_archive(const std::filesystem::path& path, torch::serialize::OutputArchive& archive);

/// A LibTorch archive with Knuckle's errors: named texts, numbers and lists of tensors, written atomically.
class ArchiveWriter {
 public:
  ArchiveWriter(std::string_view format, int version);
  void write(const std::string& name, const std::string& text);
  void write(const std::string& name, double number);
  void write(const std::string& name, const std::vector<torch::Tensor>& tensors);
  /// As `save_archive`.
  void save(const std::filesystem::path& path);

 private:
  torch::serialize::OutputArchive archive_;
};

/// Reads what ArchiveWriter wrote. All faults are Errors of one line that name the file.
class ArchiveReader {
 public:
  ArchiveReader(const std::filesystem::path& path, std::string_view format, int version);
  std::string text(const std::string& name);
  double number(const std::string& name);
  std::vector<torch::Tensor> tensors(const std::string& name);
  /// Copies the list into existing tensors. Throws where number or shapes differ, or a value is not finite.
  void copy_into(const std::string& name, const std::vector<torch::Tensor>& tensors);

 private:
  c10::IValue value(const std::string& name);
  std::string path_;
  torch::serialize::InputArchive archive_;
};

}  // namespace knuckle
