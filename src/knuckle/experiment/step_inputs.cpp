// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/step_inputs.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <xxhash.h>

#include "knuckle/core/error.h"
#include "knuckle/core/options.h"
#include "knuckle/data/source_spec.h"

namespace knuckle {
namespace {

std::vector<std::filesystem::path> files_below(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

}  // namespace

StepInputs& StepInputs::add(std::string_view name, std::string_view value) {
  text_ += fmt::format("{}: {}\n", name, value);
  return *this;
}

StepInputs& StepInputs::add_content(std::string_view name, const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) return add(name, content_hash(path));
  for (const std::filesystem::path& file : files_below(path)) {
    add(fmt::format("{}/{}", name, std::filesystem::relative(file, path).string()), content_hash(file));
  }
  return *this;
}

StepInputs& StepInputs::add_content_if_there(std::string_view name, const std::filesystem::path& path) {
  return std::filesystem::exists(path) ? add_content(name, path) : add(name, "none");
}

StepInputs& StepInputs::add_source(std::string_view name, const std::string& source) {
  return add(name, source).add_content(fmt::format("{} content", name), parse_source_spec(source).path);
}

StepInputs& StepInputs::add_pipeline(const std::filesystem::path& pipeline) {
  add_content("pipeline", pipeline);
  const OptionTable document = OptionTable::load(pipeline);
  for (const char* table : {"segmentation", "estimator"}) {
    const std::string model = document.table(table).text_or("model", "");
    if (!model.empty()) add_content(fmt::format("{} model", table), document.resolved_path(model));
  }
  return *this;
}

std::string content_hash(const std::filesystem::path& file) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "rb"), std::fclose);
  if (!stream) fail("{}: cannot be read", file.string());
  const std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state(XXH3_createState(),
                                                                              XXH3_freeState);
  XXH3_128bits_reset(state.get());
  std::vector<char> block(std::size_t{1} << 20);
  while (const std::size_t length = std::fread(block.data(), 1, block.size(), stream.get())) {
    XXH3_128bits_update(state.get(), block.data(), length);
  }
  if (std::ferror(stream.get()) != 0) fail("{}: cannot be read", file.string());
  const XXH128_hash_t hash = XXH3_128bits_digest(state.get());
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

}  // namespace knuckle
