// ilp-lab on wrong command lines and damaged files: a message and exit status 1 or 2, never a crash.

#include <fstream>
#include <iterator>

#include "cfg/limits.hpp"
#include "sim/host/image_io.hpp"
#include "tests/integration/lab_program.hpp"

namespace ilp::test {
namespace {

class LabBadInput : public LabTest {
 protected:
  void SetUp() override {
    LabTest::SetUp();
    camera_ = write("cameras.txt", pinhole_text(96, 80, 100, 47.5, 39.5));
    host::Raster<std::uint8_t> image(96, 80);
    for (std::size_t i = 0; i < image.samples.size(); ++i) image.samples[i] = static_cast<std::uint8_t>(i * 37 >> 3U);
    host::write_png(path("good.png"), image.view());
    good_ = path("good.png");
    out_ = " --out " + path("out");
  }
  void refused(const std::string& arguments, int status, const std::string& part) const {
    const LabRun run = lab(arguments);
    EXPECT_EQ(run.status, status) << arguments << "\n" << run.err;
    EXPECT_NE(run.err.find(part), std::string::npos) << arguments << "\n" << run.err;
    EXPECT_EQ(run.out, "") << arguments;
  }
  std::string camera_, good_, out_;
};

TEST_F(LabBadInput, CommandLines) {
  refused("", 2, "");
  refused("fly", 2, "");
  refused("overlap " + good_, 2, "B is required");
  refused("overlap a b --method fft", 2, "--method");
  refused("overlap a b --max-rotation nan", 2, "--max-rotation");
  refused("overlap a b --repeat 0", 2, "--repeat");
  refused("stereo a b --min-disparity 5 --max-disparity 4" + out_, 2, "--max-disparity");
  refused("encode " + good_ + " --bpp -1" + out_, 2, "--bpp");
  EXPECT_EQ(lab("--help").status, 0);
  EXPECT_EQ(lab("bundle --help").status, 0);
}

TEST_F(LabBadInput, ImagesThatAreMissingDamagedOrOfOtherSizes) {
  std::ifstream in(good_, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  const std::string cut = write("cut.png", bytes.substr(0, bytes.size() / 2));
  const std::string text = write("text.png", "no image\n");
  host::write_pgm(path("small.pgm"), host::Raster<std::uint8_t>(64, 80).view());
  const std::string small = path("small.pgm"), missing = path("missing.png");
  for (const std::string& bad : {cut, text, missing, small}) {
    const std::string name = std::filesystem::path(bad).filename().string();
    refused("overlap " + good_ + " " + bad, 1, name);
    refused("match " + good_ + " " + bad + out_, 1, name);
    refused("stereo " + good_ + " " + bad + " --min-disparity 0 --max-disparity 15" + out_, 1, name);
    refused("encode " + good_ + " --mask " + bad + out_, 1, name);
    refused("richness " + good_ + " --mask " + bad, 1, name);
  }
  refused("richness " + good_ + " --depth " + text, 1, "text.png");
  refused("encode " + good_ + " --out " + path("no/such/folder/x.jp2"), 1, "cannot be written");
}

TEST_F(LabBadInput, SizesOverTheFlightLimitsNameTheLimit) {
  host::write_pgm(path("wide.pgm"), host::Raster<std::uint8_t>(limits::max_rectified_width + 1, 64, 9).view());
  const std::string wide = path("wide.pgm");
  refused("match " + wide + " " + wide + out_, 1, "limits::max_image_width");
  refused("encode " + wide + out_, 1, "limits::max_image_width");
  refused("stereo " + wide + " " + wide + " --min-disparity 0 --max-disparity 9" + out_, 1,
          "limits::max_rectified_width");
  refused("stereo " + good_ + " " + good_ + " --min-disparity 0 --max-disparity 5000" + out_, 1,
          "limits::max_disparities");
  std::string matches;
  for (std::size_t i = 0; i <= limits::max_matches; ++i) matches += "1 2 3 4\n";
  refused("homography " + write("many.txt", matches), 1, "limits::max_matches");
  refused("bundle " + write("w.txt", "17 5 10\n1 1 0 0\n") + out_, 1, "limits::max_bundle_cameras");
  refused("bundle " + write("w.txt", "2 500000 10\n1 1 0 0\n") + out_, 1, "limits::max_bundle_points");
  refused("bundle " + write("w.txt", "2 5 99999\n1 1 0 0\n") + out_, 1, "limits::max_bundle_observations");
}

TEST_F(LabBadInput, MatchLists) {
  const std::string relpose = " --camera " + camera_;
  for (const char* text : {"", "# nothing\n\n"}) {
    refused("relpose " + write("m.txt", text) + relpose, 1, "holds no match");
    refused("fundamental " + path("m.txt"), 1, "holds no match");
    refused("homography " + path("m.txt"), 1, "holds no match");
  }
  refused("relpose " + path("missing.txt") + relpose, 1, "missing.txt");
  refused("relpose " + path("") + relpose, 1, "cannot be read");
  for (const char* line :
       {"1 2 3", "1 2 3 4 5 6", "1 2 three 4", "1 2 nan 4", "1 inf 3 4", "1 2 3 4x", "\xff\xfe\x01 2 3 4"}) {
    refused("relpose " + write("m.txt", std::string("5 6 7 8\n") + line + "\n") + relpose, 1, "line 2");
  }
  write("m.txt", "1 2 3 4\n");
  refused("relpose " + path("m.txt") + " --camera " + write("c.txt", "1 PINHOLE 96 80 nan 100 48 40\n"), 1, "c.txt");
  refused("relpose " + path("m.txt") + " --camera " + path("none.txt"), 1, "none.txt");
}

TEST_F(LabBadInput, TooFewMatchesAreAVerdict) {
  const std::string list = write("m.txt", "10 20 12 21\n30 40 33 41\n");
  for (const std::string& command :
       {"relpose " + list + " --camera " + camera_, "fundamental " + list, "homography " + list}) {
    const LabRun run = lab_done(command);
    EXPECT_NE(run.verdict(), "ok") << command;
  }
}

TEST_F(LabBadInput, Windows) {
  const std::string cameras = "1 0 0 0 0 0 0\n0 0 0 0 -1 0 0\n";
  const std::string good = "2 1 2\n100 100 50 50\n0 0 50 50\n1 0 30 50\n" + cameras + "0 0 5\n";
  ASSERT_EQ(lab("bundle " + write("w.txt", good) + out_).status, 0);
  const auto window = [&](const std::string& text, const std::string& part) {
    refused("bundle " + write("w.txt", text) + out_, 1, part);
  };
  window("", "expected ncam npts nobs");
  window("2 1\n", "line 1");
  window("2.5 1 2\n", "cameras");
  window("-2 1 2\n", "cameras");
  window("2 0 2\n100 100 50 50\n", "no points");
  window("2 1 2\n100 -100 50 50\n", "focal");
  window("2 1 2\n100 100 50 50\n0 0 50 50\n2 0 30 50\n" + cameras + "0 0 5\n", "camera 2");
  window("2 1 2\n100 100 50 50\n0 0 50 50\n1 7 30 50\n" + cameras + "0 0 5\n", "point 7");
  window("2 1 2\n100 100 50 50\n0 0 50 50\n1 0 nan 50\n" + cameras + "0 0 5\n", "nan");
  window("2 1 2\n100 100 50 50\n0 0 50 50\n1 0 30 50\n" + cameras, "ends after");
  window(good + "1 2 3\n", "ended before");
  window("2 1 2\n100 100 50 50\n0 0 50 50\n1 0 30 50\n1 1e300 0 0 0 0 0\n0 0 0 0 -1 0 0\n0 0 5\n", "rotation");
  window("2 1 2\n100 100 50 50\n0 0 50 50\n0 0 30 50\n" + cameras + "0 0 5\n", "bundle");
}

TEST_F(LabBadInput, ModelsAndStrips) {
  const auto model = [&](const std::string& images, const std::string& points, const std::string& part) {
    write("images.txt", images);
    write("points3D.txt", points);
    refused("rectify " + good_ + " " + good_ + " --model " + path("") + out_, 1, part);
  };
  refused("rectify " + good_ + " " + good_ + " --model " + path("none") + out_, 1, "cameras.txt");
  model("1 1 0 0 0 0 0 0 1 other.png\n\n", "", "no image good.png: it has 1, among them other.png");
  model("1 1 0 0 0 0 0 0 2 good.png\n\n", "", "first camera");
  model("1 2 0 0 0 0 0 0 1 good.png\n\n", "", "unit length");
  model("1 1 0 0 0 0 0 nan 1 good.png\n\n", "", "finite");
  model("1 1 0 0 0 0 0 0 1 good.png\n1 2\n", "", "POINT3D_ID");
  model("1 1 0 0 0 0 0 0 1 good.png\n\n", "1 2\n", "points3D.txt");
  refused("pose-strip " + path("none") + " --camera " + camera_ + out_, 1, "none");
  std::filesystem::create_directory(path("empty"));
  refused("pose-strip " + path("empty") + " --camera " + camera_ + out_, 1, "empty");
}

TEST_F(LabBadInput, BlanksInThePathOfAStrip) {
  const auto keyframes = [&](const std::string& folder, const std::string& name) {
    std::filesystem::create_directory(path(folder));
    for (const char* number : {"1", "2", "3"})
      std::filesystem::copy_file(good_, path(folder + "/" + name + number + ".png"));
    const LabRun run = lab_done("pose-strip '" + path(folder) + "' --camera '" + camera_ + "'" + out_);
    return run.status == 0 ? run.json["keyframes"].get<int>() : -1;
  };
  const int plain = keyframes("plain", "image");
  EXPECT_GT(plain, 0);
  EXPECT_EQ(keyframes("two words", "image"), plain);
  EXPECT_EQ(keyframes("tab\there", "an image "), plain);
}

}  // namespace
}  // namespace ilp::test
