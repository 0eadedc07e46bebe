// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/training_record.h"

#include <fmt/format.h>

#include "knuckle/core/testing.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::HasSubstr;

TEST(TrainingRecordTest, AForestHasItsTimeAlone) {
  const TemporaryFolder folder;
  write_trained_record(folder / "forest.model", 12.5);
  const TrainingRecord record = read_training_record(folder / "forest.model");
  EXPECT_EQ(record.model, "forest.model");
  EXPECT_TRUE(record.given.empty());
  EXPECT_EQ(record.seconds, 12.5);
  EXPECT_FALSE(record.samples);
  EXPECT_TRUE(std::isnan(record.validation_mm));
}

TEST(TrainingRecordTest, ANetworkHasThoseOfItsMetrics) {
  const TemporaryFolder folder;
  write_given_record(folder / "net.pt", "/models/net.pt");
  write_text_file(folder / "net.pt.metrics.csv",
                  "step,samples,validation_second_mm,samples_per_second\n"
                  "1,100,40,50\n2,300,20.5,100\n3,400,21,100\n");
  const TrainingRecord record = read_training_record(folder / "net.pt");
  EXPECT_EQ(record.given, "/models/net.pt");
  EXPECT_EQ(record.seconds, 2.0 + 2.0 + 1.0);
  EXPECT_EQ(record.samples, 400);
  EXPECT_EQ(record.validation_mm, 20.5);
}

TEST(TrainingRecordTest, NamesADamagedFile) {
  const TemporaryFolder folder;
  write_text_file(folder / "a.pt.training.json", "{");
  EXPECT_THAT(error_of([&] { read_training_record(folder / "a.pt"); }), HasSubstr("a.pt.training.json"));
  write_trained_record(folder / "a.pt", 1.0);
  write_text_file(folder / "a.pt.metrics.csv", "step,samples\n1\n");
  EXPECT_THAT(error_of([&] { read_training_record(folder / "a.pt"); }), HasSubstr("a.pt.metrics.csv:2"));
  write_text_file(folder / "a.pt.metrics.csv", "step,samples\n1,2\n3,4,5\n");
  EXPECT_THAT(error_of([&] { read_training_record(folder / "a.pt"); }),
              HasSubstr("a.pt.metrics.csv:3: 3 columns, expected 2"));
  write_text_file(folder / "a.pt.metrics.csv", "");
  EXPECT_THAT(error_of([&] { read_training_record(folder / "a.pt"); }),
              HasSubstr("a.pt.metrics.csv: expected metrics, found nothing"));
  write_text_file(folder / "a.pt.metrics.csv", "step,samples\n1,2\n");
  EXPECT_THAT(error_of([&] { read_training_record(folder / "a.pt"); }),
              HasSubstr("no column samples_per_second"));
}

TEST(TrainingRecordTest, AColumnThatIsThereTwiceIsRefused) {
  const TemporaryFolder folder;
  write_trained_record(folder / "a.pt", 1.0);
  write_text_file(folder / "a.pt.metrics.csv",
                  "samples,samples,validation_second_mm,samples_per_second\n1,2,40,50\n");
  EXPECT_THAT(error_of([&] { read_training_record(folder / "a.pt"); }),
              HasSubstr("a.pt.metrics.csv: two columns samples"));
}

TEST(TrainingRecordTest, ANumberOfSamplesThatNoTrainingSeesIsRefused) {
  const TemporaryFolder folder;
  write_trained_record(folder / "a.pt", 1.0);
  for (const char* samples : {"1e300", "-1", "nan"}) {
    write_text_file(folder / "a.pt.metrics.csv",
                    fmt::format("samples,validation_second_mm,samples_per_second\n{},40,50\n", samples));
    EXPECT_THAT(error_of([&] { read_training_record(folder / "a.pt"); }),
                HasSubstr("samples, expected a number of them"))
        << samples;
  }
}

}  // namespace
}  // namespace knuckle::testing
