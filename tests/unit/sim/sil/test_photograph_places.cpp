// Positions and times that EXIF states, as measurements of a flight: right ones, and hostile ones.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>
#include <sstream>

#include "hal/navigation/csv/navigation_file.hpp"
#include "sim/host/photograph.hpp"
#include "sim/sil/flyable_images.hpp"
#include "tests/support/exif_file.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::sil {
namespace {

namespace fs = std::filesystem;
using test::ExifTags;

ExifTags at(double longitude_deg, double latitude_deg, double elevation_m) {
  ExifTags tags;
  tags.set_place(longitude_deg, latitude_deg, elevation_m);
  return tags;
}

class PhotographPlaces : public testing::Test {
 protected:
  fs::path write(const std::string& name, const ExifTags& tags) {
    const fs::path path = folder_ / name;
    test::write_photograph(path, host::Raster<host::Rgb>(96, 64, host::Rgb{200, 100, 50}), tags);
    return path;
  }
  FlyableImages make(const std::vector<fs::path>& files) {
    std::vector<host::StripFrame> strip;
    for (const fs::path& file : files)
      strip.push_back({static_cast<std::int64_t>(strip.size()) * 2'000'000'000, file, {}, true});
    return make_flyable(strip, folder_ / "made", messages_);
  }
  std::optional<host::GeoTag> place_of(const ExifTags& tags, std::string* fault = nullptr) {
    const host::PhotographFacts facts = host::read_photograph_facts(write("one.jpg", tags));
    if (fault != nullptr) *fault = facts.place_fault;
    EXPECT_FALSE(facts.place && !facts.place_fault.empty());
    return facts.place;
  }
  std::vector<NavigationSample> samples_of(const fs::path& file) {
    NavigationFile source;
    EXPECT_TRUE(source.open(file.c_str()).ok());
    std::vector<NavigationSample> samples;
    NavigationSample sample;
    while (source.next(longest_duration_ns, sample).ok()) samples.push_back(sample);
    return samples;
  }

  test::TemporaryFolder folder_;
  std::ostringstream messages_;
};

TEST_F(PhotographPlaces, AreReadOnBothSidesOfTheEquatorAndOfTheMeridian) {
  for (const auto& [longitude, latitude, elevation] :
       {std::tuple{4.4, 51.25, 17.5}, {-70.123456, -33.987654, 2300.0}, {179.99, 0.001, -12.25}}) {
    const auto place = place_of(at(longitude, latitude, elevation));
    ASSERT_TRUE(place);
    EXPECT_NEAR(place->longitude_deg, longitude, 2e-9);
    EXPECT_NEAR(place->latitude_deg, latitude, 2e-9);
    ASSERT_TRUE(place->elevation_m);
    EXPECT_NEAR(*place->elevation_m, elevation, 1e-3);
    EXPECT_FALSE(place->horizontal_error_m);
  }
}

TEST_F(PhotographPlaces, BecomeMeasurementsOfTheFlightAtTheTimesOfTheImages) {
  std::vector<fs::path> files;
  for (int i = 0; i < 4; ++i) {
    ExifTags tags = at(4.4 + 1e-4 * i, 51.25, 120 + i);
    tags.time = "2026:11:22 08:40:0" + std::to_string(i);
    tags.subsecond = "25";
    if (i == 2) tags.error_m = test::ExifRational{15, 10};
    files.push_back(write("p" + std::to_string(i) + ".jpg", tags));
  }
  const FlyableImages images = make(files);
  ASSERT_TRUE(write_places(images, {.sigma_m = 4}, folder_ / "places.csv", messages_));
  const std::vector<NavigationSample> samples = samples_of(folder_ / "places.csv");
  ASSERT_EQ(samples.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(samples[i].time_ns, static_cast<TimeNs>(i) * ns_per_s);
    EXPECT_NEAR(samples[i].longitude_deg, 4.4 + 1e-4 * static_cast<double>(i), 2e-9);
    EXPECT_NEAR(samples[i].elevation_m, 120 + static_cast<double>(i), 1e-3);
    EXPECT_NEAR(samples[i].horizontal_sigma_m, i == 2 ? 1.5 : 4, 1e-9);
    EXPECT_NEAR(samples[i].vertical_sigma_m, i == 2 ? 3 : 8, 1e-9);
    EXPECT_NEAR(samples[i].tilt_sigma_rad, 0.1, 1e-12);
    EXPECT_EQ(samples[i].heading_sigma_rad, 0);
  }
  ASSERT_TRUE(write_places(images, {.looks_down = false}, folder_ / "oblique.csv", messages_));
  for (const NavigationSample& sample : samples_of(folder_ / "oblique.csv")) EXPECT_EQ(sample.tilt_sigma_rad, 0);
}

TEST_F(PhotographPlaces, FewerThanThreeAreNotUsed) {
  const FlyableImages images = make({write("a.jpg", at(1, 2, 3)), write("b.jpg", at(1, 2, 3)), write("c.jpg", {})});
  EXPECT_FALSE(write_places(images, {}, folder_ / "places.csv", messages_));
  EXPECT_FALSE(fs::exists(folder_ / "places.csv"));
}

TEST_F(PhotographPlaces, TimesOfThePositionsStandInForThoseThatTheCameraDoesNotState) {
  std::vector<fs::path> files;
  for (std::uint32_t i = 0; i < 3; ++i) {
    ExifTags tags = at(4.4, 51.25, 10);
    tags.time = "2026:11:22 08:40:00";  // whole seconds, the same three times
    tags.gps_date = "2026:11:22";
    tags.gps_time = {{7, 1}, {40, 1}, {100 + 35 * i, 100}};
    files.push_back(write("t" + std::to_string(i) + ".jpg", tags));
  }
  const FlyableImages images = make(files);
  EXPECT_EQ(images.frames[1].time_ns, 350'000'000);
  EXPECT_EQ(images.frames[2].time_ns, 700'000'000);
  EXPECT_NE(messages_.str().find("EXIF states with the positions"), std::string::npos) << messages_.str();
}

TEST_F(PhotographPlaces, HostilePositionsAreLeftOutInPlainWords) {
  const auto refused = [&](const ExifTags& tags, const char* part) {
    std::string fault;
    EXPECT_FALSE(place_of(tags, &fault)) << part;
    EXPECT_NE(fault.find(part), std::string::npos) << fault;
  };
  ExifTags tags = at(0, 0, 10);
  refused(tags, "exactly 0");
  tags = at(4, 51, 10);
  tags.latitude_letter.clear();
  refused(tags, "without N or S");
  tags = at(4, 51, 10);
  tags.longitude_letter = "X";
  refused(tags, "without E or W");
  tags = at(4, 51, 10);
  tags.latitude = {{91, 1}, {0, 1}, {0, 1}};
  refused(tags, "beyond 90");
  tags = at(4, 51, 10);
  tags.latitude = {{51, 0}, {0, 0}, {0, 0}};  // divided by nothing
  refused(tags, "unknown");
  tags = at(4, 51, 10);
  tags.latitude = {{51, 1}, {15, 1}, {0, 0}};  // a place to a minute, two kilometres
  refused(tags, "not both degrees");
  tags = at(4, 51, 10);
  tags.latitude = {{51, 1}, {61, 1}, {0, 1}};
  refused(tags, "not both degrees");
  tags = at(4, 51, 10);
  tags.longitude.clear();
  refused(tags, "not both degrees");
  tags = at(4, 51, 10);
  tags.longitude = {{4, 1}};
  refused(tags, "not both degrees");
  // A height out of this world is left out, the place counts.
  tags = at(4, 51, 10);
  tags.altitude_m = test::ExifRational{4'000'000'000U, 1};
  const auto place = place_of(tags);
  ASSERT_TRUE(place);
  EXPECT_FALSE(place->elevation_m);
  tags = at(4, 51, 10);
  tags.error_m = test::ExifRational{0, 0};
  EXPECT_FALSE(place_of(tags)->horizontal_error_m);
}

TEST_F(PhotographPlaces, AFaultIsToldOnceWithTheFirstFile) {
  const fs::path bad = write("bad.jpg", at(0, 0, 1)), worse = write("worse.jpg", at(0, 0, 1));
  const FlyableImages images = make({bad, worse, write("good.jpg", at(1, 2, 3))});
  EXPECT_FALSE(images.places[0]);
  EXPECT_TRUE(images.places[2]);
  EXPECT_NE(messages_.str().find("2 positions in EXIF are not used, the first in " + bad.string()), std::string::npos)
      << messages_.str();
}

TEST_F(PhotographPlaces, ADamagedSegmentLeavesAnImageWithoutAPlace) {
  const fs::path path = write("cut.jpg", at(4, 51, 10));
  std::ifstream in(path, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(in), {}};
  for (std::size_t at_octet = 4; at_octet < 300; at_octet += 7) {
    std::string damaged = whole;
    damaged[at_octet] = static_cast<char>(damaged[at_octet] ^ 0x5A);
    std::ofstream(path, std::ios::binary) << damaged;
    try {
      const host::PhotographFacts facts = host::read_photograph_facts(path);
      if (!facts.place) continue;
      EXPECT_LE(std::abs(facts.place->latitude_deg), 90) << at_octet;
      EXPECT_LE(std::abs(facts.place->longitude_deg), 180) << at_octet;
    } catch (const std::runtime_error& refusal) {
      EXPECT_NE(std::string(refusal.what()).find("cut.jpg"), std::string::npos);
    }
  }
}

TEST_F(PhotographPlaces, PhotographsOfAnotherFocalLengthThanMostAreLeftOutByName) {
  std::vector<fs::path> files;
  for (int i = 0; i < 5; ++i) {
    ExifTags tags = at(4.4 + 1e-4 * i, 51.25, 120);
    // One states none, and one was taken with the zoom elsewhere.
    if (i != 0) tags.focal_35mm = static_cast<std::uint16_t>(i == 2 ? 48 : 31);
    files.push_back(write("photo-" + std::to_string(i) + ".jpg", tags));
  }
  const FlyableImages images = make(files);
  ASSERT_EQ(images.frames.size(), 4U);
  ASSERT_EQ(images.places.size(), 4U);
  for (const host::StripFrame& frame : images.frames) EXPECT_EQ(frame.file.string().find("photo-2"), std::string::npos);
  EXPECT_NEAR(images.places[2]->longitude_deg, 4.4 + 3e-4, 1e-8) << "the places stay beside their images";
  for (const char* part : {"photo-2.jpg", "48.0 mm", "31.0 mm", "left out"})
    EXPECT_NE(messages_.str().find(part), std::string::npos) << part << " in " << messages_.str();
}

TEST_F(PhotographPlaces, OneFocalLengthIsNothingToTell) {
  std::vector<fs::path> files;
  for (int i = 0; i < 4; ++i) {
    ExifTags tags{.focal_35mm = std::uint16_t{24}};
    files.push_back(write("photo-" + std::to_string(i) + ".jpg", tags));
  }
  EXPECT_EQ(make(files).frames.size(), 4U);
  EXPECT_EQ(messages_.str().find("focal"), std::string::npos) << messages_.str();
}

TEST_F(PhotographPlaces, AnUnknownAltitudeIsNoAltitude) {
  ExifTags tags = at(4, 51, 10);
  tags.altitude_m = test::ExifRational{0, 0};
  const auto place = place_of(tags);
  ASSERT_TRUE(place);
  EXPECT_FALSE(place->elevation_m);
  std::vector<fs::path> files;
  for (int i = 0; i < 3; ++i) files.push_back(write("u" + std::to_string(i) + ".jpg", tags));
  ASSERT_TRUE(write_places(make(files), {}, folder_ / "unknown.csv", messages_));
  for (const NavigationSample& sample : samples_of(folder_ / "unknown.csv")) EXPECT_EQ(sample.vertical_sigma_m, 0);
}

TEST_F(PhotographPlaces, FractionsCountWithAllTheirDigits) {
  ExifTags tags = at(4, 51, 10);
  tags.longitude = {{15, 1}, {30, 1}, {59'999'999, 1'000'000}};
  tags.altitude_m = test::ExifRational{123'456'789, 100'000};  // seven digits before 1e-4 m
  const auto place = place_of(tags);
  ASSERT_TRUE(place && place->elevation_m);
  EXPECT_NEAR(place->longitude_deg, 15 + 30 / 60.0 + 59.999999 / 3600, 1e-12);
  EXPECT_NEAR(*place->elevation_m, 1234.56789, 1e-9);
}

TEST_F(PhotographPlaces, SixtySecondsAreAMinuteAndDegreesMayBeDecimal) {
  ExifTags tags = at(4, 51, 10);
  tags.latitude = {{47, 1}, {17, 1}, {6000, 100}};
  ASSERT_TRUE(place_of(tags));
  EXPECT_NEAR(place_of(tags)->latitude_deg, 47.3, 1e-12);
  tags.latitude = {{473'000'001, 10'000'000}};
  ASSERT_TRUE(place_of(tags));
  EXPECT_NEAR(place_of(tags)->latitude_deg, 47.3000001, 1e-12);
  tags.latitude = {{47, 1}, {18'000'006, 1'000'000}, {0, 0}};
  ASSERT_TRUE(place_of(tags));
  EXPECT_NEAR(place_of(tags)->latitude_deg, 47.3000001, 1e-12);
}

TEST_F(PhotographPlaces, OnlyBothZerosAreNoPlace) {
  ASSERT_TRUE(place_of(at(10.5, 0, 10)));
  EXPECT_EQ(place_of(at(10.5, 0, 10))->latitude_deg, 0) << "on the equator";
  EXPECT_EQ(place_of(at(0, 51.5, 10))->longitude_deg, 0) << "in Greenwich";
}

TEST_F(PhotographPlaces, LettersOfTheReferencesCountAndThoseOfHeightsToo) {
  ExifTags tags = at(-70.5, -33.5, 10);
  tags.latitude_letter = "s";
  tags.longitude_letter = "w";
  for (const auto& [reference, elevation] : {std::pair{0, 10.0}, {1, -10.0}, {2, 10.0}, {3, -10.0}}) {
    tags.below_sea = static_cast<std::uint8_t>(reference);
    const auto place = place_of(tags);
    ASSERT_TRUE(place && place->elevation_m) << reference;
    EXPECT_EQ(*place->elevation_m, elevation) << reference;
    EXPECT_LT(place->latitude_deg, 0);
    EXPECT_LT(place->longitude_deg, 0);
  }
}

TEST_F(PhotographPlaces, SizesInTheTagsTellAReducedImageFromOneThatWasCut) {
  const auto facts_of = [&](const ExifTags& tags) { return host::read_photograph_facts(write("lens.jpg", tags)); };
  ExifTags tags;
  tags.focal_35mm = std::uint16_t{18};  // the image has 96 x 64 pixels
  tags.width = 4800;
  tags.height = 3200;
  const host::PhotographFacts reduced = facts_of(tags);
  ASSERT_TRUE(reduced.field_of_view_rad);
  EXPECT_NEAR(*reduced.field_of_view_rad, std::acos(-1) / 2, 1e-12);
  tags.height = 4800;
  const host::PhotographFacts cut = facts_of(tags);
  EXPECT_FALSE(cut.field_of_view_rad);
  EXPECT_NE(cut.lens_fault.find("4800x4800"), std::string::npos) << cut.lens_fault;
  // 4800 pixels at 254 to the inch are 480 mm; at 2540, 48 mm, seen at 24 mm: a right angle.
  tags = {};
  tags.width = 4800;
  tags.height = 3200;
  tags.focal_mm = test::ExifRational{24, 1};
  tags.pixels_per_inch = test::ExifRational{2540, 1};
  const host::PhotographFacts by_sensor = facts_of(tags);
  ASSERT_TRUE(by_sensor.field_of_view_rad);
  EXPECT_NEAR(*by_sensor.field_of_view_rad, std::acos(-1) / 2, 1e-12);
  tags.pixels_per_inch = test::ExifRational{0, 0};
  EXPECT_FALSE(facts_of(tags).field_of_view_rad);
}

TEST_F(PhotographPlaces, AnglesOfAGimbalBecomeTheAttitudeAndNobodyLooksDownByDefault) {
  std::vector<fs::path> files;
  for (int i = 0; i < 4; ++i) {
    ExifTags tags = at(4.4 + 1e-4 * i, 51.25, 120);
    if (i > 0)
      tags.gimbal =
          "drone-dji:GimbalYawDegree=\"+90.00\" drone-dji:GimbalPitchDegree=\"-50.0\" "
          "drone-dji:GimbalRollDegree=\"+0.00\"";
    files.push_back(write("g" + std::to_string(i) + ".jpg", tags));
  }
  ASSERT_TRUE(write_places(make(files), {}, folder_ / "gimbal.csv", messages_));
  const std::vector<NavigationSample> samples = samples_of(folder_ / "gimbal.csv");
  ASSERT_EQ(samples.size(), 4U);
  EXPECT_EQ(samples[0].tilt_sigma_rad, 0) << "it states none, and the others do not look down";
  // East and 50 degrees below the horizon; the image's right side is south.
  const auto& a = samples[3].q_cam_from_level;
  const Eigen::Quaterniond camera_from_level(a[0], a[1], a[2], a[3]);
  const Eigen::Vector3d axis = camera_from_level.inverse() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d right = camera_from_level.inverse() * Eigen::Vector3d::UnitX();
  const double rad = std::acos(-1) / 180;
  EXPECT_LT((axis - Eigen::Vector3d(std::cos(50 * rad), 0, -std::sin(50 * rad))).norm(), 1e-6) << axis.transpose();
  EXPECT_LT((right - Eigen::Vector3d(0, -1, 0)).norm(), 1e-6) << right.transpose();
  EXPECT_NEAR(samples[3].tilt_sigma_rad, 0.02, 1e-12);
  EXPECT_NEAR(samples[3].heading_sigma_rad, 0.1, 1e-12);
}

TEST_F(PhotographPlaces, ADirectionTurnsACameraThatLooksDown) {
  std::vector<fs::path> files;
  for (int i = 0; i < 3; ++i) {
    ExifTags tags = at(4.4 + 1e-4 * i, 51.25, 120);
    tags.direction_deg = test::ExifRational{900, 10};
    files.push_back(write("d" + std::to_string(i) + ".jpg", tags));
  }
  ASSERT_TRUE(write_places(make(files), {}, folder_ / "direction.csv", messages_));
  const std::vector<NavigationSample> samples = samples_of(folder_ / "direction.csv");
  ASSERT_EQ(samples.size(), 3U);
  const auto& a = samples[0].q_cam_from_level;
  const Eigen::Quaterniond camera_from_level(a[0], a[1], a[2], a[3]);
  // The upper side of the image is east.
  EXPECT_LT((camera_from_level * Eigen::Vector3d::UnitX() - Eigen::Vector3d(0, -1, 0)).norm(), 1e-6);
  EXPECT_LT((camera_from_level * Eigen::Vector3d::UnitZ() - Eigen::Vector3d(0, 0, -1)).norm(), 1e-6);
  EXPECT_GT(samples[0].heading_sigma_rad, 0.3);
}

}  // namespace
}  // namespace ilp::sil
