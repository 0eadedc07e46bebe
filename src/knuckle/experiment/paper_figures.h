// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "knuckle/eval/pictures/figures.h"
#include "knuckle/experiment/scores.h"

namespace knuckle {

/// Figure 4 of Riegler et al. 2015, a panel a sensor: frames whose box overlaps the true one by more than t.
std::vector<Figure> figure4(const ExperimentScores& scores);

/// The rows of Figure 5, a panel a sensor.
struct Figure5 {
  std::vector<Figure> joints_2d;          ///< mean 2D error of each joint
  std::vector<Figure> joints_3d;          ///< mean 3D error of each joint
  std::vector<Figure> all_joints_within;  ///< frames whose joints are all within D
};
/// A figure a sequence in each row.
Figure5 figure5(const ExperimentScores& scores);

}  // namespace knuckle
