// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace knuckle {

/// All numbers in `text`, parted by blanks or `separators`; empty fields between blanks do not count, nor
/// does a trailing separator. `nan` (any case) is a number. Throws an Error that starts with `where` and
/// quotes the first field that is none. `where` is "file" or "file:line".
std::vector<double> parse_numbers(std::string_view text, std::string_view where,
                                  std::string_view separators = ",;");

/// One number, the whole text. Throws an Error that starts with `where`.
double parse_number(std::string_view text, std::string_view where);

/// One whole number, the whole text. Throws an Error that starts with `where`.
long long parse_integer(std::string_view text, std::string_view where);

/// The parts of `text` between separators; empty parts are kept.
std::vector<std::string_view> split(std::string_view text, char separator);

/// `text` without blanks at both ends.
std::string_view trimmed(std::string_view text);

/// `text` with A to Z as a to z; other characters stay.
std::string lower_case(std::string_view text);

/// `text` as it may be shown on a terminal: control characters, characters that change the direction of
/// writing, and bytes that are no UTF-8 as \\n, \\t, \\xNN or \\u{NNNN}.
std::string printable(std::string_view text);

/// `text`, or its beginning and end with "..." between, where it has more than `most` bytes: these are all
/// then. Characters of UTF-8 stay whole. `most` is 8 or more.
std::string shortened(std::string_view text, std::size_t most);

/// `text` as one line of a message: printable and shortened, so that no file can fill a terminal.
std::string message_line(std::string_view text);

/// "a, b, c".
std::string joined(const std::vector<std::string>& parts, std::string_view separator = ", ");

}  // namespace knuckle
