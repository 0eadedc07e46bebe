// SPDX-License-Identifier: Apache-2.0
// The readers of ICVL, MSRA15 and HANDS17, on tiny sets in their documented layout and on real frames.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "knuckle/core/testing.h"
#include "knuckle/data/readers/data_testing.h"
#include "knuckle/data/readers/hands17_source.h"
#include "knuckle/data/readers/icvl_source.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/data/readers/msra15_source.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::numbers_text;
using testing::put_file;

// --- ICVL ---

void put_icvl(const fs::path& folder) {
  make_folder(folder / "Depth" / "seq");
  Image<std::uint16_t> image(320, 240, 400);
  image(7, 8) = 32001;
  image(8, 8) = 0;
  write_png(folder / "Depth" / "seq" / "image_0000.png", image);
  put_file(folder / "labels.txt", "seq/image_0000.png " + numbers_text(48, 1.5) + " \r\n\r\n");
}

TEST(Icvl, ReadsDepthAndLabels) {
  const testing::TemporaryFolder folder;
  put_icvl(folder.path());
  const IcvlSource source(folder.path(), {});
  ASSERT_EQ(source.size(), 1);
  EXPECT_EQ(source.convention()->name, "icvl16");
  testing::expect_labels_like_frames(source);
  const Frame frame = source.read(0);
  EXPECT_EQ(frame.name, "seq/image_0000");
  EXPECT_EQ(frame.camera.fx, 240.99);
  EXPECT_EQ(frame.camera.fy, 240.96);
  EXPECT_EQ(frame.depth_mm(100, 100), 400.0f);
  EXPECT_EQ(frame.depth_mm(7, 8), 0.0f);
  ASSERT_TRUE(frame.truth);
  EXPECT_EQ(frame.truth->joints[0].u, 1.5);
  EXPECT_EQ(frame.truth->joints[0].v, 2.5);
  EXPECT_EQ(frame.truth->joints[15].depth_mm, 48.5);
}

TEST(Icvl, TakesAnotherLabelFileByName) {
  const testing::TemporaryFolder folder;
  put_icvl(folder.path());
  put_file(folder / "test_seq_1.txt", "seq/image_0000.png " + numbers_text(48, 9.0) + "\n");
  EXPECT_EQ(IcvlSource(folder.path(), {"test_seq_1.txt"}).read(0).truth->joints[0].u, 9.0);
  EXPECT_THAT(error_of([&] { IcvlSource(folder.path(), {"no.txt"}); }), HasSubstr("no.txt"));
}

TEST(Icvl, ListsImagesWhereThereAreNoLabels) {
  const testing::TemporaryFolder folder;
  put_icvl(folder.path());
  fs::remove(folder / "labels.txt");
  const IcvlSource source(folder.path(), {});
  EXPECT_EQ(source.size(), 1);
  EXPECT_FALSE(source.convention());
  EXPECT_FALSE(source.read(0).truth);
}

TEST(Icvl, NamesFileAndFaultOfBadLabels) {
  const testing::TemporaryFolder folder;
  put_icvl(folder.path());
  const auto error_with = [&](const std::string& labels) {
    put_file(folder / "labels.txt", labels);
    return error_of([&] { IcvlSource(folder.path(), {}).read(0); });
  };
  EXPECT_THAT(error_with("seq/image_0000.png 1 2 3\n"), AllOf(HasSubstr("labels.txt:1"), HasSubstr("48")));
  EXPECT_THAT(error_with("seq/image_0000.png " + numbers_text(47, 1) + " x\n"), HasSubstr("'x'"));
  EXPECT_THAT(error_with("seq/image_0001.png " + numbers_text(48, 1)), HasSubstr("image_0001.png"));
  EXPECT_THAT(error_with(numbers_text(48, 1)), AllOf(HasSubstr("labels.txt"), HasSubstr(".png")));
  EXPECT_THAT(error_with(""), AllOf(HasSubstr("labels.txt"), HasSubstr("empty")));
  write_png(folder / "Depth/seq/image_0000.png", Image<std::uint16_t>(640, 480, 1));
  EXPECT_THAT(error_with("seq/image_0000.png " + numbers_text(48, 1)), HasSubstr("expected 320x240"));
}

// --- HANDS17 ---

void put_hands17(const fs::path& folder, const std::string& images) {
  make_folder(folder / images);
  write_png(folder / images / "image_D00000001.png", Image<std::uint16_t>(640, 480, 600));
  std::string line = "image_D00000001.png";
  for (int joint = 0; joint < 21; ++joint)
    line += fmt::format("\t{}\t{}\t{}", 10 * joint, -5 * joint, 500 + joint);
  put_file(folder / "Training_Annotation.txt", line + "\t\n");
}

TEST(Hands17, ProjectsItsTruth) {
  for (const std::string images : {"images", "."}) {
    const testing::TemporaryFolder folder;
    put_hands17(folder.path(), images);
    const Hands17Source source(folder.path(), {});
    ASSERT_EQ(source.size(), 1);
    EXPECT_EQ(source.convention()->name, "hands21");
    testing::expect_labels_like_frames(source);
    const Frame frame = source.read(0);
    EXPECT_EQ(frame.name, "image_D00000001");
    EXPECT_EQ(frame.depth_mm(0, 0), 600.0f);
    const ImagePoint joint = frame.truth->joints[20];
    EXPECT_NEAR(joint.u, 315.944855 + 475.065948 * 200 / 520, 1e-9);
    EXPECT_NEAR(joint.v, 245.287079 - 475.065857 * 100 / 520, 1e-9);
    EXPECT_EQ(joint.depth_mm, 520.0);
  }
}

TEST(Hands17, NamesFileAndFault) {
  const testing::TemporaryFolder folder;
  put_hands17(folder.path(), "images");
  EXPECT_THAT(error_of([&] { Hands17Source(folder.path(), {"other.txt"}); }), HasSubstr("other.txt"));
  put_file(folder / "short.txt", "image_D00000001.png\t" + numbers_text(62, 1, '\t'));
  EXPECT_THAT(error_of([&] { Hands17Source(folder.path(), {"short.txt"}).read(0); }),
              AllOf(HasSubstr("short.txt:1"), HasSubstr("62 numbers, expected 63")));
  testing::cut_file(folder / "images/image_D00000001.png", 200);
  EXPECT_THAT(error_of([&] { Hands17Source(folder.path(), {}).read(0); }), HasSubstr("image_D00000001.png"));
}

TEST(Hands17, ReadsTheRealFrame) {
  KNUCKLE_REQUIRE_SHARED_DATA(shared);
  const Hands17Source source(shared / "real/hands17", {});
  ASSERT_EQ(source.size(), 1);
  EXPECT_FALSE(source.convention());
  const Frame frame = source.read(0);
  const auto measured = std::ranges::count_if(frame.depth_mm.pixels(), [](float d) { return d > 0; });
  EXPECT_GT(measured, 10000);
}

// --- MSRA15 ---

std::string msra15_bytes(const std::vector<std::uint32_t>& header, const std::vector<float>& depth) {
  std::string bytes(header.size() * 4 + depth.size() * 4, '\0');
  std::memcpy(bytes.data(), header.data(), header.size() * 4);
  std::memcpy(bytes.data() + header.size() * 4, depth.data(), depth.size() * 4);
  return bytes;
}

const std::string kJoints = "2\n" + numbers_text(63, -400.0) + "\n" + numbers_text(63, -300.0) + "\n";

void put_msra15(const fs::path& root) {
  const std::string bytes = msra15_bytes({320, 240, 10, 20, 12, 23}, {1, 2, 3, 4, 5, 6});
  for (const std::string gesture : {"P0/1/", "P0/5/", "P1/1/"}) {
    for (const std::string name : {"000000", "000001"})
      put_file(root / (gesture + name + "_depth.bin"), bytes);
  }
  put_file(root / "P0/5/joint.txt", kJoints);
}

TEST(Msra15, PlacesTheBoxInTheImage) {
  const testing::TemporaryFolder folder;
  put_msra15(folder.path());
  const Image<float> depth = read_msra15_depth(folder / "P0/5/000000_depth.bin");
  EXPECT_EQ(depth.width(), 320);
  EXPECT_EQ(depth.height(), 240);
  EXPECT_EQ(depth(10, 20), 1.0f);
  EXPECT_EQ(depth(11, 20), 2.0f);
  EXPECT_EQ(depth(10, 22), 5.0f);
  EXPECT_EQ(depth(12, 20), 0.0f);
  EXPECT_EQ(depth(10, 23), 0.0f);
}

TEST(Msra15, OpensASetASubjectOrAGesture) {
  const testing::TemporaryFolder folder;
  put_msra15(folder.path());
  EXPECT_EQ(Msra15Source(folder.path()).size(), 6);
  EXPECT_EQ(Msra15Source(folder / "P0").size(), 4);
  EXPECT_EQ(Msra15Source(folder / "P0/5").size(), 2);
  EXPECT_EQ(Msra15Source(folder.path()).read(2).name, "P0/5/000000");
}

TEST(Msra15, TurnsItsYAxisAndProjects) {
  const testing::TemporaryFolder folder;
  put_msra15(folder.path());
  const Msra15Source source(folder.path());
  EXPECT_EQ(source.convention()->name, "msra21");
  testing::expect_labels_like_frames(source);
  EXPECT_FALSE(source.read(0).truth);
  const Frame frame = source.read(3);  // P0/5/000001: -300, -299, -298 first
  const ImagePoint joint = frame.truth->joints[0];
  EXPECT_NEAR(joint.u, 160 + 241.42 * -300 / 298, 1e-9);
  EXPECT_NEAR(joint.v, 120 - 241.42 * -299 / 298, 1e-9);
  EXPECT_EQ(joint.depth_mm, 298.0);
}

TEST(Msra15, NamesFileAndFault) {
  const testing::TemporaryFolder folder;
  put_msra15(folder.path());
  const fs::path image = folder / "P0/5/000000_depth.bin";
  const auto error_with = [&](const std::string& bytes) {
    put_file(image, bytes);
    return error_of([&] { read_msra15_depth(image); });
  };
  const std::vector<float> six{1, 2, 3, 4, 5, 6};
  EXPECT_THAT(error_with("short"), AllOf(HasSubstr("000000_depth.bin"), HasSubstr("cut short")));
  EXPECT_THAT(error_with(msra15_bytes({320, 240, 10, 20, 12, 23}, {1, 2, 3})),
              HasSubstr("36 bytes, expected 48"));
  EXPECT_THAT(error_with(msra15_bytes({320, 240, 10, 20, 321, 23}, six)), HasSubstr("the box"));
  EXPECT_THAT(error_with(msra15_bytes({320, 240, 12, 20, 10, 23}, six)), HasSubstr("the box"));
  EXPECT_THAT(error_with(msra15_bytes({640, 240, 10, 20, 12, 23}, six)), HasSubstr("640x240"));
  EXPECT_THAT(error_with(msra15_bytes({320, 240, 0xffffffff, 20, 12, 23}, six)), HasSubstr("the box"));

  const fs::path joints = folder / "P0/5/joint.txt";
  put_file(joints, kJoints.substr(0, kJoints.size() / 2));
  EXPECT_THAT(error_of([&] { Msra15Source(folder.path()); }),
              AllOf(HasSubstr("joint.txt"), HasSubstr("2 frames")));
  put_file(joints, "2\n1 2 3\n4 5 6\n");
  EXPECT_THAT(error_of([&] { Msra15Source(folder.path()).read(3); }),
              AllOf(HasSubstr("joint.txt"), HasSubstr("expected 63")));
  put_file(joints, "1\n" + numbers_text(63, 1));
  EXPECT_THAT(error_of([&] { Msra15Source(folder.path()).read(3); }), HasSubstr("joint.txt"));
  put_file(joints, "");
  EXPECT_THAT(error_of([&] { Msra15Source(folder.path()); }), HasSubstr("joint.txt: is empty"));
}

TEST(Msra15, ReadsTheRealFrame) {
  KNUCKLE_REQUIRE_SHARED_DATA(shared);
  const Msra15Source source(shared / "real/msra15");
  ASSERT_EQ(source.size(), 1);
  const Frame frame = source.read(0);
  EXPECT_EQ(frame.name, "P0/5/000000");
  const auto measured =
      std::ranges::count_if(frame.depth_mm.pixels(), [](float d) { return d > 100 && d < 1000; });
  EXPECT_GT(measured, 1000);
}

TEST(Msra15, ReadsTheRealLayoutOfJoints) {
  KNUCKLE_REQUIRE_SHARED_DATA(shared);
  const testing::TemporaryFolder folder;
  put_file(folder / "000399_depth.bin", msra15_bytes({320, 240, 10, 20, 12, 23}, {1, 2, 3, 4, 5, 6}));
  fs::copy_file(shared / "real/msra15/joint_example_400frames.txt", folder / "joint.txt");
  const Frame frame = Msra15Source(folder.path()).read(0);
  for (const ImagePoint& joint : frame.truth->joints) {
    EXPECT_TRUE(joint.u > 0 && joint.u < 320 && joint.v > 0 && joint.v < 240);
    EXPECT_TRUE(joint.depth_mm > 150 && joint.depth_mm < 600);
  }
}

// --- names ---

TEST(LabelledNames, ThatLeadOutOfTheFolderAreRefused) {
  const testing::TemporaryFolder folder;
  put_icvl(folder.path());
  fs::copy_file(folder / "Depth" / "seq" / "image_0000.png", folder / "secret.png");
  for (const std::string& name : {std::string("../secret.png"), std::string("seq/../../secret.png"),
                                  (folder / "secret.png").string()}) {
    put_file(folder / "labels.txt", name + " " + numbers_text(48, 1.5) + "\n");
    EXPECT_THAT(error_of([&] { IcvlSource(folder.path(), {}).read(0); }),
                AllOf(HasSubstr("labels.txt:1"), HasSubstr("does not lie in the folder")));
  }
  put_file(folder / "labels.txt", "seq/image_0000.png " + numbers_text(48, 1.5) + "\n");
  EXPECT_NO_THROW(IcvlSource(folder.path(), {}).read(0)) << "a folder within is fine";
}

}  // namespace
}  // namespace knuckle
