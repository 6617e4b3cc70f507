// Files of measurements as people bring them, read by the flight's own reader.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "hal/navigation/csv/navigation_file.hpp"
#include "sim/sil/navigation_input.hpp"
#include "tests/support/said.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::sil {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t second = 1'000'000'000;
// 2026-11-22T08:40:00Z
constexpr std::int64_t morning = 1'795'336'800 * second;

class NavigationInput : public testing::Test {
 protected:
  NavigationInput() {
    for (int i = 0; i < 10; ++i) frames_.push_back({i * 8 * second, "p" + std::to_string(i), {}, false});
  }
  /// Heights of the file that is made of this one; none where the flight refuses it.
  std::vector<NavigationSample> read(const std::string& text) {
    std::ofstream(folder_ / "given.csv", std::ios::binary) << text;
    file_ = prepare_navigation(folder_ / "given.csv", frames_, epoch_, folder_ / "made.csv", messages_);
    NavigationFile source;
    EXPECT_TRUE(source.open(file_.c_str()).ok());
    std::vector<NavigationSample> samples;
    NavigationSample sample;
    Status status;
    while (!(status = source.next(longest_duration_ns, sample)).is(StatusCode::end_of_stream)) {
      if (status.ok()) samples.push_back(sample);
    }
    return samples;
  }
  std::string refusal(const std::string& text) {
    return test::error_of([&] { (void)read(text); });
  }
  bool says(const char* part) const { return messages_.str().find(part) != std::string::npos; }

  test::TemporaryFolder folder_;
  std::vector<host::StripFrame> frames_;
  std::optional<StripEpoch> epoch_;
  fs::path file_;
  std::ostringstream messages_;
};

TEST_F(NavigationInput, AFileForTheFlightStaysAsItIs) {
  EXPECT_EQ(read("time_s,height_m,height_sigma_m\n8,100,1\n").size(), 1U);
  EXPECT_EQ(file_, folder_ / "given.csv");
  EXPECT_EQ(messages_.str(), "");
}

TEST_F(NavigationInput, SpreadsheetsAreRead) {
  for (const char* text :
       {"\xEF\xBB\xBFtime_s,height_m,height_sigma_m\n8,100.5,1\n", "time_s;height_m;height_sigma_m\r\n8;100,5;1\r\n",
        "\"time_s\",\"height_m\",\"height_sigma_m\"\n\"8\",\"100.5\",\"1\"\n",
        "time_s\theight_m\theight_sigma_m\n8\t100.5\t1\n"}) {
    const std::vector<NavigationSample> samples = read(text);
    ASSERT_EQ(samples.size(), 1U) << text;
    EXPECT_EQ(samples[0].time_ns, 8 * second);
    EXPECT_EQ(samples[0].height_m, 100.5);
  }
}

TEST_F(NavigationInput, AColumnThatIsNotKnownOrMissingIsNamed) {
  EXPECT_NE(refusal("time_s,height_ft,height_sigma_m\n").find("the column \"height_ft\" is not known"),
            std::string::npos);
  EXPECT_NE(refusal("time_s,height_m\n").find("height_sigma_m is missing, which belongs to height_m"),
            std::string::npos);
  EXPECT_NE(refusal("height_m,height_sigma_m\n").find("time_s is missing"), std::string::npos);
}

TEST_F(NavigationInput, ACommaInsideACellIsNoColumn) {
  // As spreadsheets write decimal commas, or thousands, where commas are between the cells.
  EXPECT_NE(refusal("time_s,height_m,height_sigma_m\n8,100,1\n16,\"1,100\",1\n").find("line 3: \"1,100\" has a comma"),
            std::string::npos);
}

TEST_F(NavigationInput, TimesSince1970AndDatesCountFromTheFirstImage) {
  epoch_ = StripEpoch{morning, true};
  for (const char* time :
       {"1795336808", "2026-11-22T08:40:08Z", "2026-11-22 08:40:08.000Z", "2026-11-22T10:40:08+02:00",
        "2026-11-22T14:10:08+0530", "2026-11-22T05:10:08-03:30", "2026-11-22T10:40:08+02"}) {
    const auto samples = read(std::string("time_s,height_m,height_sigma_m\n") + time + ",100,1\n");
    ASSERT_EQ(samples.size(), 1U) << time << messages_.str();
    EXPECT_EQ(samples[0].time_ns, 8 * second) << time;
  }
  EXPECT_FALSE(says("none is used")) << messages_.str();
}

TEST_F(NavigationInput, AZoneThatIsNoneIsNotGuessed) {
  epoch_ = StripEpoch{morning, true};
  for (const char* zone : {"+05:3", "+530", "+02:00 CEST", "+15", "+0260", "+", "CET"}) {
    messages_.str("");
    EXPECT_EQ(read(std::string("time_s,height_m,height_sigma_m\n2026-11-22T10:40:08") + zone + ",100,1\n").size(), 0U)
        << zone;
    EXPECT_TRUE(says("1 line of")) << zone << messages_.str();
  }
}

TEST_F(NavigationInput, LocalTimeIsFoundByTheOnlyZoneThatFits) {
  epoch_ = StripEpoch{morning + 2 * 3600 * second, false};  // the camera's clock has summer time
  const auto samples = read("time_s,height_m,height_sigma_m\n1795336800,100,1\n1795336808,100,1\n");
  ASSERT_EQ(samples.size(), 2U) << messages_.str();
  EXPECT_EQ(samples[1].time_ns, 8 * second);
  EXPECT_TRUE(says("2.00 h ahead")) << messages_.str();
  // With measurements of a whole day every zone fits.
  std::string day = "time_s,height_m,height_sigma_m\n";
  for (int i = -50'000; i < 50'000; ++i) day += std::to_string(1'795'336'800 + i) + ",100,1\n";
  EXPECT_EQ(read(day).size(), 0U);
  EXPECT_TRUE(says("none or several fit")) << messages_.str();
}

TEST_F(NavigationInput, WhatCannotBeUsedIsTold) {
  EXPECT_EQ(read("time_s,height_m,height_sigma_m\n1795336800,100,1\n2026-11-22T08:40:08Z,100,1\n").size(), 0U);
  EXPECT_TRUE(says("2 lines with a date or a time since 1970 cannot be used")) << messages_.str();
  EXPECT_TRUE(says("lies within 0.500 s of an image, so none is used")) << messages_.str();
  messages_.str("");
  EXPECT_EQ(read("time_s,height_m,height_sigma_m\n500,100,1\nsoon,100,1\n").size(), 1U);
  EXPECT_TRUE(says("the measurements are from 500.0 to 500.0 s, the images from 0.0 to 72.0 s")) << messages_.str();
  EXPECT_TRUE(says("1 line of")) << messages_.str();
}

TEST_F(NavigationInput, ImagesWhoseListCountsFrom1970NeedNothing) {
  for (host::StripFrame& frame : frames_) frame.time_ns += morning;
  const auto samples = read("time_s,height_m,height_sigma_m\n1795336808,100,1\n");
  ASSERT_EQ(samples.size(), 1U);
  EXPECT_EQ(samples[0].time_ns, morning + 8 * second);
  EXPECT_EQ(messages_.str(), "");
}

}  // namespace
}  // namespace ilp::sil
