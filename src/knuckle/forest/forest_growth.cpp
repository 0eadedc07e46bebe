// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/forest_growth.h"

#include "knuckle/storage/file_io.h"

namespace knuckle {

void write_checkpoint(const std::filesystem::path& path, const std::string& fingerprint,
                      const std::function<void(Hdf5File&)>& write) {
  write_file_atomically(path, [&](const std::filesystem::path& temporary) {
    Hdf5File file = Hdf5File::create(temporary);
    file.set_attribute("format", kCheckpointFormat);
    file.set_attribute("version", double{kCheckpointVersion});
    file.set_attribute("fingerprint", fingerprint);
    write(file);
    file.close();
  });
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

std::optional<Hdf5File> open_checkpoint(const std::filesystem::path& path, const std::string& fingerprint) {
  if (path.empty() || !std::filesystem::exists(path)) return std::nullopt;
  Hdf5File file = Hdf5File::open(path);
  file.require_format(kCheckpointFormat, kCheckpointVersion);
  if (file.text_attribute("fingerprint") != fingerprint) {
    fail("{}: this checkpoint belongs to a training with other options or samples; remove it to start anew",
         path.string());
  }
  return file;
}

}  // namespace knuckle
