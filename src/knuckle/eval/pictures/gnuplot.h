// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace knuckle {

/// Runs gnuplot on a script, without the user's own settings and without a shell. Throws an Error of one line
/// that says so where gnuplot is not installed, or that holds gnuplot's complaint.
void run_gnuplot(std::string_view script);

/// `text` as a gnuplot string constant in which nothing is expanded or executed: every character that could
/// mean something to gnuplot is written as an octal escape. Control characters become blanks.
std::string gnuplot_quoted(std::string_view text);

}  // namespace knuckle
