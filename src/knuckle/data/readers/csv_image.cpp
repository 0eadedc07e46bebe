// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/csv_image.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <fmt/ranges.h>

#include "knuckle/core/error.h"
#include "knuckle/core/image_size.h"
#include "knuckle/core/text.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

float checked_float(double number, const std::string& where) {
  if (std::abs(number) > static_cast<double>(std::numeric_limits<float>::max()) && !std::isinf(number)) {
    fail("{}: {} is too large for a depth", where, number);
  }
  return static_cast<float>(number);
}

/// The rows so far. Memory grows with the values that were read, not with what the first row promises.
struct CsvRows {
  std::size_t columns = 0;
  std::size_t count = 0;
  std::vector<float> values;

  void add(std::string_view line, const std::string& where) {
    const std::vector<double> numbers = parse_numbers(line, where, ",");
    if (count == 0) columns = numbers.size();
    if (numbers.empty() || numbers.size() != columns) {
      fail("{}: has {} values, expected {}", where, numbers.size(), std::max<std::size_t>(columns, 1));
    }
    ++count;
    require_image_size({static_cast<std::int64_t>(columns), static_cast<std::int64_t>(count)}, where);
    for (const double number : numbers) values.push_back(checked_float(number, where));
  }
};

}  // namespace

Image<float> read_csv_image(const std::filesystem::path& path) {
  CsvRows rows;
  std::string blank;  // where the first of blank lines is, which only the file's end may follow
  visit_lines(path, [&](const FileLine& line) {
    if (trimmed(line.text).empty()) {
      if (blank.empty()) blank = line.where();
      return;
    }
    if (!blank.empty()) rows.add("", blank);
    rows.add(line.text, line.where());
  });
  if (rows.count == 0) fail("{}: is empty", path.string());
  Image<float> image(static_cast<int>(rows.columns), static_cast<int>(rows.count));
  std::ranges::copy(rows.values, image.data());
  return image;
}

void write_csv_image(const std::filesystem::path& path, const Image<float>& image) {
  std::string text;
  for (int row = 0; row < image.height(); ++row) text += fmt::format("{}\n", fmt::join(image.row(row), ","));
  write_text_file(path, text);
}

}  // namespace knuckle
