// The field tables describe their structs completely, and the serial form is the one that the ground reads.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "fsw/records/records.hpp"
#include "fsw/records/serial.hpp"

namespace ilp {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::vector<const RecordInfo*> all_records() {
  std::vector<const RecordInfo*> infos;
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    infos.push_back(&record_info(static_cast<RecordType>(t)));
  }
  return infos;
}

/// 1 for every byte of the struct that holds a value, 0 for padding, as the compiler sees it.
template <typename Record>
Bytes bytes_of_values() {
  alignas(Record) unsigned char memory[sizeof(Record)];
  std::memset(memory, 1, sizeof(memory));
  __builtin_clear_padding(reinterpret_cast<Record*>(memory));
  return Bytes(memory, memory + sizeof(Record));
}

template <typename Record>
void expect_complete_table() {
  const RecordInfo& info = record_info<Record>();
  ASSERT_EQ(info.bytes, sizeof(Record)) << info.name;
  Bytes described(sizeof(Record), 0);
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    const std::size_t bytes = field.count * element_bytes(field.type);
    ASSERT_LE(field.offset + bytes, sizeof(Record)) << info.name << "." << field.name;
    for (std::size_t i = 0; i < bytes; ++i) {
      EXPECT_EQ(described[field.offset + i]++, 0) << info.name << "." << field.name << " overlaps another field";
    }
  }
  EXPECT_EQ(described, bytes_of_values<Record>()) << info.name << " has members that its table does not name";
}

TEST(Records, TablesNameEveryMemberOfTheirStructsOnce) {
#define RECORD(number, record, ...) expect_complete_table<record>();
#include "fsw/records/records.inc"
}

TEST(Records, NamesTellFieldsAndTablesApart) {
  std::set<std::string> tables;
  for (const RecordInfo* info : all_records()) {
    EXPECT_TRUE(tables.insert(info->name).second) << info->name;
    EXPECT_STRNE(info->description, "");
    EXPECT_STREQ(info->fields[0].name, "id");
    EXPECT_EQ(info->fields[0].type, FieldType::i64);
    EXPECT_EQ(info->fields[0].offset, 0);
    std::set<std::string> columns;
    for (std::size_t f = 0; f < info->field_count; ++f) {
      const FieldInfo& field = info->fields[f];
      EXPECT_STRNE(field.description, "") << info->name << "." << field.name;
      EXPECT_NE(field.unit, nullptr);
      for (int i = 0; i < (field.type == FieldType::text ? 1 : field.count); ++i) {
        const std::string suffix = field.type == FieldType::blob ? "_bytes" : "";
        const std::string element = field.count > 1 && field.type != FieldType::text ? "_" + std::to_string(i) : "";
        EXPECT_TRUE(columns.insert(field.name + suffix + element).second) << info->name << "." << field.name;
      }
      // A blob lies in a table of its own, which must not be another record's.
      if (field.type != FieldType::blob) continue;
      EXPECT_TRUE(tables.insert(std::string(info->name) + "_" + field.name).second);
    }
  }
}

TEST(Records, EveryValueOfAnEnumerationHasANameOfItsOwn) {
  std::size_t enumerated = 0;
  for (const RecordInfo* info : all_records()) {
    for (const FieldInfo& field : std::span(info->fields, info->field_count)) {
      std::set<std::string> names;
      std::set<int> numbers;
      for (const EnumValue& value : field.values) {
        EXPECT_TRUE(names.insert(value.name).second) << info->name << "." << field.name << ": " << value.name;
        EXPECT_TRUE(numbers.insert(value.number).second) << info->name << "." << field.name << ": " << value.name;
      }
      const bool verdict = std::string(field.name).find("verdict") != std::string::npos;
      EXPECT_TRUE(!verdict || !field.values.empty()) << info->name << "." << field.name;
      enumerated += field.values.empty() ? 0 : 1;
    }
  }
  EXPECT_GE(enumerated, 25U);
  EXPECT_STREQ(name_of(PoseVerdict::resection_failed), "resection_failed");
  EXPECT_STREQ(name_of(static_cast<PoseVerdict>(200)), "?");
}

TEST(Records, AScaleStepThatWasNotMeasuredIsToldFromAPerfectOne) {
  PoseRecord pose;
  EXPECT_FALSE(scale_step_measured(pose));
  for (const double measured : {0.9, 1 + 1e-15, 1 - 1e-15}) {
    pose.scale_step = measured;
    EXPECT_TRUE(scale_step_measured(pose)) << measured;
  }
}

TEST(Serial, IsLittleEndianInTableOrderWithoutPadding) {
  EventRecord event{.id = 0x0102030405060708, .time_ns = -2, .code = 0xA1B2, .severity = 3};
  std::memcpy(event.component, "downlink", 9);
  event.a = 1;
  event.b = -1;
  std::memcpy(event.place, "x.cpp", 6);
  Bytes expected = {8, 7, 6, 5, 4, 3, 2, 1, 0xFE, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xB2, 0xA1, 3};
  const auto append_text = [&](const std::string& text, std::size_t capacity) {
    for (std::size_t i = 0; i < capacity; ++i)
      expected.push_back(i < text.size() ? static_cast<std::uint8_t>(text[i]) : 0);
  };
  append_text("downlink", 24);
  for (const int byte : {1, 0, 0, 0, 0, 0, 0, 0}) expected.push_back(static_cast<std::uint8_t>(byte));
  for (int i = 0; i < 8; ++i) expected.push_back(0xFF);
  append_text("x.cpp", 48);
  ASSERT_EQ(serial_bytes(record_info<EventRecord>()), expected.size());
  Bytes serial(expected.size());
  ASSERT_TRUE(serialize(record_info<EventRecord>(), &event, serial).ok());
  EXPECT_EQ(serial, expected);
}

TEST(Serial, FloatsAreIeeeAndBlobsTheirSize) {
  FrameRecord frame{.id = 1};
  frame.altitude = -2.5;  // sign 1, exponent 1024, mantissa 0.25: C004 0000 0000 0000
  frame.image.bytes = 0x00C0FFEE;
  Bytes serial(serial_bytes(record_info<FrameRecord>()));
  ASSERT_EQ(serial.size(), 8U + 8 + 8 + 4 + 4 + 8 + 8 + 1 + 64 + 4 + 8);
  ASSERT_TRUE(serialize(record_info<FrameRecord>(), &frame, serial).ok());
  EXPECT_EQ(Bytes(serial.begin() + 32, serial.begin() + 40), (Bytes{0, 0, 0, 0, 0, 0, 4, 0xC0}));
  EXPECT_EQ(Bytes(serial.end() - 12, serial.end() - 8), (Bytes{0xEE, 0xFF, 0xC0, 0x00}));
  PoseRecord pose;
  pose.q_cam_from_world[3] = 1.5;  // 3FF8...
  serial.assign(serial_bytes(record_info<PoseRecord>()), 0);
  ASSERT_TRUE(serialize(record_info<PoseRecord>(), &pose, serial).ok());
  EXPECT_EQ(serial[23 + 3 * 8 + 7], 0x3F);
  EXPECT_EQ(serial[23 + 3 * 8 + 6], 0xF8);
}

TEST(Serial, AnyBytesMakeARecordAndComeBackFromIt) {
  std::mt19937 random(7);
  for (const RecordInfo* info : all_records()) {
    const std::size_t size = serial_bytes(*info);
    for (int round = 0; round < 200; ++round) {
      Bytes hostile(size);
      for (std::uint8_t& byte : hostile) byte = static_cast<std::uint8_t>(random());
      alignas(8) std::uint8_t record[limits::max_record_bytes];
      std::memset(record, 0xAA, sizeof(record));
      ASSERT_TRUE(deserialize(*info, hostile, record).ok());
      Bytes again(size);
      ASSERT_TRUE(serialize(*info, record, again).ok());
      std::size_t at = 0;
      for (std::size_t f = 0; f < info->field_count; ++f) {
        const FieldInfo& field = info->fields[f];
        at += field.count * element_bytes(field.type);
        if (field.type == FieldType::text) {
          EXPECT_EQ(again[at - 1], 0) << "text without an end";
          hostile[at - 1] = 0;
        }
      }
      EXPECT_EQ(again, hostile) << info->name;
      for (std::size_t i = info->bytes; i < sizeof(record); ++i)
        ASSERT_EQ(record[i], 0xAA) << "written behind the struct";
    }
  }
}

TEST(Serial, MissingBytesAreAStatusAndNothingIsWritten) {
  for (const RecordInfo* info : all_records()) {
    const std::size_t size = serial_bytes(*info);
    const Bytes whole(size, 1);
    alignas(8) std::uint8_t record[limits::max_record_bytes];
    for (std::size_t less = 0; less < size; ++less) {
      std::memset(record, 0xAA, sizeof(record));
      const Status status = deserialize(*info, std::span(whole).first(less), record);
      ASSERT_EQ(status.code, StatusCode::truncated);
      EXPECT_EQ(status.a, static_cast<std::int64_t>(less));
      EXPECT_EQ(status.b, static_cast<std::int64_t>(size));
      EXPECT_EQ(record[0], 0xAA);
    }
    Bytes small(size - 1, 0xAA);
    std::memset(record, 0, sizeof(record));
    EXPECT_EQ(serialize(*info, record, small).code, StatusCode::capacity_exceeded);
    EXPECT_EQ(small, Bytes(size - 1, 0xAA));
    Bytes large(size + 3, 0xAA);
    EXPECT_TRUE(serialize(*info, record, large).ok());
    EXPECT_EQ(Bytes(large.end() - 3, large.end()), Bytes(3, 0xAA));
  }
}

TEST(Records, CamerasAndPosesSurviveTheirRecords) {
  const CameraModel camera{640, 480, 500, 501, 319.5, 239.5, -0.1, 0.01, 0.001, -0.002};
  const CameraRecord record = camera_record(camera);
  EXPECT_EQ(record.id, 1);
  EXPECT_EQ(record.frozen, 1);
  EXPECT_TRUE(camera_model(record) == camera);
  PoseRecord pose;
  pose.q_cam_from_world[2] = 0.5;
  pose.centre[2] = 3;
  EXPECT_EQ(pose_of(pose).q_cam_from_world[2], 0.5);
  EXPECT_EQ(pose_of(pose).centre[2], 3);
}

}  // namespace
}  // namespace ilp
