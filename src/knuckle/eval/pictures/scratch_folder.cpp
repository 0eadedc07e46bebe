// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/pictures/scratch_folder.h"

#include <string>
#include <system_error>

#include <stdlib.h>

#include "knuckle/core/error.h"

namespace knuckle {

ScratchFolder::ScratchFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "knuckle_XXXXXX").string();
  if (::mkdtemp(pattern.data()) == nullptr) fail("{}: cannot make a temporary folder", pattern);
  path_ = pattern;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace knuckle
