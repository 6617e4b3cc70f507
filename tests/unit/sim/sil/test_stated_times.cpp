// The order and the times of photographs by EXIF: one odd file never decides for all.
#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "sim/sil/stated_times.hpp"

namespace ilp::sil {
namespace {

constexpr std::int64_t second = 1'000'000'000, noon = 1'795'000'000 * second;

class StatedTimes : public testing::Test {
 protected:
  void add(const std::string& name, std::optional<std::int64_t> camera, std::optional<std::int64_t> gps = {}) {
    Photo& photo = strip_.emplace_back();
    photo.frame = {static_cast<std::int64_t>(strip_.size() - 1) * 2 * second, name, {}, true};
    photo.header.emplace();
    photo.header->time_ns = camera;
    photo.header->gps_time_ns = gps;
  }
  std::string order() const {
    std::string text;
    for (const Photo& photo : strip_) text += photo.frame.file.string() + " ";
    return text;
  }
  std::vector<std::int64_t> take() {
    epoch_ = take_stated_times(strip_, messages_);
    std::vector<std::int64_t> times;
    for (const Photo& photo : strip_) times.push_back(photo.frame.time_ns);
    return times;
  }
  bool says(const char* part) const { return messages_.str().find(part) != std::string::npos; }

  std::vector<Photo> strip_;
  std::optional<StripEpoch> epoch_;
  std::ostringstream messages_;
};

TEST_F(StatedTimes, ACounterThatRollsOverDoesNotChangeTheOrder) {
  add("DJI_0001", noon + 10 * second);
  add("DJI_0002", noon + 15 * second);
  add("DJI_0998", noon);
  add("DJI_0999", noon + 5 * second);
  EXPECT_EQ(take(), (std::vector<std::int64_t>{0, 5 * second, 10 * second, 15 * second}));
  EXPECT_EQ(order(), "DJI_0998 DJI_0999 DJI_0001 DJI_0002 ");
  EXPECT_TRUE(says("not that of the names")) << messages_.str();
  ASSERT_TRUE(epoch_);
  EXPECT_EQ(epoch_->time_ns, noon);
  EXPECT_FALSE(epoch_->utc);
}

TEST_F(StatedTimes, OnePhotographWithoutATimeIsLeftOutByNameAndTheOthersKeepTheirs) {
  for (int i = 0; i < 4; ++i) add("p" + std::to_string(i), i == 0 ? std::nullopt : std::optional(noon + i * second));
  EXPECT_EQ(take(), (std::vector<std::int64_t>{0, second, 2 * second}));
  EXPECT_TRUE(says("left out: 1 photograph without a time in EXIF, which the others state; the first is p0"))
      << messages_.str();
}

TEST_F(StatedTimes, AClockThatBeganAnewIsLeftOutByName) {
  for (int i = 0; i < 4; ++i) add("p" + std::to_string(i), i == 2 ? 946'684'800 * second : noon + i * second);
  EXPECT_EQ(take(), (std::vector<std::int64_t>{0, second, 3 * second}));
  EXPECT_TRUE(says("more than 30 days")) << messages_.str();
  EXPECT_TRUE(says("p2")) << messages_.str();
}

TEST_F(StatedTimes, PhotographsOfOneSecondAreSpreadOverIt) {
  for (int i = 0; i < 6; ++i) add("p" + std::to_string(i), noon + i / 2 * second);
  const std::int64_t half = second / 2;
  EXPECT_EQ(take(), (std::vector<std::int64_t>{0, half, 2 * half, 3 * half, 4 * half, 5 * half}));
  EXPECT_EQ(order(), "p0 p1 p2 p3 p4 p5 ");
}

TEST_F(StatedTimes, TimesThatFewStateAreNotUsedAndThatIsTold) {
  for (int i = 0; i < 4; ++i) add("p" + std::to_string(i), i > 1 ? std::nullopt : std::optional(noon + i * second));
  EXPECT_EQ(take(), (std::vector<std::int64_t>{0, 2 * second, 4 * second, 6 * second}));
  EXPECT_TRUE(says("only 2 of 4 photographs")) << messages_.str();
  EXPECT_FALSE(epoch_);
}

TEST_F(StatedTimes, OneTimeForAllIsNoTime) {
  for (int i = 0; i < 4; ++i) add("p" + std::to_string(i), noon);
  EXPECT_EQ(take()[1], 2 * second);
  EXPECT_TRUE(says("are not used")) << messages_.str();
}

TEST_F(StatedTimes, TimesOfPositionsAreUtcAndCountWhereThoseOfTheCameraAreTheSame) {
  for (int i = 0; i < 4; ++i) add("p" + std::to_string(i), noon, noon + i * second);
  EXPECT_EQ(take()[3], 3 * second);
  ASSERT_TRUE(epoch_);
  EXPECT_TRUE(epoch_->utc);
}

TEST_F(StatedTimes, AListOfTimesHasPrecedence) {
  for (int i = 0; i < 3; ++i) {
    add("p" + std::to_string(i), noon - i * second);
    strip_.back().frame.time_is_assumed = false;
  }
  EXPECT_EQ(take(), (std::vector<std::int64_t>{0, 2 * second, 4 * second}));
  EXPECT_EQ(messages_.str(), "");
}

}  // namespace
}  // namespace ilp::sil
