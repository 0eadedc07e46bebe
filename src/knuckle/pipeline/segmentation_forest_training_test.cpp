// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/segmentation_forest_training.h"

#include <fstream>

#include "knuckle/core/testing.h"
#include "knuckle/data/folder_writer.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

}  // namespace
}  // namespace knuckle
