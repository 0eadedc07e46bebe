// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/csv_image.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <fmt/ranges.h>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/text.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

/// An image for that many numbers a line; before it takes much memory, each line has to be long enough for
/// them.
Image<float> image_for(std::size_t columns, const std::vector<std::string>& lines, const std::string& where) {
  if (columns > static_cast<std::size_t>(limits::kImageSide)) {
    fail("{}: has {} values, expected at most {}", where, columns, limits::kImageSide);
  }
  constexpr std::size_t kFew = 1 << 20;
  const auto shortest = std::ranges::min_element(lines, {}, &std::string::size);
  if (columns * lines.size() > kFew && columns > shortest->size() / 2 + 1) {
    fail("{}: has {} values, line {} is too short for as many", where, columns, shortest - lines.begin() + 1);
  }
  return {static_cast<int>(columns), static_cast<int>(lines.size())};
}

float checked_float(double number, const std::string& where) {
  if (std::abs(number) > static_cast<double>(std::numeric_limits<float>::max()) && !std::isinf(number)) {
    fail("{}: {} is too large for a depth", where, number);
  }
  return static_cast<float>(number);
}

}  // namespace

Image<float> read_csv_image(const std::filesystem::path& path) {
  std::vector<std::string> lines = read_lines(path);
  while (!lines.empty() && trimmed(lines.back()).empty()) lines.pop_back();
  if (lines.empty()) fail("{}: is empty", path.string());
  if (std::ssize(lines) > limits::kImageSide) {
    fail("{}: has {} rows, expected at most {}", path.string(), lines.size(), limits::kImageSide);
  }
  Image<float> image;
  for (std::size_t row = 0; row < lines.size(); ++row) {
    const std::string where = fmt::format("{}:{}", path.string(), row + 1);
    const std::vector<double> numbers = parse_numbers(lines[row], where, ",");
    if (row == 0) image = image_for(numbers.size(), lines, where);
    if (numbers.empty() || static_cast<int>(numbers.size()) != image.width())
      fail("{}: has {} values, expected {}", where, numbers.size(), std::max(image.width(), 1));
    std::ranges::transform(numbers, image.row(static_cast<int>(row)).begin(),
                           [&](double number) { return checked_float(number, where); });
  }
  return image;
}

void write_csv_image(const std::filesystem::path& path, const Image<float>& image) {
  std::string text;
  for (int row = 0; row < image.height(); ++row) text += fmt::format("{}\n", fmt::join(image.row(row), ","));
  write_text_file(path, text);
}

}  // namespace knuckle
