// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/archive.h"

#include <limits>

#include <fmt/format.h>
#include <torch/types.h>

#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::TemporaryFolder;

class ArchiveTest : public ::testing::Test {
 protected:
  void save(const std::vector<torch::Tensor>& tensors, int version = 2) const {
    ArchiveWriter archive("measures", version);
    archive.write("name", "of the hand");
    archive.write("length", 183.25);
    archive.write("tensors", tensors);
    archive.save(file_);
  }

  ArchiveReader reader() const { return ArchiveReader(file_, "measures", 2); }

  /// The one line that names the file and ends the reading.
  template <class Reading>
  std::string fault(const Reading& reading) const {
    const std::string error = error_of([&] {
      ArchiveReader archive = reader();
      reading(archive);
    });
    EXPECT_THAT(error, AllOf(HasSubstr(file_.string()), Not(HasSubstr("\n"))));
    return error;
  }
  std::string fault_at_opening() const {
    return fault([](ArchiveReader&) {});
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "file.pt";
};

TEST_F(ArchiveTest, GivesBackWhatWasWritten) {
  const torch::Tensor rows = torch::arange(6, torch::kFloat64).reshape({2, 3});
  save({rows, rows.transpose(0, 1)});
  ArchiveReader archive = reader();
  EXPECT_EQ(archive.text("name"), "of the hand");
  EXPECT_EQ(archive.number("length"), 183.25);
  const std::vector<torch::Tensor> found = archive.tensors("tensors");
  ASSERT_EQ(found.size(), 2u);
  EXPECT_TRUE(torch::equal(found[0], rows));
  EXPECT_TRUE(torch::equal(found[1], rows.transpose(0, 1)));
  const torch::Tensor target = torch::zeros({2, 3});
  archive.copy_into("tensors", {target, torch::zeros({3, 2})});
  EXPECT_TRUE(torch::equal(target, rows.to(torch::kFloat32)));
}

TEST_F(ArchiveTest, TheSameContentIsTheSameBytes) {
  save({torch::ones({4})});
  const std::string bytes = read_text_file(file_);
  save({torch::ones({8}).slice(0, 4)});
  EXPECT_TRUE(read_text_file(file_) == bytes) << "a part of a tensor is kept without the rest";
}

TEST_F(ArchiveTest, OfAnotherFormatOrVersionIsRefused) {
  EXPECT_THAT(fault_at_opening(), HasSubstr("no such file"));
  for (const int version : {0, 1, 3}) {
    save({}, version);
    EXPECT_THAT(fault_at_opening(),
                AllOf(HasSubstr(fmt::format("version {}", version)), HasSubstr("expected 2")));
  }
  ArchiveWriter("pictures", 2).save(file_);
  EXPECT_THAT(fault_at_opening(), HasSubstr("none of the format measures"));
}

TEST_F(ArchiveTest, WhatIsMissingOrOfAnotherKindIsNamed) {
  save({});
  EXPECT_THAT(fault([](ArchiveReader& archive) { archive.text("weight"); }), HasSubstr("weight is missing"));
  EXPECT_THAT(fault([](ArchiveReader& archive) { archive.text("length"); }), HasSubstr("length is not text"));
  EXPECT_THAT(fault([](ArchiveReader& archive) { archive.number("name"); }),
              HasSubstr("name is not a number"));
  EXPECT_THAT(fault([](ArchiveReader& archive) { archive.tensors("name"); }),
              HasSubstr("name_count is missing"));
  ArchiveWriter archive("measures", 2);
  archive.write("few_count", -1.0);
  archive.write("many_count", 1e6);
  archive.write("texts_count", 1.0);
  archive.write("texts_0", "no tensor");
  archive.save(file_);
  EXPECT_THAT(fault([](ArchiveReader& file) { file.tensors("few"); }), HasSubstr("few holds -1 tensors"));
  EXPECT_THAT(fault([](ArchiveReader& file) { file.tensors("many"); }),
              HasSubstr("many holds 1000000 tensors"));
  EXPECT_THAT(fault([](ArchiveReader& file) { file.tensors("texts"); }),
              HasSubstr("texts_0 is not a tensor"));
}

TEST_F(ArchiveTest, CopiesOnlyNumbersIntoTensorsOfTheSameShapes) {
  torch::Tensor tensor = torch::ones({3});
  const auto copy_into = [&](const std::vector<torch::Tensor>& targets) {
    return fault([&](ArchiveReader& archive) { archive.copy_into("tensors", targets); });
  };
  save({tensor});
  EXPECT_THAT(copy_into({torch::zeros({3}), torch::zeros({3})}), HasSubstr("holds 1 tensors, expected 2"));
  EXPECT_THAT(copy_into({torch::zeros({4})}), HasSubstr("another shape"));
  for (const float value :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    tensor[1] = value;
    save({tensor});
    EXPECT_THAT(copy_into({torch::zeros({3})}), HasSubstr("not finite"));
  }
}

TEST_F(ArchiveTest, ThatCannotBeWrittenIsNamed) {
  EXPECT_THAT(error_of([] { ArchiveWriter("measures", 2).save("/proc/knuckle/file.pt"); }),
              HasSubstr("/proc/knuckle/file.pt"));
}

}  // namespace
}  // namespace knuckle
