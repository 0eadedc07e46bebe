// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "knuckle/core/testing.h"
#include "knuckle/net/onnx/protobuf_reader.h"
#include "knuckle/net/onnx/protobuf_writer.h"

namespace knuckle {
namespace {

using ::testing::ElementsAre;
using testing::error_of;
using ::testing::HasSubstr;

std::string written(const ProtobufWriter& writer) {
  return writer.text();
}

TEST(Protobuf, WhatIsWrittenIsRead) {
  ProtobufWriter writer;
  for (const std::int64_t value :
       {std::int64_t{0}, std::int64_t{127}, std::int64_t{128}, std::int64_t{-1},
        std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max()}) {
    writer.integer(3, value);
  }
  writer.real(200, -0.1f);
  writer.bytes(5, std::string_view("a\0b", 3));
  const std::string bytes = written(writer);
  ProtobufReader reader(bytes, "it");
  std::vector<std::int64_t> integers;
  for (int i = 0; i < 6; ++i) reader.add_integers(*reader.next(), integers);
  EXPECT_THAT(integers, ElementsAre(0, 127, 128, -1, std::numeric_limits<std::int64_t>::min(),
                                    std::numeric_limits<std::int64_t>::max()));
  const auto real = reader.next();
  EXPECT_EQ(real->number, 200u);
  EXPECT_EQ(reader.real_of(*real), -0.1f);
  EXPECT_EQ(reader.bytes_of(*reader.next()), std::string_view("a\0b", 3));
  EXPECT_FALSE(reader.next());
}

TEST(Protobuf, ReadsPackedNumbers) {
  const std::string bytes("\x0A\x03\x01\xAC\x02\x12\x08\x00\x00\x80\x3F\x00\x00\x00\x40", 15);
  ProtobufReader reader(bytes, "it");
  std::vector<std::int64_t> integers;
  std::vector<float> reals;
  reader.add_integers(*reader.next(), integers);
  reader.add_reals(*reader.next(), reals);
  EXPECT_THAT(integers, ElementsAre(1, 300));
  EXPECT_THAT(reals, ElementsAre(1.0f, 2.0f));
}

std::string fault_of(std::string bytes) {
  return error_of([&] {
    ProtobufReader reader(bytes, "it");
    while (reader.next()) {
    }
  });
}

TEST(Protobuf, DamageIsSaid) {
  EXPECT_THAT(fault_of("\x08"), HasSubstr("it: damaged or cut short"));
  EXPECT_THAT(fault_of("\x0A\x05 abc"), HasSubstr("cut short"));
  EXPECT_THAT(fault_of("\x0D\x01\x02"), HasSubstr("cut short"));
  EXPECT_THAT(fault_of("\x0B"), HasSubstr("unknown type 3"));
  EXPECT_THAT(fault_of(std::string("\x00\x00", 2)), HasSubstr("number 0"));
  // A field of the number 2^29: more than the format has.
  EXPECT_THAT(fault_of("\x80\x80\x80\x80\x10\x01"), HasSubstr("number 536870912"));
  EXPECT_THAT(fault_of(std::string("\x08").append(10, '\xFF').append("\x01")),
              HasSubstr("more than 64 bits"));
  // A length of 2^64 - 1: compared, not added to a place.
  EXPECT_THAT(fault_of(std::string("\x0A").append(9, '\xFF').append("\x01")), HasSubstr("cut short"));
}

TEST(Protobuf, AFieldOfAnotherKindIsRefused) {
  ProtobufWriter writer;
  writer.integer(1, 5);
  writer.bytes(2, "abc");
  const std::string bytes = written(writer);
  ProtobufReader reader(bytes, "it");
  const ProtobufField integer = *reader.next();
  const ProtobufField text = *reader.next();
  std::vector<float> reals;
  EXPECT_THAT(error_of([&] { (void)reader.bytes_of(integer); }),
              HasSubstr("field 1 is damaged, expected bytes"));
  EXPECT_THAT(error_of([&] { (void)reader.integer_of(text); }),
              HasSubstr("field 2 is damaged, expected a whole number"));
  EXPECT_THAT(error_of([&] { (void)reader.real_of(integer); }),
              HasSubstr("field 1 is damaged, expected a number"));
  EXPECT_THAT(error_of([&] { reader.add_reals(text, reals); }), HasSubstr("whole numbers of 4 bytes"));
  reader.require_once(integer);
  reader.require_once(text);
  EXPECT_THAT(error_of([&] { reader.require_once(integer); }), HasSubstr("field 1 is there twice"));
}

TEST(Protobuf, AListOfWholeNumbersIsBounded) {
  ProtobufWriter writer;
  writer.bytes(1, std::string(kMostIntegers + 1, '\1'));
  const std::string bytes = written(writer);
  ProtobufReader reader(bytes, "it");
  std::vector<std::int64_t> integers;
  EXPECT_THAT(error_of([&] { reader.add_integers(*reader.next(), integers); }), HasSubstr("more than 65536"));
}

}  // namespace
}  // namespace knuckle
