// Navigation samples from text: columns, empty cells, and files that are none.
#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <string>

#include "fsw/base/rng.hpp"
#include "hal/navigation/csv/navigation_file.hpp"
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

constexpr TimeNs late = std::numeric_limits<TimeNs>::max();

class NavigationFileTest : public testing::Test {
 protected:
  Status open(const std::string& text) {
    std::ofstream(folder_ / "n.csv", std::ios::binary) << text;
    return file_.open((folder_ / "n.csv").c_str());
  }
  Status next(TimeNs now = late) { return file_.next(now, sample_); }

  test::TemporaryFolder folder_;
  NavigationFile file_;
  NavigationSample sample_;
};

TEST_F(NavigationFileTest, ColumnsComeInAnyOrderAndCellsMayBeEmpty) {
  ASSERT_OK(
      open("# of a vehicle\r\n"
           "height_sigma_m, time_s ,height_m,longitude_deg,latitude_deg,horizontal_sigma_m,qw,qx,qy,qz,"
           "tilt_sigma_rad\r\n"
           "0.5,1.25,80,10,-4,2,0,1,0,0,0.01\r\n"
           "\r\n"
           ",1.5,,11,-4.5,2,,,,,\r\n"));
  EXPECT_TRUE(file_.recorded());
  EXPECT_STATUS(next(1'249'999'999), not_ready);
  ASSERT_OK(next(1'250'000'000));
  EXPECT_EQ(sample_.time_ns, 1'250'000'000);
  EXPECT_EQ(sample_.height_m, 80);
  EXPECT_EQ(sample_.height_sigma_m, 0.5);
  EXPECT_EQ(sample_.longitude_deg, 10);
  EXPECT_EQ(sample_.q_cam_from_level[1], 1);
  EXPECT_EQ(sample_.tilt_sigma_rad, 0.01);
  EXPECT_EQ(sample_.heading_sigma_rad, 0);
  EXPECT_TRUE(plausible(sample_));
  ASSERT_OK(next());
  EXPECT_EQ(sample_.height_sigma_m, 0) << "an empty cell is no measurement";
  EXPECT_EQ(sample_.tilt_sigma_rad, 0);
  EXPECT_EQ(sample_.horizontal_sigma_m, 2);
  EXPECT_TRUE(plausible(sample_));
  EXPECT_STATUS(next(), end_of_stream);
  EXPECT_STATUS(next(), end_of_stream);
}

TEST_F(NavigationFileTest, AHeaderMustBeUnderstoodAndComplete) {
  EXPECT_STATUS(file_.open((folder_ / "none.csv").c_str()), not_found);
  EXPECT_STATUS(open(""), truncated);
  EXPECT_STATUS(open("# only a comment\n"), truncated);
  const Status unknown = open("time_s,height_ft,height_sigma_m\n1,2,3\n");
  EXPECT_STATUS(unknown, parse_error);
  EXPECT_EQ(unknown.a, 1);
  EXPECT_EQ(unknown.b, 2) << "the column with the unknown unit";
  EXPECT_STATUS(open("time_s,height_m,height_m\n"), parse_error) << "twice";
  EXPECT_STATUS(open("time_s,height_m\n"), parse_error) << "no sigma";
  EXPECT_STATUS(open("height_m,height_sigma_m\n"), parse_error) << "no time";
  EXPECT_STATUS(open("time_s,longitude_deg,horizontal_sigma_m\n"), parse_error) << "no latitude";
  EXPECT_STATUS(open(std::string(10'000, 'x') + "\n"), parse_error);
  EXPECT_STATUS(next(), end_of_stream) << "nothing comes from a file that was refused";
  EXPECT_OK(open("time_s\n"));
}

TEST_F(NavigationFileTest, ABadLineIsLeftOutAndTheNextOneIsRead) {
  ASSERT_OK(
      open("time_s,height_m,height_sigma_m\n"
           "1,80,1\n"
           "2,eighty,1\n"
           "3,80\n"
           "4,80,1,9\n"
           ",80,1\n"
           "5,nan,1\n"
           "6,inf,1\n"
           "7e300,80,1\n" +
           std::string(600, '8') + "\n" + std::string("8,8\0,1\n", 7) +
           "0.5,80,1\n"
           "9,81,1"));
  ASSERT_OK(next());
  for (int line = 3; line <= 10; ++line) {
    const Status status = next();
    EXPECT_STATUS(status, parse_error);
    EXPECT_EQ(status.a, line);
  }
  EXPECT_STATUS(next(), parse_error) << "a zero octet";
  EXPECT_STATUS(next(), time_not_monotonic);
  ASSERT_OK(next());
  EXPECT_EQ(sample_.height_m, 81);
  EXPECT_STATUS(next(), end_of_stream);
}

TEST_F(NavigationFileTest, DatesWithAZoneAndAMarkOfByteOrder) {
  ASSERT_OK(
      open("\xEF\xBB\xBF# saved by a spreadsheet\n"
           "time_s,height_m,height_sigma_m\n"
           "2026-11-22T08:40:08.5Z,80,1\n"
           "2026-11-22T10:40:09+02:00,81,1\n"
           "2026-02-31T08:40:10Z,82,1\n"
           "2026-11-22T08:40:11,83,1\n"
           "1795336812,84,1\n"));
  ASSERT_OK(next());
  EXPECT_EQ(sample_.time_ns, 1'795'336'808 * ns_per_s + ns_per_s / 2);
  ASSERT_OK(next());
  EXPECT_EQ(sample_.time_ns, 1'795'336'809 * ns_per_s);
  for (int line = 5; line <= 6; ++line) {
    const Status status = next();
    EXPECT_STATUS(status, parse_error) << "no day of the calendar, no zone";
    EXPECT_EQ(status.a, line);
  }
  ASSERT_OK(next());
  EXPECT_EQ(sample_.time_ns, 1'795'336'812 * ns_per_s);
  ASSERT_OK(open("\xEF\xBB\xBFtime_s,height_m,height_sigma_m\n1,80,1\n"));
  ASSERT_OK(next());
  EXPECT_EQ(sample_.height_m, 80);
}

TEST_F(NavigationFileTest, OctetsOfAnyKindEnd) {
  Rng rng(11);
  const std::string letters = "time_s,0123456789.eE+-\n\r#\"\0xyz";
  for (int trial = 0; trial < 2000; ++trial) {
    std::string text = trial % 2 == 0 ? "time_s,height_m,height_sigma_m\n" : "";
    const std::uint32_t size = rng.below(300);
    for (std::uint32_t i = 0; i < size; ++i) text += letters[rng.below(static_cast<std::uint32_t>(letters.size()))];
    if (!open(text).ok()) continue;
    int calls = 0;
    while (!next().is(StatusCode::end_of_stream)) ASSERT_LT(++calls, 400);
  }
}

TEST(NavigationSampleTest, ValuesThatNoVehicleMeasuresAreImplausible) {
  NavigationSample good{.height_m = 80, .height_sigma_m = 1};
  EXPECT_TRUE(plausible(good));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double height : {-1.0, 0.0, 1e9, nan}) {
    NavigationSample bad = good;
    bad.height_m = height;
    EXPECT_FALSE(plausible(bad)) << height;
  }
  NavigationSample bad = good;
  bad.height_sigma_m = -1;
  EXPECT_FALSE(plausible(bad));
  bad = good;
  bad.tilt_sigma_rad = 0.01;
  bad.q_cam_from_level[0] = 2;
  EXPECT_FALSE(plausible(bad)) << "no unit quaternion";
  bad = good;
  bad.horizontal_sigma_m = 1;
  bad.latitude_deg = 91;
  EXPECT_FALSE(plausible(bad));
  bad = good;
  bad.velocity_m_s[2] = nan;
  EXPECT_FALSE(plausible(bad));
}

}  // namespace
}  // namespace ilp
