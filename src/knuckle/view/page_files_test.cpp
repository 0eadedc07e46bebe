// SPDX-License-Identifier: Apache-2.0
#include "knuckle/view/page_files.h"

#include <fstream>

#include "knuckle/core/testing.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

using testing::error_of;

void put(const fs::path& path, std::string_view text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path) << text;
}

TEST(PageFiles, AreThoseOfAPageAndNoOthers) {
  const testing::TemporaryFolder folder;
  const fs::path page = folder / "page";
  put(folder / "secret.txt", "secret");
  put(page / "index.html", "<!doctype html>");
  put(page / "app.js", "1;");
  put(page / "parts/icon-2.svg", "<svg/>");
  put(page / "app.cpp", "no");
  put(page / ".hidden.js", "no");
  put(page / ".git/config.txt", "no");
  put(page / "a b.js", "no");
  put(page / "a%2e.js", "no");
  fs::create_symlink(folder / "secret.txt", page / "link.txt");
  fs::create_directory_symlink(folder.path(), page / "all");
  const PageFiles files = read_page_files(page);
  std::vector<std::string> names;
  for (const auto& [name, file] : files) names.push_back(name);
  EXPECT_THAT(names, ::testing::ElementsAre("/", "/app.js", "/index.html", "/parts/icon-2.svg"));
  EXPECT_EQ(files.at("/").bytes, "<!doctype html>");
  EXPECT_EQ(files.at("/").content_type, "text/html; charset=utf-8");
  EXPECT_EQ(files.at("/app.js").content_type, "text/javascript; charset=utf-8");
  EXPECT_EQ(files.at("/parts/icon-2.svg").content_type, "image/svg+xml");
}

TEST(PageFiles, NeedNotBeThere) {
  const testing::TemporaryFolder folder;
  EXPECT_TRUE(read_page_files(folder / "none").empty());
  EXPECT_TRUE(read_page_files(folder.path()).empty());
  EXPECT_TRUE(read_page_files("").empty());
}

TEST(PageFiles, AreNotTooMany) {
  const testing::TemporaryFolder folder;
  for (int i = 0; i < 257; ++i) put(folder / fmt::format("{}.js", i), "");
  EXPECT_THAT(error_of([&] { read_page_files(folder.path()); }), ::testing::HasSubstr("256 files"));
  fs::remove(folder / "0.js");
  EXPECT_EQ(read_page_files(folder.path()).size(), 256U);
  fs::resize_file(folder / "1.js", (64U << 20U) + 1);
  EXPECT_THAT(error_of([&] { read_page_files(folder.path()); }), ::testing::HasSubstr("67108864 bytes"));
}

}  // namespace
}  // namespace knuckle
