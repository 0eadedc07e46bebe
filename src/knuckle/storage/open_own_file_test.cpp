// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/open_own_file.h"

#include <cerrno>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

TEST(OwnFileTest, IsMadeWhereAskedAndKeepsWhatIsInIt) {
  const TemporaryFolder folder;
  EXPECT_EQ(open_own_file(folder / "f.partial", 0), -1);
  EXPECT_EQ(errno, ENOENT);
  write_text_file(folder / "f.partial", "former");
  const int descriptor = open_own_file(folder / "f.partial", O_CREAT);
  ASSERT_GE(descriptor, 0);
  ::close(descriptor);
  EXPECT_EQ(read_text_file(folder / "f.partial"), "former");
}

TEST(OwnFileTest, ALinkIsNotFollowed) {
  const TemporaryFolder folder;
  write_text_file(folder / "others", "of another person");
  std::filesystem::create_symlink(folder / "others", folder / "f.partial");
  EXPECT_EQ(open_own_file(folder / "f.partial", O_CREAT), -1);
  EXPECT_EQ(errno, ELOOP);
  EXPECT_THAT(error_of([&] { open_own_file_alone(folder / "f.partial", O_CREAT, "is in use"); }),
              HasSubstr("f.partial: cannot write: "));
}

TEST(OwnFileTest, APipeIsRefusedAtOnce) {
  const TemporaryFolder folder;
  ASSERT_EQ(::mkfifo((folder / "f.partial").c_str(), 0600), 0);
  EXPECT_THAT(error_of([&] { open_own_file(folder / "f.partial", O_CREAT); }), HasSubstr("f.partial"));
}

TEST(OwnFileTest, IsOneRunsAloneUntilItIsClosed) {
  const TemporaryFolder folder;
  const auto open_alone = [&] { return open_own_file_alone(folder / "f.partial", O_CREAT, "is in use"); };
  const int first = open_alone();
  EXPECT_THAT(error_of(open_alone), HasSubstr("f.partial: is in use"));
  ::close(first);
  const int second = open_alone();
  EXPECT_GE(second, 0);
  ::close(second);
}

}  // namespace
}  // namespace knuckle
