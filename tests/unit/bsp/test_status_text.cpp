// The words that board and ground print for a Status, written down here by hand.
#include "bsp/flight/status_text.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <limits>
#include <regex>
#include <set>
#include <string>

#include "cfg/relations.hpp"
#include "cfg/schedule.hpp"
#include "fsw/base/argument.hpp"

namespace ilp {
namespace {

constexpr std::int64_t least = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();

std::string words(ValueType type, std::int64_t value) {
  return value_text(type, value).c_str();
}

std::string sentence(const Status& status) {
  return status_words(status).c_str();
}

TEST(StatusText, NamesWhatAStatusIsAbout) {
  const std::pair<Status, const char*> cases[] = {
      {{StatusCode::component_restarted, 6}, "component structure_and_motion restarted from its checkpoint"},
      {{StatusCode::strip_broken, 17, 3}, "strip 17 ended: pose lost"},
      {{StatusCode::camera_calibrated, 5, 1234567},
       "the camera was found by the keyframes up to 5: focal length 1234.567 px"},
      {{StatusCode::camera_silent, 8, 2500}, "no frame since frame 8, for 2500 ms"},
      {{StatusCode::store_full, 10, 20}, "store is full: 10 bytes used of 20 bytes"},
      {{StatusCode::camera_size, 64000480, 32000240},
       "asked for pictures of 640 x 480 px, the camera gives 320 x 240 px"},
      {{StatusCode::camera_rate, 15000, 9990}, "asked for frames at 15 Hz, the camera gives 9.99 Hz"},
      {{StatusCode::events_lost, 3, 15}, "3 events could not be stored, the first was io_error"},
      {{StatusCode::record_damaged, 4, 1}, "record 4 of table frame does not have its checksum"},
      {{StatusCode::started, 2, 3}, "start 2 of the software: power was lost, or the board was reset"},
      {{StatusCode::transfer_cancelled, 9, 15}, "transaction 9 was cancelled: cancel request received"},
      {{StatusCode::pdu_rejected, 4, 20}, "a PDU of 20 bytes was rejected: CRC"},
      {{StatusCode::compute_lost, 1, 0},
       "the compute device was abandoned in flight in a job of wide search: no answer within the limit; the processor "
       "does its work"},
      {{StatusCode::self_test_failed, 4, 7}, "self-test codec failed, value 7"},
      {{StatusCode::exposure_limited, 2, 40},
       "images are too bright, and exposure and gain are at their limits, exposure 40 us"},
      {{StatusCode::camera_distrusted, 5, 40000},
       "the camera's driver is not fully trusted (findings: time stamps ahead of the clock, time stamps of another "
       "clock "
       "than the monotonic one), frame period 40000 us"},
      {{StatusCode::unsupported_format, 0x59455247}, "format not supported: GREY"},
      {{StatusCode::unsupported_format, 1}, "format not supported: no binary PGM file"},
      {{StatusCode::camera_control_missing, 0x980911},
       "the camera has no control 0x980911 that can be set (videodev2.h)"},
      {{StatusCode::node_joined, 2, 96}, "node 2 runs its stages: structure_and_motion, dense_matcher"},
      {{StatusCode::memory_damaged, 0, 2},
       "memory of component package (package: of the executive, its parameters or its events) changed without a write; "
       "mended: from a copy (docs/design.md)"},
      {contradiction(Relation::overlaps),
       "the parameters would contradict each other, none was set; what must hold: min_overlap below target_overlap"},
      {{StatusCode::parameter_out_of_range, 1, 2},
       "value of parameter acquisition.capture_mode, item or line 2 of the list, is out of its range"}};
  for (const auto& [status, expected] : cases) EXPECT_EQ(sentence(status), expected);
  EXPECT_NE(sentence({StatusCode::io_error, ENOENT}).find("errno 2, No such file"), std::string::npos);
}

TEST(StatusText, NamesARefusedArgumentAndItsValue) {
  EXPECT_EQ(sentence(out_of_range(Argument::min_overlap, 1.5)), "argument min overlap out of range: 1.5");
  EXPECT_EQ(sentence(out_of_range(Argument::image_size, 12)), "argument image size out of range: 12");
  EXPECT_EQ(sentence(out_of_range(Argument::scale, -0.25F)), "argument scale out of range: -0.25");
  EXPECT_EQ(sentence(out_of_range(Argument::rows)),
            "argument rows (expected: inside the image) out of range: no number");
  for (const double none : {std::numeric_limits<double>::quiet_NaN(), 1e300, -1e300})
    EXPECT_EQ(sentence(out_of_range(Argument::slot, none)), "argument slot out of range: no number");
}

TEST(StatusText, WritesFractionsAndSigns) {
  EXPECT_EQ(words(ValueType::thousandths, -1), "-0.001");
  EXPECT_EQ(words(ValueType::thousandths, -1500), "-1.5");
  EXPECT_EQ(words(ValueType::thousandths, 20), "0.02");
  EXPECT_EQ(words(ValueType::thousandths, 2000), "2");
  EXPECT_EQ(words(ValueType::millipixels, most), "9223372036854775.807 px");
  EXPECT_EQ(words(ValueType::number, least), "-9223372036854775808");
}

TEST(StatusText, ANumberWithoutANameIsWrittenAsItIs) {
  // The names of numbers end far below these.
  for (std::size_t i = 0; i < static_cast<std::size_t>(ValueType::count); ++i) {
    const auto type = static_cast<ValueType>(i);
    for (const std::int64_t value : {std::int64_t{-7}, std::int64_t{250}, std::int64_t{1} << 40, least + 1, most}) {
      const std::string text = words(type, value);
      const std::string digits = std::to_string(value);
      const bool other = type == ValueType::hexadecimal || type == ValueType::size || text.rfind("0x", 0) == 0 ||
                         info_of(type).per_unit != 1 || type == ValueType::fault || type == ValueType::parameter ||
                         type == ValueType::stages || type == ValueType::findings;
      EXPECT_TRUE(other || text.find(digits) != std::string::npos) << info_of(type).name << ": " << text;
      EXPECT_EQ(text.find('?'), std::string::npos) << text;
      EXPECT_EQ(text.find("unknown"), std::string::npos) << text;
      EXPECT_FALSE(text.empty()) << info_of(type).name;
    }
  }
  EXPECT_EQ(words(ValueType::fault, 255), "255");
  EXPECT_EQ(words(ValueType::fault, -1), "-1");
  EXPECT_EQ(words(ValueType::parameter, 60000), "60000");
  EXPECT_EQ(words(ValueType::component, static_cast<std::int64_t>(stage_count) + 1), std::to_string(stage_count + 1));
  EXPECT_EQ(words(ValueType::stages, std::int64_t{1} << 40), "0x10000000000");
  EXPECT_EQ(words(ValueType::findings, -7), "0xfffffffffffffff9");
}

TEST(StatusText, FitsWhateverTheValuesAre) {
  const std::int64_t all_stages = (std::int64_t{1} << stage_count) - 1;
  for (int code = 0; code < status_code_limit; ++code) {
    if (!is_status_code(static_cast<std::uint64_t>(code))) continue;
    for (const std::int64_t value : {least, most, std::int64_t{-1}, all_stages, std::int64_t{255}, std::int64_t{12}}) {
      const StatusText text = status_words({static_cast<StatusCode>(code), value, value});
      EXPECT_FALSE(text.overflow()) << text.c_str();
    }
  }
}

TEST(StatusText, EveryTypeHasAUnitOrNamesOrIsAPlainNumber) {
  const std::set<ValueType> plain = {ValueType::none, ValueType::number, ValueType::id, ValueType::hexadecimal,
                                     ValueType::thousandths};
  const std::set<ValueType> looked_up = {ValueType::error,   ValueType::fault, ValueType::component,
                                         ValueType::stages,  ValueType::table, ValueType::parameter,
                                         ValueType::findings};
  for (std::size_t i = 0; i < static_cast<std::size_t>(ValueType::count); ++i) {
    const auto type = static_cast<ValueType>(i);
    const bool unit = info_of(type).unit[0] != 0;
    EXPECT_EQ(!unit && plain.count(type) == 0 && looked_up.count(type) == 0, !named_values(type).empty())
        << info_of(type).name;
  }
}

}  // namespace
}  // namespace ilp
