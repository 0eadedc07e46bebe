// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
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
/// printable line, which is not longer than a person would read.
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

/// An empty folder, in memory where the machine has such a place, for readers of several files. It goes with
/// its owner, and all in it.
class FuzzFolder {
 public:
  FuzzFolder();
  ~FuzzFolder();
  FuzzFolder(const FuzzFolder&) = delete;
  FuzzFolder& operator=(const FuzzFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// Makes a file in it, or replaces it, and the folders above it.
  void write(const std::filesystem::path& name, std::string_view content) const;

 private:
  std::filesystem::path path_;
};

/// A byte that says which of several readers gets what follows it.
struct Selected {
  std::size_t which = 0;  ///< [0, count)
  Bytes rest;
};
/// Which of `count` readers the first byte names: '0' the first, '1' the second, and so on. Nothing is the
/// first.
Selected selected(Bytes bytes, std::size_t count);

inline std::string_view as_text(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

inline Bytes as_bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// A model's file with a sum that fits, so that what lies after it is reached.
std::string with_sum(Bytes bytes);

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
void run_worker_talk(Bytes bytes);
void run_detector(Bytes bytes);
void run_forest_checkpoint(Bytes bytes);
void run_onnx_estimator(Bytes bytes);
void run_samples(Bytes bytes);
void run_sample_index(Bytes bytes);
void run_convention(Bytes bytes);
void run_landmarks(Bytes bytes);
void run_pipeline(Bytes bytes);
void run_training_config(Bytes bytes);
void run_plan(Bytes bytes);
void run_set_texts(Bytes bytes);
void run_frame_note(Bytes bytes);
void run_experiment_results(Bytes bytes);
void run_makehuman(Bytes bytes);

}  // namespace knuckle::fuzz
