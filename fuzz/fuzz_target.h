// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

namespace knuckle::fuzz {

using Bytes = std::span<const std::uint8_t>;

/// A reader or parser that takes any bytes: it may throw an Error, and nothing else.
struct FuzzTarget {
  std::string_view name;  ///< of its corpus below fuzz/corpus, too
  void (*run)(Bytes bytes);
};

/// All targets.
std::span<const FuzzTarget> fuzz_targets();

/// Hands the bytes to the target of that name; ends the program where it throws anything but an Error of one
/// line.
void run_target(std::string_view name, Bytes bytes);

/// A file with these bytes, in memory where the machine has such a place, for readers that open files by
/// their name. It goes with its owner.
class FuzzFile {
 public:
  FuzzFile(Bytes bytes, std::string_view extension);
  ~FuzzFile();
  FuzzFile(const FuzzFile&) = delete;
  FuzzFile& operator=(const FuzzFile&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline std::string_view as_text(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

inline Bytes as_bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

// The targets, by what they read.
void run_zip(Bytes bytes);
void run_model(Bytes bytes);
void run_pose_forest(Bytes bytes);
void run_segmentation_forest(Bytes bytes);
void run_body(Bytes bytes);
void run_network(Bytes bytes);
void run_onnx(Bytes bytes);
void run_hdf5(Bytes bytes);
void run_h5_set(Bytes bytes);
void run_png(Bytes bytes);
void run_exr(Bytes bytes);
void run_csv(Bytes bytes);
void run_mat(Bytes bytes);
void run_msra15(Bytes bytes);
void run_lines(Bytes bytes);
void run_toml(Bytes bytes);
void run_dataset_toml(Bytes bytes);
void run_manifest(Bytes bytes);
void run_numbers(Bytes bytes);
void run_poses(Bytes bytes);
void run_boxes(Bytes bytes);
void run_record(Bytes bytes);
void run_source(Bytes bytes);
void run_calibration(Bytes bytes);
void run_journal(Bytes bytes);
void run_frame_log(Bytes bytes);
void run_camera_messages(Bytes bytes);
void run_fakenect(Bytes bytes);
void run_rosbag(Bytes bytes);
void run_mcap(Bytes bytes);
void run_mkv(Bytes bytes);
void run_control(Bytes bytes);
void run_request(Bytes bytes);
void run_labels(Bytes bytes);
void run_label_request(Bytes bytes);
void run_worker_samples(Bytes bytes);

}  // namespace knuckle::fuzz
