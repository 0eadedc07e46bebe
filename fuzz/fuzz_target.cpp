// SPDX-License-Identifier: Apache-2.0
#include "fuzz_target.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>

#include <fcntl.h>
#include <unistd.h>

#include "knuckle/core/error.h"

namespace knuckle::fuzz {
namespace {

constexpr std::array<FuzzTarget, 36> kTargets{{
    {"body", run_body},
    {"boxes", run_boxes},
    {"calibration", run_calibration},
    {"camera_messages", run_camera_messages},
    {"control", run_control},
    {"csv", run_csv},
    {"dataset_toml", run_dataset_toml},
    {"exr", run_exr},
    {"fakenect", run_fakenect},
    {"frame_log", run_frame_log},
    {"h5_set", run_h5_set},
    {"hdf5", run_hdf5},
    {"journal", run_journal},
    {"label_request", run_label_request},
    {"labels", run_labels},
    {"lines", run_lines},
    {"manifest", run_manifest},
    {"mat", run_mat},
    {"mcap", run_mcap},
    {"mkv", run_mkv},
    {"model", run_model},
    {"msra15", run_msra15},
    {"network", run_network},
    {"numbers", run_numbers},
    {"onnx", run_onnx},
    {"png", run_png},
    {"pose_forest", run_pose_forest},
    {"poses", run_poses},
    {"record", run_record},
    {"request", run_request},
    {"rosbag", run_rosbag},
    {"segmentation_forest", run_segmentation_forest},
    {"source", run_source},
    {"toml", run_toml},
    {"worker_samples", run_worker_samples},
    {"zip", run_zip},
}};

std::filesystem::path folder_in_memory() {
  const std::filesystem::path memory = "/dev/shm";
  return ::access(memory.c_str(), W_OK) == 0 ? memory : std::filesystem::temp_directory_path();
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
      if (*error.what() == '\0') std::abort();  // an Error says something
    }
    return;
  }
  std::fprintf(stderr, "no target of this name: %s\n", std::string(name).c_str());
  std::abort();
}

FuzzFile::FuzzFile(Bytes bytes, std::string_view extension) {
  static int number = 0;
  path_ = folder_in_memory() / ("knuckle_fuzz_" + std::to_string(::getpid()) + "_" +
                                std::to_string(number++) + std::string(extension));
  std::FILE* const file = std::fopen(path_.c_str(), "wb");
  if (file == nullptr || std::fwrite(bytes.data(), 1, bytes.size(), file) != bytes.size()) std::abort();
  std::fclose(file);
}

FuzzFile::~FuzzFile() {
  ::unlink(path_.c_str());
}

}  // namespace knuckle::fuzz
