// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace knuckle {

/// `text` for HTML: in content and in attributes with quotes. Control characters become blanks.
std::string html_escaped(std::string_view text);

/// Base 64 (RFC 4648), with padding.
std::string base64(std::span<const std::uint8_t> bytes);

/// The `<svg>` element of an SVG file, to stand inside a page among others: without XML head, own identifiers
/// and unused definitions, named `label` for screen readers.
std::string inline_svg(std::string_view svg_file, std::string_view label);

}  // namespace knuckle
