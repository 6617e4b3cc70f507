// ilp-lab on photographs as people have them: JPEG, TIFF, 16 bits, more pixels than the flight takes. The same ground
// as PGM files is the truth.

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>

#include "cfg/limits.hpp"
#include "sim/host/image_io.hpp"
#include "tests/integration/lab_program.hpp"
#include "tests/support/jpeg_file.hpp"
#include "tests/support/strip.hpp"
#include "tests/support/tiff_file.hpp"

namespace ilp::test {
namespace {

constexpr int width = 320, height = 240;
/// Two pixels of the large photographs become one.
constexpr int zoom = 2 * limits::max_image_width / width;

double ground(double x, double y) {
  return std::clamp(fractal_texture(x, y, 2, 5), 0.0, 255.0);
}

/// A strip of windows of one landscape, which begin at these places, in one format.
class LabPhotograph : public LabTest {
 protected:
  void add_pgm(const std::string& name, double x0) const {
    host::Raster<std::uint8_t> image(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) image.at(x, y) = static_cast<std::uint8_t>(ground(x0 + x, y));
    }
    host::write_pgm(path(name), image.view());
  }
  /// Each pixel of the window is a block of `times` by `times`.
  void add_jpeg(const std::string& name, double x0, int times = 1) const {
    const auto luma = [&](std::int32_t x, std::int32_t y) {
      return static_cast<std::uint8_t>(ground(x0 + x / times, y / times));
    };
    const std::vector<std::uint8_t> bytes = jpeg_file(times * width, times * height, luma, {.quality = 97});
    std::ofstream(path(name), std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  /// 12 bits above a black of 400, as a sensor has them.
  void add_tiff(const std::string& name, double x0) const {
    std::vector<std::uint16_t> values;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) values.push_back(static_cast<std::uint16_t>(400 + 10 * ground(x0 + x, y)));
    }
    write_tiff(path(name), width, height, values);
  }
  [[nodiscard]] LabRun selection(const std::string& folder) const { return lab("select " + path(folder) + " --json"); }
};

TEST_F(LabPhotograph, EveryFormatHasTheOverlapsOfTheSamePgmFiles) {
  const double places[] = {0, 20, 70, 130, 5000, 5080};
  for (const char* folder : {"pgm", "jpeg", "large", "tiff"}) std::filesystem::create_directory(path(folder));
  for (std::size_t i = 0; i < std::size(places); ++i) {
    const std::string number = std::to_string(i);
    add_pgm("pgm/" + number + ".pgm", places[i]);
    add_jpeg("jpeg/" + number + ".jpg", places[i]);
    add_jpeg("large/" + number + ".jpg", places[i], zoom);
    add_tiff("tiff/" + number + ".tif", places[i]);
  }
  const LabRun truth = selection("pgm");
  ASSERT_EQ(truth.status, 0) << truth.err;
  ASSERT_EQ(truth.number("kept"), 5);
  for (const auto& [folder, extension] : {std::pair("jpeg", ".jpg"), {"large", ".jpg"}, {"tiff", ".tif"}}) {
    SCOPED_TRACE(folder);
    const LabRun run = selection(folder);
    ASSERT_EQ(run.status, 0) << run.err;
    ASSERT_EQ(run.json["images"].size(), std::size(places));
    for (std::size_t i = 0; i < std::size(places); ++i) {
      const auto &image = run.json["images"][i], &same = truth.json["images"][i];
      EXPECT_EQ(image["decision"], same["decision"]) << i;
      EXPECT_EQ(image["overlap"].is_null(), same["overlap"].is_null()) << i;
      if (!image["overlap"].is_number() || !same["overlap"].is_number()) continue;
      EXPECT_NEAR(image["overlap"].get<double>(), same["overlap"].get<double>(), 0.003) << i;
    }
    const std::string in = path(folder) + "/";
    const LabRun pair = lab_done("overlap " + in + "0" + extension + " " + in + "2" + extension);
    EXPECT_NEAR(pair.number("overlap"), 1 - 70.0 / width, 0.005);
    EXPECT_EQ(pair.number("binning"), folder == std::string("large") ? 2 : 1);
  }
  // One image: its cues are those of the PGM.
  const LabRun plain = lab("richness " + path("pgm/0.pgm")), jpeg = lab("richness " + path("jpeg/0.jpg"));
  ASSERT_EQ(jpeg.status, 0) << jpeg.err;
  EXPECT_NEAR(jpeg.number("index"), plain.number("index"), 0.02);
  EXPECT_EQ(lab("match " + path("jpeg/0.jpg") + " " + path("tiff/1.tif") + " --out " + path("m.txt")).status, 0);
}

TEST_F(LabPhotograph, DamagedOnesAreNamed) {
  add_jpeg("whole.jpg", 0);
  std::ifstream in(path("whole.jpg"), std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  std::filesystem::create_directory(path("strip"));
  for (const double place : {0.0, 60.0}) add_jpeg("strip/" + std::to_string(static_cast<int>(place)) + ".jpg", place);
  write("strip/30.jpg", bytes.substr(0, bytes.size() / 2));
  const LabRun chosen = selection("strip");
  ASSERT_EQ(chosen.status, 0) << chosen.err;
  EXPECT_EQ(chosen.json["images"][1]["decision"], "passed over");
  EXPECT_EQ(chosen.number("kept"), 2);
  const LabRun pair = lab("overlap " + path("whole.jpg") + " " + path("strip/30.jpg"));
  EXPECT_EQ(pair.status, 1);
  EXPECT_NE(pair.err.find("30.jpg"), std::string::npos) << pair.err;
}

/// `overlap` and `select` on the same two images.
class LabOverlapOfPairs : public LabPhotograph {
 protected:
  void agree(const std::string& a, const std::string& b) const {
    SCOPED_TRACE(b);
    std::filesystem::remove_all(path("pair"));
    std::filesystem::create_directory(path("pair"));
    write("pair/times.txt", "0 " + a + "\n1000000000 " + b + "\n");
    const LabRun overlap = lab("overlap " + a + " " + b);
    const LabRun chosen = selection("pair");
    ASSERT_EQ(overlap.status, 0) << overlap.err;
    ASSERT_EQ(chosen.status, 0) << chosen.err;
    const auto& second = chosen.json["images"][1];
    EXPECT_EQ(second["verdict"], overlap.json["verdict"]);
    if (overlap.verdict() != "ok") return;
    EXPECT_EQ(second["overlap"], overlap.json["overlap"]);
    EXPECT_EQ(second["scale"], overlap.json["scale"]);
    sources_.insert(overlap.json["source"].get<std::string>());
  }
  mutable std::set<std::string> sources_;
};

TEST_F(LabOverlapOfPairs, WindowsAgreeWithSelect) {
  for (const double place : {0.0, 40.0, 150.0, 230.0, 5000.0}) add_pgm(std::to_string(static_cast<int>(place)), place);
  for (const char* b : {"40", "150", "230", "5000"}) agree(path("0"), path(b));
}

TEST_F(LabOverlapOfPairs, RecordedPairsAgreeWithSelectByWhateverRelatesThem) {
  const std::string kite = shared("revisit_boruszyn_kite");
  if (kite.empty()) GTEST_SKIP() << "no ../shared/data/revisit_boruszyn_kite";
  const std::vector<StripImage> images = read_strip("revisit_boruszyn_kite");
  ASSERT_GT(images.size(), 20U);
  const std::string in = std::filesystem::absolute(kite + "/images").string() + "/";
  for (std::size_t i = 0; i + 1 < images.size(); ++i) agree(in + images[i].name, in + images[i + 1].name);
  EXPECT_EQ(sources_, (std::set<std::string>{"features", "overlap", "places"}));
}

}  // namespace
}  // namespace ilp::test
