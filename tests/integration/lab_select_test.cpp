// ilp-lab select on strips of windows of one landscape, so that every overlap is known.

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "sim/host/image_io.hpp"
#include "tests/integration/lab_program.hpp"
#include "tests/support/strip.hpp"

namespace ilp::test {
namespace {

constexpr int width = 320, height = 240;

using Gray = host::Raster<std::uint8_t>;

/// The landscape from (x0, 0) on; upside down: turned by half a turn about the window's centre.
Gray window(double x0, bool upside_down = false) {
  Gray image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double grey =
          upside_down ? fractal_texture(x0 + (width - 1 - x), height - 1 - y, 2, 5) : fractal_texture(x0 + x, y, 2, 5);
      image.at(x, y) = static_cast<std::uint8_t>(std::clamp(grey, 0.0, 255.0));
    }
  }
  return image;
}

class LabSelect : public LabTest {
 protected:
  void SetUp() override {
    LabTest::SetUp();
    std::filesystem::create_directory(path("strip"));
  }
  void add(const std::string& name, const Gray& image) const { host::write_pgm(path("strip/" + name), image.view()); }
  void add_windows(const std::vector<double>& places) const {
    for (std::size_t i = 0; i < places.size(); ++i) add(name_of(i), window(places[i]));
  }
  static std::string name_of(std::size_t i) {
    std::ostringstream name;
    name << static_cast<char>('a' + i) << ".pgm";
    return name.str();
  }
  [[nodiscard]] std::string strip() const { return path("strip"); }
  static std::string decisions(const LabRun& run) {
    std::string letters;
    for (const auto& image : run.json.at("images")) {
      const auto decision = image.at("decision").get<std::string>();
      letters += decision == "new strip" ? 'N' : decision == "passed over" ? 'x' : decision[0];
    }
    return letters;
  }
  static std::string reason(const LabRun& run, std::size_t i) {
    return run.json.at("images").at(i).at("reason").get<std::string>();
  }
};

// Overlap of two windows is 1 - distance / 320.
const std::vector<double> places = {
    0,     // begins
    20,    // 0.94 with a
    40,    // 0.88 with a
    70,    // 0.78 with a: kept
    100,   // 0.91 with d: the last before the gap, kept
    230,   // 0.50 with d, 0.59 with e: kept
    5000,  // elsewhere: matches nothing, and the next neither: begins a new strip
    5080,  // 0.75 with g: kept
    5240,  // 0.50 with h, less than the minimum, and 0.25 with g: features relate it, kept
    5400,  // 0.50 with i, and nothing of h: begins a new strip
    5420,  // 0.94 with j: the end, kept
};
const std::string chosen = "NsskkkNkkNk";
const std::vector<std::size_t> compared_with = {99, 0, 0, 0, 3, 4, 99, 6, 7, 8, 9};

TEST_F(LabSelect, KnownOverlapsGiveTheKnownChoice) {
  add_windows(places);
  const LabRun run = lab_done("select " + strip() + " --target 0.82 --minimum 0.55 --json");
  EXPECT_EQ(decisions(run), chosen) << run.out;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto& image = run.json["images"][i];
    EXPECT_EQ(image["name"], strip() + "/" + name_of(i));
    if (!image["overlap"].is_number()) continue;
    ASSERT_LT(compared_with[i], places.size()) << run.out;
    EXPECT_EQ(image["keyframe"], strip() + "/" + name_of(compared_with[i]));
    EXPECT_NEAR(image["overlap"].get<double>(), 1 - (places[i] - places[compared_with[i]]) / width, 0.01) << i;
    EXPECT_NEAR(image["rotation_deg"].get<double>(), 0, 0.2);
    EXPECT_NEAR(image["scale"].get<double>(), 1, 0.01);
  }
  EXPECT_EQ(run.number("strips"), 3);
  EXPECT_EQ(run.number("kept"), 9);
  EXPECT_EQ(run.number("skipped"), 2);
  EXPECT_NE(reason(run, 3).find("at or below the target"), std::string::npos);
  EXPECT_NE(reason(run, 4).find("f.pgm shares less than 0.55 with d.pgm"), std::string::npos) << reason(run, 4);
  EXPECT_NE(reason(run, 6).find("neither it nor h.pgm matches f.pgm"), std::string::npos) << reason(run, 6);
  EXPECT_NE(reason(run, 8).find("related by features: shares only 0.5"), std::string::npos) << reason(run, 8);
  EXPECT_NE(reason(run, 9).find("begins a new strip: shares only 0.5"), std::string::npos) << reason(run, 9);
  EXPECT_NE(reason(run, 10).find("the end"), std::string::npos) << reason(run, 10);
}

TEST_F(LabSelect, AVideoIsChosenFromAsItsImagesAre) {
  std::string video = "YUV4MPEG2 W320 H240 F25:1 Cmono\n", kept_images, kept_frames;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Gray image = window(places[i]);
    add(name_of(i), image);
    video += "FRAME\n" + std::string(image.samples.begin(), image.samples.end());
    if (chosen[i] == 's') continue;
    kept_images += strip() + "/" + name_of(i) + "\n";
    kept_frames += "frame-0000" + std::string(i + 1 < 10 ? "0" : "") + std::to_string(i + 1) + "\n";
  }
  const std::string file = write("flight.y4m", video);
  EXPECT_EQ(lab("select " + strip() + " --list").out, kept_images);
  EXPECT_EQ(lab("select --y4m " + file + " --list").out, kept_frames);
  // The last frame is cut off; what came before it stays.
  write("short.y4m", video.substr(0, video.size() - 100));
  const LabRun cut = lab_done("select --y4m " + path("short.y4m") + " --json");
  EXPECT_EQ(decisions(cut), chosen.substr(0, 10) + "x");
}

TEST_F(LabSelect, TheTableSaysWhatHappenedToEveryImage) {
  add("a.pgm", window(0));
  add("b.pgm", Gray(width, height, 1));
  add("c.pgm", window(12));
  add("d.pgm", window(12));
  add("e.pgm", Gray(width, 100, 90));
  write("strip/f.pgm", "P5 320 240 255\nshort");
  add("g.pgm", window(80));
  const LabRun run = lab_done("select " + strip());
  std::vector<std::string> lines;
  std::istringstream text(run.out);
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  const std::vector<std::vector<std::string>> expected = {
      {"image", "decision", "overlap"},
      {"a.pgm", "new strip", "first strip"},
      {"b.pgm", "rejected", "too_dark", "too dark"},
      {"c.pgm", "skipped", "0.96", "above the target"},
      {"d.pgm", "passed over", "same bytes"},
      {"e.pgm", "passed over", "320x100", "320x240"},
      {"f.pgm", "passed over"},
      {"g.pgm", "kept", "0.75"},
      {"kept 2 of 7 images in 1 strip, 1 skipped, 1 rejected, 3 passed over"},
  };
  ASSERT_EQ(lines.size(), expected.size()) << run.out;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    for (const std::string& part : expected[i]) EXPECT_NE(lines[i].find(part), std::string::npos) << lines[i];
  }
}

TEST_F(LabSelect, ADarkImageBetweenTwoUnrelatedOnesLosesNeither) {
  // The first unrelated image is still needed after the dark one.
  add("a.pgm", window(0));
  add("b.pgm", window(5000));
  add("c.pgm", Gray(width, height, 1));
  add("d.pgm", window(5020));
  const LabRun run = lab_done("select " + strip() + " --json");
  EXPECT_EQ(decisions(run), "NNrk") << run.out;
}

TEST_F(LabSelect, TheNearestToTheTargetIsKeptThoughAnotherCameLater) {
  // The balloon swings back before the gap: b, not c, reaches farthest towards d.
  add_windows({0, 50, 30, 190});
  const LabRun run = lab_done("select " + strip() + " --json");
  EXPECT_EQ(decisions(run), "Nksk") << run.out;
  EXPECT_NEAR(run.json["images"][3]["overlap"].get<double>(), 1 - 140.0 / width, 0.01);
}

TEST_F(LabSelect, OptionsAndMissionFilesChangeTheChoice) {
  add_windows({0, 20, 40, 60, 80});
  const auto kept = [&](const std::string& options) {
    return decisions(lab("select " + strip() + " --json " + options));
  };
  EXPECT_EQ(kept(""), "Nsskk");
  EXPECT_EQ(kept("--target 0.95"), "Nkkkk");
  EXPECT_EQ(kept("--target 0.90"), "Nsksk");
  const std::string mission = write("m.ini", "[overlap]\ntarget_overlap = 0.90\n[acquisition]\ncapture_mode = 2\n");
  EXPECT_EQ(kept("--mission " + mission), "Nsksk");
  EXPECT_EQ(kept("--mission " + mission + " --target 0.95"), "Nkkkk");
}

TEST_F(LabSelect, AFullTurnIsSearchedWhenAskedFor) {
  add("a.pgm", window(0));
  add("b.pgm", window(80, true));
  write("m.ini", "[overlap]\nfeature_overlap = 0\n");
  const std::string line = "select " + strip() + " --json --mission " + path("m.ini");
  const LabRun straight = lab(line);
  EXPECT_EQ(decisions(straight), "NN");
  EXPECT_NE(straight.json["images"][1]["reason"].get<std::string>().find("nothing in it matches"), std::string::npos);
  const LabRun turned = lab_done(line + " --full-turn");
  EXPECT_EQ(decisions(turned), "Nk") << turned.out;
  EXPECT_NEAR(std::fabs(turned.json["images"][1]["rotation_deg"].get<double>()), 180, 0.5);
  EXPECT_NEAR(turned.json["images"][1]["overlap"].get<double>(), 0.75, 0.01);
}

TEST_F(LabSelect, BadInputIsRefusedWithTheReason) {
  const auto refused = [&](const std::string& arguments, int status, const std::string& part) {
    const LabRun run = lab("select " + arguments);
    EXPECT_EQ(run.status, status) << arguments << "\n" << run.err;
    EXPECT_NE(run.err.find(part), std::string::npos) << arguments << "\n" << run.err;
    EXPECT_EQ(run.out, "") << arguments;
  };
  refused(strip(), 1, "holds no image");
  refused(path("none"), 1, "not a folder");
  add("a.pgm", window(0));
  refused(strip(), 1, "1 of 1 images can be used, expected two at least");
  add("b.pgm", Gray(64, 64, 90));
  refused(strip(), 1, "b.pgm: 64x64 pixels, expected 320x240");
  add("b.pgm", window(20));
  refused(strip() + " --target 0.6 --minimum 0.6", 1, "target overlap 0.6: expected more than the minimum overlap");
  refused(strip() + " --target 0.5", 1, "minimum overlap, 0.55");
  refused(strip() + " --target 1.5", 2, "--target");
  refused(strip() + " --list --json", 2, "--json");
  refused(strip() + " --mission " + path("none.ini"), 1, "none.ini");
  refused("", 2, "DIR or --y4m");
  refused(strip() + " --y4m x", 2, "DIR or --y4m");
  refused("--y4m " + path("none.y4m"), 1, "cannot be opened");
  refused("--y4m " + write("bad.y4m", "RIFF\n"), 1, "bad.y4m");
  refused("--y4m " + write("empty.y4m", "YUV4MPEG2 W320 H240 F25:1 Cmono\n"), 1, "0 of 0 images");
}

}  // namespace
}  // namespace ilp::test
