// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/sample_file.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/parallel.h"
#include "knuckle/storage/content_hash.h"
#include "knuckle/storage/deflate.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/hdf5/hdf5_writer.h"

namespace knuckle {
namespace {

constexpr std::string_view kFormat = "knuckle-samples";
constexpr int kVersion = 1;
constexpr std::uint64_t kCoordinates = 3;
constexpr std::uint64_t kRowsAtOnce = 1024;

Hdf5File opened(const std::filesystem::path& path, const Inputs& inputs) {
  Hdf5File file = Hdf5File::open(path);
  file.require_format(kFormat, kVersion);
  if (file.text_attribute("inputs") != text_hash(inputs.text())) {
    fail("{}: holds samples of other sources or options", path.string());
  }
  return file;
}

/// Of all of a sample and its number.
std::uint64_t sum_of(std::uint64_t index, const CubeSample& sample) {
  std::uint64_t sum = content_sum(std::as_bytes(sample.codes), index);
  sum = content_sum(std::as_bytes(sample.joints), sum);
  return content_sum(std::as_bytes(std::span(sample.centre_mm.data(), kCoordinates)), sum);
}

void write_codes(Hdf5Writer& file, const CubeSamples& samples) {
  const auto count = static_cast<std::uint64_t>(samples.size());
  const auto crop = static_cast<std::uint64_t>(samples.crop_px());
  file.create_dataset<std::uint8_t>("codes", {count, crop, crop}, {.rows_per_chunk = 1, .deflate_level = 1});
  parallel_for(samples.size(), [&](std::int64_t i) {
    file.write_chunk("codes", static_cast<std::uint64_t>(i), deflated(samples.sample(i).codes));
  });
}

void write_arrays(Hdf5Writer& file, const CubeSamples& samples) {
  const auto count = static_cast<std::uint64_t>(samples.size());
  std::vector<float> joints;
  std::vector<double> centres;
  std::vector<std::uint64_t> sums;
  for (std::int64_t i = 0; i < samples.size(); ++i) {
    const CubeSample sample = samples.sample(i);
    joints.insert(joints.end(), sample.joints.begin(), sample.joints.end());
    centres.insert(centres.end(), sample.centre_mm.begin(), sample.centre_mm.end());
    sums.push_back(sum_of(static_cast<std::uint64_t>(i), sample));
  }
  file.write("joints", {count, static_cast<std::uint64_t>(samples.joint_count()), kCoordinates},
             joints.data());
  file.write("centres_mm", {count, kCoordinates}, centres.data());
  file.write("sums", {count}, sums.data());
}

}  // namespace

void write_samples(const std::filesystem::path& path, const NetworkSamples& samples, const Inputs& inputs) {
  write_file_atomically(path, [&](const std::filesystem::path& temporary) {
    Hdf5Writer file = Hdf5Writer::create(temporary);
    const auto& [cut, frames] = samples;
    file.set_attribute("format", kFormat);
    file.set_attribute("version", double{kVersion});
    file.set_attribute("inputs", text_hash(inputs.text()));
    file.set_attribute("patch", {static_cast<double>(cut.patch().size_px), cut.patch().side_mm});
    file.set_attribute("frames", {static_cast<double>(frames.total), static_cast<double>(frames.without_hand),
                                  static_cast<double>(frames.off_centre)});
    write_codes(file, cut);
    write_arrays(file, cut);
    file.close();
  });
}

NetworkSamples read_samples(const std::filesystem::path& path, const Inputs& inputs) {
  const SampleFile file(path, inputs);
  return {file.read(), file.frames()};
}

SampleFile::SampleFile(const std::filesystem::path& path, const Inputs& inputs)
    : file_(opened(path, inputs)),
      joints_(file_.read<float>("joints")),
      centres_(file_.read<double>("centres_mm")) {
  read_frames();
  if (file_.has("sums")) sums_ = file_.read<std::uint64_t>("sums").values;
  const std::vector<std::uint64_t> codes = file_.shape("codes");
  const std::vector<double> patch = file_.numbers_attribute("patch");
  const bool fits =
      codes.size() == 3 && codes[1] == codes[2] && patch.size() == 2 && joints_.shape.size() == 3 &&
      joints_.shape[0] == codes[0] && joints_.shape[2] == kCoordinates &&
      centres_.shape == std::vector{codes[0], kCoordinates} && (sums_.empty() || sums_.size() == codes[0]);
  if (!fits) damaged("the shapes of its arrays do not fit together");
  check_numbers();
  count_ = codes[0];
  crop_px_ = static_cast<int>(codes[1]);
  if (codes[1] > static_cast<std::uint64_t>(limits::kImageSide) ||
      !(patch[0] >= 1 && patch[0] <= limits::kImageSide && patch[1] > 0 && std::isfinite(patch[1])) ||
      joints_.shape[1] > static_cast<std::uint64_t>(limits::kJoints)) {
    damaged("its patch or its joints are out of range");
  }
  patch_ = {static_cast<int>(patch[0]), patch[1]};
}

void SampleFile::read_frames() {
  const std::vector<double> frames = file_.numbers_attribute("frames");
  const auto is_count = [](double x) { return x >= 0 && x <= static_cast<double>(limits::kFrames); };
  if (frames.size() != 3 || !std::ranges::all_of(frames, is_count)) {
    fail("{}: `frames` has {} numbers, expected 3 numbers of frames", file_.path().string(), frames.size());
  }
  frames_ = {static_cast<std::int64_t>(frames[0]), static_cast<std::int64_t>(frames[1]),
             static_cast<std::int64_t>(frames[2])};
}

void SampleFile::check_numbers() const {
  if (!std::ranges::all_of(centres_.values, [](double x) { return std::isfinite(x); })) {
    damaged("a centre is not finite");
  }
  if (std::ranges::any_of(joints_.values, [](float x) { return std::isinf(x); })) {
    damaged("a joint is infinitely far away");
  }
}

void SampleFile::damaged(std::string_view why) const {
  fail("{}: {}; remove the file, and it is made anew", file_.path().string(), why);
}

CubeSamples SampleFile::room_for(std::int64_t count) const {
  return {count, static_cast<int>(joints_.shape[1]), patch_, crop_px_};
}

bool SampleFile::has_sizes_of(const CubeSamples& samples) const {
  return samples.crop_px() == crop_px_ && samples.patch().size_px == patch_.size_px &&
         samples.patch().side_mm == patch_.side_mm &&
         static_cast<std::uint64_t>(samples.joint_count()) == joints_.shape[1];
}

CubeSamples SampleFile::read() const {
  CubeSamples samples = room_for(size());
  std::vector<std::uint8_t> codes(std::min(kRowsAtOnce, count_) * pixels());
  for (std::uint64_t first = 0; first < count_; first += kRowsAtOnce) {
    const std::uint64_t rows = std::min(kRowsAtOnce, count_ - first);
    file_.read_rows("codes", first, rows, codes.data());
    for (std::uint64_t row = 0; row < rows; ++row) {
      const CubeSample read = sample(first + row, std::span(codes).subspan(row * pixels(), pixels()));
      check_sum(first + row, read);
      samples.set(static_cast<std::int64_t>(first + row), read);
    }
  }
  samples.finish();
  return samples;
}

void SampleFile::read(std::span<const std::int64_t> numbers, CubeSamples& to, std::int64_t first) const {
  if (!has_sizes_of(to)) damaged("its samples have other sizes than those of other files");
  std::vector<std::uint8_t> codes(pixels());
  for (const std::int64_t number : numbers) {
    const auto row = static_cast<std::uint64_t>(number);
    file_.read_rows("codes", row, 1, codes.data());
    const CubeSample read = sample(row, codes);
    check_sum(row, read);
    to.set(first++, read);
  }
}

CubeSample SampleFile::sample(std::uint64_t index, std::span<const std::uint8_t> codes) const {
  const std::uint64_t numbers = joints_.shape[1] * kCoordinates;
  return {codes, std::span(joints_.values).subspan(index * numbers, numbers),
          Point3(centres_.values.data() + index * kCoordinates)};
}

void SampleFile::check_sum(std::uint64_t index, const CubeSample& sample) const {
  if (sums_.empty() || sums_[index] == sum_of(index, sample)) return;
  damaged(fmt::format("sample {} is damaged", index));
}

}  // namespace knuckle
