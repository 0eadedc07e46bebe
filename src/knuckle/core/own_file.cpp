// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/own_file.h"

#include <dlfcn.h>
#include <link.h>

namespace knuckle {

namespace fs = std::filesystem;

fs::path own_file() {
  Dl_info ignored{};
  link_map* library = nullptr;
  const int found = ::dladdr1(reinterpret_cast<void*>(&own_file), &ignored,
                              reinterpret_cast<void**>(&library), RTLD_DL_LINKMAP);
  const bool is_library = found != 0 && library != nullptr && library->l_name[0] != '\0';
  std::error_code unknown;
  const fs::path path = fs::canonical(is_library ? library->l_name : "/proc/self/exe", unknown);
  return unknown ? fs::path() : path;
}

}  // namespace knuckle
