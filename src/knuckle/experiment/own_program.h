// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace knuckle {

/// Runs this very program with other arguments, as in {"train", "network", ...}, and waits for its end.
/// Its output appears as ours. It ends with us, however we end. Throws an Error with what its error line says
/// where it fails, or with the last line of its error output where it has none. `starter` is a command that
/// starts the program, as in {"srun", "--ntasks=2"}; empty: none is needed.
///
/// "This very program" is what the process runs: the module `experiment` is part of the program `knuckle`
/// alone, not of the libraries, so that it is never the program of a user.
void run_own_program(const std::vector<std::string>& arguments, const std::vector<std::string>& starter = {});

/// The file of this very program.
std::string own_program_file();

}  // namespace knuckle
