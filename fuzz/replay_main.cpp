// SPDX-License-Identifier: Apache-2.0
// knuckle_fuzz_replay CORPUS [TARGET FILE...]: hands each file of CORPUS/TARGET to its target, as a test of
// any compiler; or only the files that are named. Every target has to have a corpus.
#include "fuzz_target.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "knuckle/core/regular_file.h"

namespace fs = std::filesystem;

namespace {

void replay(std::string_view target, const fs::path& file) {
  constexpr std::int64_t kMostBytes = std::int64_t{1} << 30;
  std::printf("%s %s\n", std::string(target).c_str(), file.filename().c_str());
  std::fflush(stdout);
  const std::string bytes = knuckle::read_regular_file(file, kMostBytes);
  knuckle::fuzz::run_target(target, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 2) return std::fprintf(stderr, "usage: knuckle_fuzz_replay CORPUS [TARGET FILE...]\n"), 2;
  for (int i = 3; i < count; ++i) replay(arguments[2], arguments[i]);
  if (count > 2) return 0;
  for (const auto& target : knuckle::fuzz::fuzz_targets()) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(fs::path(arguments[1]) / target.name)) {
      files.push_back(entry.path());
    }
    if (files.empty()) return std::fprintf(stderr, "%s has no corpus\n", std::string(target.name).c_str()), 1;
    std::ranges::sort(files);
    for (const fs::path& file : files) replay(target.name, file);
  }
  return 0;
}
