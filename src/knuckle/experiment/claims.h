// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "knuckle/experiment/scores.h"

namespace knuckle {

/// Whether results bear a published claim out.
enum class Verdict {
  agrees,     ///< on every sequence
  in_part,    ///< on some
  disagrees,  ///< on none
  unknown,    ///< a method that it speaks of is not in the experiment
};

/// "agrees", "in part", "disagrees", "not known".
std::string name_of(Verdict verdict);

/// A claim and what the results say of it.
struct Claim {
  std::string statement;
  std::string test;  ///< what has to hold on a sequence
  Verdict verdict = Verdict::unknown;
  std::vector<std::string> evidence;  ///< the numbers, a line per sequence; or what is missing
};

/// The seven claims of Riegler et al. 2015, section 5. Methods are known by their names in the plan
/// experiments/scia15.toml.
std::vector<Claim> scia15_claims(const ExperimentScores& scores);

/// claim, verdict, evidence.
std::string claims_csv(const std::vector<Claim>& claims);

}  // namespace knuckle
