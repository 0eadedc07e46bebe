// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/forest_growth.h"

namespace knuckle {

void write_checkpoint(const std::filesystem::path& path, const std::string& fingerprint,
                      const std::function<void(ModelWriter&)>& write) {
  ModelWriter file(kCheckpointFormat, kCheckpointVersion);
  file.set("fingerprint", fingerprint);
  write(file);
  file.save(path);
}

std::filesystem::path tree_checkpoint(const std::filesystem::path& checkpoint) {
  if (checkpoint.empty()) return {};
  return checkpoint.string() + ".tree";
}

void remove_checkpoint(const std::filesystem::path& checkpoint) {
  if (checkpoint.empty()) return;
  std::filesystem::remove(checkpoint);
  std::filesystem::remove(tree_checkpoint(checkpoint));
}

std::optional<ModelFile> open_checkpoint(const std::filesystem::path& path, const std::string& fingerprint) {
  if (path.empty() || !std::filesystem::exists(path)) return std::nullopt;
  ModelFile file = ModelFile::open(path);
  file.require_format(kCheckpointFormat, kCheckpointVersion);
  if (file.text("fingerprint") != fingerprint) {
    fail("{}: this checkpoint belongs to a training with other options or samples; remove it to start anew",
         path.string());
  }
  return file;
}

}  // namespace knuckle
