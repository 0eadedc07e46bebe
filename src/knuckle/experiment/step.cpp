// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/step.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <xxhash.h>

#include "knuckle/core/error.h"
#include "knuckle/core/file_io.h"

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

std::filesystem::path inputs_file_of(const std::filesystem::path& output) {
  return output.string() + ".inputs";
}

bool is_made_from(const std::filesystem::path& output, const StepInputs& inputs) {
  const std::filesystem::path record = inputs_file_of(output);
  return std::filesystem::exists(output) && std::filesystem::exists(record) &&
         read_text_file(record) == inputs.text();
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

StepOutcome run_step(const std::filesystem::path& output, const StepInputs& inputs,
                     const std::function<void()>& work) {
  if (is_made_from(output, inputs)) return StepOutcome::kept;
  // The record goes first: a run that is stopped between here and the new record leaves an output that is
  // known to be of unknown inputs.
  std::filesystem::remove(inputs_file_of(output));
  make_folder(output.parent_path());
  work();
  write_text_file(inputs_file_of(output), inputs.text());
  return StepOutcome::done;
}

}  // namespace knuckle
