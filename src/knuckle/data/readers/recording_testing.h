// SPDX-License-Identifier: Apache-2.0
// Helpers of the tests of recordings only.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <bzlib.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include "knuckle/core/error.h"
#include "knuckle/core/random.h"
#include "knuckle/data/frame_source.h"

namespace knuckle::testing {

/// A whole number, its lowest byte first.
template <class T>
std::string little(T value) {
  std::string bytes;
  for (std::size_t i = 0; i < sizeof(T); ++i)
    bytes += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xFF);
  return bytes;
}

inline std::string little_double(double value) {
  return little(std::bit_cast<std::uint64_t>(value));
}

inline std::string with_length(const std::string& bytes) {
  return little(static_cast<std::uint32_t>(bytes.size())) + bytes;
}

/// By bz2, zstd, lz4 or zlib; as they are by any other name.
inline std::string packed(const std::string& bytes, const std::string& compression) {
  if (compression == "bz2") {
    std::string out(bytes.size() + bytes.size() / 50 + 1000, '\0');
    auto length = static_cast<unsigned>(out.size());
    BZ2_bzBuffToBuffCompress(out.data(), &length, const_cast<char*>(bytes.data()),
                             static_cast<unsigned>(bytes.size()), 9, 0, 0);
    return out.substr(0, length);
  }
  if (compression == "zstd") {
    std::string out(ZSTD_compressBound(bytes.size()), '\0');
    return out.substr(0, ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 3));
  }
  if (compression == "lz4") {
    std::string out(LZ4F_compressFrameBound(bytes.size(), nullptr), '\0');
    return out.substr(0, LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), nullptr));
  }
  if (compression == "zlib") {
    uLongf length = compressBound(bytes.size());
    std::string out(length, '\0');
    compress(reinterpret_cast<Bytef*>(out.data()), &length, reinterpret_cast<const Bytef*>(bytes.data()),
             bytes.size());
    return out.substr(0, length);
  }
  return bytes;
}

struct TestImage {
  std::uint32_t width = 8;
  std::uint32_t height = 6;
  std::string encoding = "16UC1";
  bool is_big_endian = false;
  std::uint32_t padding = 0;  ///< bytes at the end of each row
  double stamp_s = 0.0;
  std::uint32_t bytes = 2;  ///< of a pixel, 1 or 2

  std::uint32_t step() const { return bytes * width + padding; }
};

/// The rows of an image: pixel (column, row) is `first` + column + 10 row.
inline std::string pixels_of(const TestImage& image, int first) {
  std::string pixels;
  for (std::uint32_t row = 0; row < image.height; ++row) {
    for (std::uint32_t column = 0; column < image.width; ++column) {
      std::string pixel = little(static_cast<std::uint16_t>(first + static_cast<int>(column + 10 * row)));
      if (image.is_big_endian) std::swap(pixel[0], pixel[1]);
      pixels += pixel.substr(0, image.bytes);
    }
    pixels += std::string(image.padding, '\x55');
  }
  return pixels;
}

struct TestCameraInfo {
  std::uint32_t width = 8;
  std::uint32_t height = 6;
  std::string model = "plumb_bob";
  std::vector<double> d{0.1, -0.2, 0.003, 0.004, 0.05};
  std::array<double, 9> k{7.5, 0, 3.25, 0, 7.25, 2.5, 0, 0, 1};
  std::array<double, 12> p{7.0, 0, 3.0, 0, 0, 6.5, 2.0, 0, 0, 0, 1, 0};
};

/// That 200 frames at random places are those of a straight reading, infrared images too.
inline void expect_random_places_as_straight(const FrameSource& source, const FrameSource& again) {
  std::vector<Frame> straight;
  for (std::int64_t i = 0; i < source.size(); ++i) straight.push_back(source.read(i));
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const std::uint32_t index = random.below(static_cast<std::uint32_t>(straight.size()));
    const Frame frame = again.read(index);
    ASSERT_EQ(frame.depth_mm, straight[index].depth_mm) << index;
    ASSERT_EQ(frame.infrared, straight[index].infrared) << index;
  }
}

/// That four threads read the frames of one source, whose first pixels are 500 mm, 501 mm and so on.
inline void expect_many_threads_may_read(const FrameSource& source) {
  std::vector<std::thread> threads;
  std::array<int, 4> wrong{};
  for (std::size_t thread = 0; thread < wrong.size(); ++thread) {
    threads.emplace_back([&, thread] {
      Random random(thread);
      for (int i = 0; i < 200; ++i) {
        const std::int64_t index = random.below(static_cast<std::uint32_t>(source.size()));
        wrong[thread] += source.read(index).depth_mm(0, 0) == 500 + static_cast<float>(index) ? 0 : 1;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, (std::array<int, 4>{}));
}

/// That what `open` gives is read to its end, or refused with the name of its file.
template <class Open>
void expect_read_or_refused(const Open& open, const std::filesystem::path& path) {
  try {
    const auto source = open();
    for (std::int64_t frame = 0; frame < source.size(); ++frame) (void)source.read(frame);
  } catch (const Error& error) {
    ASSERT_THAT(error.what(), ::testing::HasSubstr(path.filename().string()));
  }
}

/// `count` copies of a file, in each of which one to three bytes were changed.
inline std::vector<std::string> damaged_copies(const std::string& whole, int count) {
  std::vector<std::string> copies;
  Random random(5);
  for (int i = 0; i < count; ++i) {
    std::string& damaged = copies.emplace_back(whole);
    for (int change = 0; change <= i % 3; ++change) {
      damaged[random.below(static_cast<std::uint32_t>(damaged.size()))] =
          static_cast<char>(random.below(256));
    }
  }
  return copies;
}

}  // namespace knuckle::testing
