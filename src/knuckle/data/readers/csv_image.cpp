// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/csv_image.h"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/ranges.h>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {

Image<float> read_csv_image(const std::filesystem::path& path) {
  std::vector<std::string> lines = read_lines(path);
  while (!lines.empty() && trimmed(lines.back()).empty()) lines.pop_back();
  if (lines.empty()) fail("{}: is empty", path.string());
  Image<float> image;
  for (std::size_t row = 0; row < lines.size(); ++row) {
    const std::string where = fmt::format("{}:{}", path.string(), row + 1);
    const std::vector<double> numbers = parse_numbers(lines[row], where, ",");
    if (row == 0) image = Image<float>(static_cast<int>(numbers.size()), static_cast<int>(lines.size()));
    if (numbers.empty() || static_cast<int>(numbers.size()) != image.width())
      fail("{}: has {} values, expected {}", where, numbers.size(), std::max(image.width(), 1));
    std::ranges::transform(numbers, image.row(static_cast<int>(row)).begin(),
                           [](double number) { return static_cast<float>(number); });
  }
  return image;
}

void write_csv_image(const std::filesystem::path& path, const Image<float>& image) {
  std::string text;
  for (int row = 0; row < image.height(); ++row) text += fmt::format("{}\n", fmt::join(image.row(row), ","));
  write_text_file(path, text);
}

}  // namespace knuckle
