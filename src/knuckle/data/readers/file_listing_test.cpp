// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/file_listing.h"

#include <sys/stat.h>

#include "knuckle/core/testing.h"
#include "knuckle/data/readers/data_testing.h"
#include "knuckle/data/readers/exr_image.h"
#include "knuckle/data/readers/icg_source.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

using ::testing::ElementsAre;
using testing::error_of;
using ::testing::HasSubstr;
using testing::put_file;

TEST(FileListing, LeavesNothingOutThatIsNamedLikeAFile) {
  const testing::TemporaryFolder folder;
  put_file(folder / "a.png", "");
  ASSERT_EQ(::mkfifo((folder / "b.png").c_str(), 0600), 0);
  fs::create_symlink("nothing", folder / "c.png");
  fs::create_symlink("a.png", folder / "d.png");
  fs::create_directory(folder / "e.png");
  fs::create_directory_symlink("e.png", folder / "f.png");
  put_file(folder / "e.png" / "g.png", "");
  EXPECT_THAT(list_files(folder.path(), "", ".png"), ElementsAre("a.png", "b.png", "c.png", "d.png"));
  EXPECT_THAT(list_files_below(folder.path(), ".png"),
              ElementsAre("a.png", "b.png", "c.png", "d.png", "e.png/g.png"));
}

TEST(FileListing, LabelsThatAreNoFileAreAFaultOfTheirFrame) {
  const testing::TemporaryFolder folder;
  put_file(folder / "calib.txt", "20 20\n2 2\n");
  write_exr(folder / "0_depth_1.exr", Image<float>(4, 4, 0.4f));
  ASSERT_EQ(::mkfifo((folder / "0_anno_ann.txt").c_str(), 0600), 0);
  const IcgSource source(folder.path(), {});
  EXPECT_TRUE(source.convention().has_value());
  EXPECT_THAT(error_of([&] { source.read(0); }), HasSubstr("0_anno_ann.txt: expected a file, found a FIFO"));
}

}  // namespace
}  // namespace knuckle
