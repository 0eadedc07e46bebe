// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/report/html.h"

#include <fmt/format.h>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

/// Removes every part from `begin` to the next `end`, both included.
void remove_parts(std::string& text, std::string_view begin, std::string_view end) {
  for (std::size_t from = text.find(begin); from != std::string::npos; from = text.find(begin, from)) {
    const std::size_t to = text.find(end, from + begin.size());
    if (to == std::string::npos) return;
    text.erase(from, to + end.size() - from);
  }
}

}  // namespace

std::string html_escaped(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return escaped;
}

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) bits = bits << 8 | (k < count ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[bits >> (18 - 6 * k) & 63u] : '=';
  }
  return text;
}

std::string inline_svg(std::string_view svg_file, std::string_view label) {
  constexpr std::string_view kBegin = "<svg";
  const std::size_t begin = svg_file.find(kBegin);
  if (begin == std::string_view::npos) fail("{}: expected an SVG picture", label);
  std::string svg(svg_file.substr(begin + kBegin.size()));
  remove_parts(svg, "<defs>", "</defs>");  // gnuplot's point symbols, which our figures have none of
  remove_parts(svg, "<title>", "</title>");
  remove_parts(svg, "<desc>", "</desc>");
  remove_parts(svg, " id=\"", "\"");
  return fmt::format("<svg role=\"img\" aria-label=\"{}\"{}", html_escaped(label), svg);
}

}  // namespace knuckle
