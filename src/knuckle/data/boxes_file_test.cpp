// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/boxes_file.h"

#include <fstream>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

constexpr const char* kHeader = "frame,found,x,y,width,height,milliseconds\n";

TEST(BoxesFile, ReadsBoxesAndFramesWithoutOne) {
  const TemporaryFolder folder;
  std::ofstream(folder / "b.csv") << kHeader << "0,1,10,20,30,40,0.512\n1,0,0,0,0,0,0.100\r\n2,1,0,0,1,1,2\n";
  const std::vector<Box> boxes = read_boxes_file(folder / "b.csv");
  EXPECT_EQ(boxes, (std::vector<Box>{{10, 20, 30, 40}, {}, {0, 0, 1, 1}}));
}

TEST(BoxesFile, NamesTheFault) {
  const TemporaryFolder folder;
  const auto fault_of = [&](const std::string& text) {
    std::ofstream(folder / "b.csv") << text;
    return error_of([&] { (void)read_boxes_file(folder / "b.csv"); });
  };
  const std::string head = kHeader;
  EXPECT_THAT(fault_of("1 2 3\n"), AllOf(HasSubstr("b.csv"), HasSubstr("frame,found,x,y")));
  EXPECT_THAT(fault_of(head + "0,1,1,1,5,5\n"), AllOf(HasSubstr("b.csv:2"), HasSubstr("6 columns")));
  EXPECT_THAT(fault_of(head + "0,1,1,1,5,5,1\n2,1,1,1,5,5,1\n"), HasSubstr("b.csv:3: frame 2, expected 1"));
  EXPECT_THAT(fault_of(head + "0,2,1,1,5,5,1\n"), HasSubstr("found is 2"));
  EXPECT_THAT(fault_of(head + "0,1,1,1,0,5,1\n"), HasSubstr("0 is not in [1,"));
  EXPECT_THAT(fault_of(head + "0,1,x,1,5,5,1\n"), HasSubstr("b.csv:2"));
  EXPECT_THAT(error_of([&] { (void)read_boxes_file(folder / "none.csv"); }), HasSubstr("none.csv"));
}

}  // namespace
}  // namespace knuckle
