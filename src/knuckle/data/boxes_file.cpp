// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/boxes_file.h"

#include <cstddef>
#include <limits>
#include <string>
#include <string_view>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"
#include "knuckle/core/text_file.h"

namespace knuckle {
namespace {

constexpr std::string_view kHeader = "frame,found,x,y,width,height,milliseconds";
constexpr std::size_t kColumns = 7;

int whole_number(std::string_view text, long long low, std::string_view where) {
  const long long value = parse_integer(text, where);
  constexpr long long kMost = 1'000'000;  // sums of two fit as well
  if (value < low || value > kMost) {
    fail("{}: {} is not in [{}, {}]", where, value, low, kMost);
  }
  return static_cast<int>(value);
}

Box box_in(std::string_view line, std::size_t frame, std::string_view where) {
  const std::vector<std::string_view> fields = split(line, ',');
  if (fields.size() != kColumns) fail("{}: {} columns, expected {}", where, fields.size(), kHeader);
  if (parse_integer(fields[0], where) != static_cast<long long>(frame)) {
    fail("{}: frame {}, expected {}", where, fields[0], frame);
  }
  const int found = whole_number(fields[1], 0, where);
  if (found > 1) fail("{}: found is {}, expected 0 or 1", where, found);
  if (found == 0) return {};
  constexpr long long kAnywhere = -1'000'000;
  const Box box{whole_number(fields[2], kAnywhere, where), whole_number(fields[3], kAnywhere, where),
                whole_number(fields[4], 1, where), whole_number(fields[5], 1, where)};
  return box;
}

}  // namespace

std::vector<Box> read_boxes_file(const std::filesystem::path& path) {
  std::vector<Box> boxes;
  bool has_header = false;
  const auto require_header = [&](bool is_there) {
    if (!is_there) fail("{}: no boxes, expected a first line {}", path.string(), kHeader);
  };
  visit_content_lines(path, [&](const FileLine& line) {
    if (has_header) {
      boxes.push_back(box_in(line.text, boxes.size(), line.where()));
    } else {
      require_header(trimmed(line.text) == kHeader);
    }
    has_header = true;
  });
  require_header(has_header);
  return boxes;
}

}  // namespace knuckle
