// SPDX-License-Identifier: Apache-2.0
#include "fuzz_target.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include <fcntl.h>
#include <unistd.h>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"
#include "knuckle/storage/deflate.h"

namespace knuckle::fuzz {
namespace {

constexpr std::array<FuzzTarget, 51> kTargets{{
    {"body", run_body},
    {"boxes", run_boxes},
    {"calibration", run_calibration},
    {"camera_messages", run_camera_messages},
    {"control", run_control},
    {"convention", run_convention},
    {"csv", run_csv},
    {"dataset_toml", run_dataset_toml},
    {"detector", run_detector},
    {"experiment_results", run_experiment_results},
    {"exr", run_exr},
    {"fakenect", run_fakenect},
    {"forest_checkpoint", run_forest_checkpoint},
    {"frame_log", run_frame_log},
    {"frame_note", run_frame_note},
    {"h5_set", run_h5_set},
    {"hdf5", run_hdf5},
    {"journal", run_journal},
    {"label_request", run_label_request},
    {"labels", run_labels},
    {"landmarks", run_landmarks},
    {"lines", run_lines},
    {"makehuman", run_makehuman},
    {"manifest", run_manifest},
    {"mat", run_mat},
    {"mcap", run_mcap},
    {"mkv", run_mkv},
    {"model", run_model},
    {"msra15", run_msra15},
    {"network", run_network},
    {"numbers", run_numbers},
    {"onnx", run_onnx},
    {"onnx_estimator", run_onnx_estimator},
    {"pipeline", run_pipeline},
    {"plan", run_plan},
    {"png", run_png},
    {"pose_forest", run_pose_forest},
    {"poses", run_poses},
    {"record", run_record},
    {"request", run_request},
    {"rosbag", run_rosbag},
    {"sample_index", run_sample_index},
    {"samples", run_samples},
    {"segmentation_forest", run_segmentation_forest},
    {"set_texts", run_set_texts},
    {"source", run_source},
    {"toml", run_toml},
    {"training_config", run_training_config},
    {"worker_samples", run_worker_samples},
    {"worker_talk", run_worker_talk},
    {"zip", run_zip},
}};

std::filesystem::path folder_in_memory() {
  const std::filesystem::path memory = "/dev/shm";
  return ::access(memory.c_str(), W_OK) == 0 ? memory : std::filesystem::temp_directory_path();
}

/// A name in this process that no other has.
std::filesystem::path new_name() {
  static int number = 0;
  return folder_in_memory() / ("knuckle_fuzz_" + std::to_string(::getpid()) + "_" + std::to_string(number++));
}

/// Ends the program where an Error says nothing, or what no person would read.
void check_message(std::string_view message) {
  constexpr std::size_t kLongest = 16 << 10;
  if (!message.empty() && message.size() <= kLongest && printable(message) == message) return;
  std::fprintf(stderr, "a message of %zu bytes: %.300s\n", message.size(), printable(message).c_str());
  std::abort();
}

}  // namespace

std::span<const FuzzTarget> fuzz_targets() {
  return kTargets;
}

void run_target(std::string_view name, Bytes bytes) {
  for (const FuzzTarget& target : kTargets) {
    if (target.name != name) continue;
    try {
      target.run(bytes);
    } catch (const Error& error) {
      check_message(error.what());
    }
    return;
  }
  std::fprintf(stderr, "no target of this name: %s\n", std::string(name).c_str());
  std::abort();
}

FuzzFile::FuzzFile(Bytes bytes, std::string_view extension) {
  path_ = new_name();
  path_ += extension;
  std::FILE* const file = std::fopen(path_.c_str(), "wb");
  if (file == nullptr || std::fwrite(bytes.data(), 1, bytes.size(), file) != bytes.size()) std::abort();
  std::fclose(file);
}

FuzzFile::~FuzzFile() {
  ::unlink(path_.c_str());
}

FuzzFolder::FuzzFolder() : path_(new_name()) {
  std::filesystem::create_directories(path_);
}

FuzzFolder::~FuzzFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

void FuzzFolder::write(const std::filesystem::path& name, std::string_view content) const {
  const std::filesystem::path file = path_ / name;
  std::filesystem::create_directories(file.parent_path());
  std::ofstream stream(file, std::ios::binary);
  stream << content;
  if (!stream.flush()) std::abort();
}

Selected selected(Bytes bytes, std::size_t count) {
  if (bytes.empty()) return {};
  return {static_cast<std::uint8_t>(bytes[0] - '0') % count, bytes.subspan(1)};
}

std::string with_sum(Bytes bytes) {
  constexpr std::size_t kDigits = 16;
  std::string content(as_text(bytes));
  if (content.size() < kDigits) return content;
  content.resize(content.size() - kDigits);
  return content + fmt::format("{:08x}{:08x}", crc32(as_bytes_of(content)), adler32(as_bytes_of(content)));
}

}  // namespace knuckle::fuzz
