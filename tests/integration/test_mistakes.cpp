// What users do wrong, and what the programs tell them: what is wrong, and what to do.
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "sim/host/image_io.hpp"
#include "tests/unit/ground/export/tool.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

namespace fs = std::filesystem;

struct Mistake {
  const char*
      command;  ///< SIL, GROUND, SCORE, LAB, ONBOARD stand for the programs; run in a folder with the files below
  int status;   ///< 1: the work cannot be done, 2: the program is not called as it has to be, 3: no pose, 4: the stream
                ///< broke off
  std::vector<const char*> reported;  ///< what is wrong, then what to do
};

// The folder holds: images (three PNG files of 64 x 48 pixels), camera.txt (of them), flat (three images of one grey
// value), flat.txt (their camera), large-camera.txt, poses.txt (of other images), empty (a folder), index.txt,
// words.txt, film.mp4, streams (*.y4m), mission.ini (a wrong value), typo.ini, broken (an image that is none), wide.txt
// (a camera of larger images), full (a folder with a file), flight (with flight.db and outbox/), measurements.csv (a
// wrong column).
const std::vector<Mistake> mistakes = {
    // Wrong paths.
    {"SIL --images nowhere --out out", 1, {"nowhere is not a folder of images", "check the path"}},
    {"SIL --images empty --out out", 1, {"empty holds no image", "PNG, PGM, JPEG or TIFF"}},
    {"SIL --images images --camera no.txt --out out", 1, {"camera file no.txt cannot be read", "check the path"}},
    {"SIL --images images --out full", 1, {"full is not empty", "name a new one"}},
    {"SIL --images images --out words.txt", 1, {"words.txt is not a folder", "name another --out"}},
    {"SIL --images images --out words.txt/out", 1, {"cannot create words.txt/out", "name another --out"}},
    {"SIL --out empty --resume", 1, {"there is no flight.db in empty", "name the folder of the flight"}},
    {"SIL --y4m no.y4m --out out", 1, {"video no.y4m cannot be read", "check the path"}},
    {"SIL --images images --out out --mission no.ini",
     1,
     {"mission file no.ini", "there is no such file; check the path"}},
    {"SIL --images images --out out --mission words.txt",
     1,
     {"mission file words.txt: line 1: expected [section], key = value"}},
    {"GROUND nowhere --out out", 1, {"no such folder: nowhere", "name the outbox of a flight"}},
    {"GROUND empty --out out",
     1,
     {"nothing usable in empty", "name the one in which files of the downlink have arrived"}},
    {"GROUND flight --out out", 1, {"flight is the folder of a flight", "flight/outbox"}},
    {"SCORE empty", 1, {"empty holds no flight", "as ilp-sil --out leaves them"}},
    {"GROUND flight/outbox --out out --anchor no.json", 1, {"cannot read no.json", "check the path"}},
    {"GROUND compare nowhere dtm.tif", 1, {"nowhere: there is no such file", "check the path"}},
    {"LAB calibrate-target no.jpg", 1, {"no.jpg: cannot be read", "check the path"}},
    {"LAB overlap no.png images/1.png", 1, {"no.png: cannot be read", "check the path"}},
    {"SIL --images broken --camera wide.txt --out out", 1, {"none of the images in broken can be read"}},
    // One file in the place of another.
    {"SIL --images images --camera poses.txt --out out", 1, {"line of reference poses (--reference)", "1 PINHOLE"}},
    {"SIL --images images --camera words.txt --out out", 1, {"words.txt, line 1", "1 PINHOLE 640 480"}},
    {"SIL --images images --camera large-camera.txt --out out", 1, {"64x48", "800x480", "use the camera file of"}},
    {"SIL --images images --camera millimetres.txt --out out", 1, {"improbable", "is the focal length in px"}},
    {"SIL --images images --camera corner.txt --out out", 1, {"improbable", "outside the middle third"}},
    {"SIL --images images --out out --reference camera.txt", 1, {"this is a camera file (--camera)", "R(9) C(3)"}},
    {"SIL --images images --out out --reference poses.txt", 1, {"name no image of images", "1.png"}},
    {"SIL --y4m film.mp4 --out out", 1, {"film.mp4 is no YUV4MPEG2 stream", "ffmpeg -i film.mp4"}},
    {"SIL --y4m deep.y4m --out out", 1, {"deep.y4m has 10 bits per sample, 8 expected", "ffmpeg -i deep.y4m"}},
    {"SIL --y4m timeless.y4m --out out", 1, {"timeless.y4m states no frame rate", "--frame-rate"}},
    {"SIL --y4m torn.y4m --out out", 4, {"torn.y4m breaks off", "ended with frame 1"}},
    {"SIL --y4m short.y4m --out out",
     4,
     {"short.y4m is interlaced", "pixels that are no squares", "short.y4m is cut off inside a frame"}},
    {"SIL --images images --out out --navigation measurements.csv",
     1,
     {"measurements.csv", "docs/navigation.md", "check the file"}},
    // Nothing to be seen: three images of one grey value, of which one is a keyframe.
    {"SIL --images flat --camera flat.txt --out out", 3, {"no keyframe has a pose", "bring more images"}},
    // Wrong values.
    {"SIL --images images --out out --mission mission.ini",
     1,
     {"target_overlap = 1.8", "from 0.5 to 0.98", "docs/parameters.md"}},
    {"SIL --images images --out out --mission typo.ini",
     1,
     {"target_overlop", "no such parameter", "docs/parameters.md lists them", "did you mean overlap.target_overlap?"}},
    {"SIL --scenario mars-plain --out out",
     1,
     {"scenario mars-plain", "expected a file or one of", "did you mean mars-plains?"}},
    {"SIL --set overlap.target_overlap=0.7 --out out",
     1,
     {"[overlap]", "parameter of the flight software", "--mission"}},
    {"SIL --seed=-1 --out out", 2, {"ilp-sil: --seed: '-1' is no whole number"}},
    {"SIL --set flight.altitud_m=3 --out out", 1, {"altitud_m", "there are", "did you mean altitude_m?"}},
    {"SIL --set fligt.altitude_m=3 --out out", 1, {"[fligt]", "no such section", "did you mean flight?"}},
    {"SIL --frames 20000 --out out", 1, {"frames", "from 1 to 9999"}},
    {"SIL --set flight.drift_heading_rad=90 --out out", 1, {"6.28", "degrees, written 90deg"}},
    {"SIL --set effects.haze --out out", 1, {"expected section.name=value"}},
    // Links.
    {"SIL --link-udp 127.0.0.1:1 --out out", 2, {"need --real-time"}},
    {"SIL --real-time --link-udp localhost:1 --out out", 1, {"localhost:1", "written in numbers: 127.0.0.1:10025"}},
    {"SIL --real-time --link-tcp 192.0.2.1:7 --out out", 1, {"192.0.2.1:7", "no such address", "0.0.0.0"}},
    {"GROUND console localhost", 1, {"an address is written 127.0.0.1:10025"}},
    {"GROUND console 127.0.0.1:9 --key no.keys", 1, {"cannot read the file of keys no.keys", "check the path"}},
    {"GROUND console 127.0.0.1:9 --key open.keys", 1, {"others may read the file of keys open.keys", "chmod 600"}},
#ifdef ILP_ONBOARD  // it is not built for the sanitizers
    {"ONBOARD --index index.txt --camera \"64 48 55 55 31.5 23.5\" --virtual-time --outbox empty "
     "--acknowledgements empty --store memory --mission words.txt",
     1,
     {"mission file words.txt: line 1: expected [section], key = value"}},
    {"ONBOARD --index index.txt --camera \"64 48 55 55 31.5 23.5\" --virtual-time --outbox no --acknowledgements empty "
     "--store memory",
     1,
     {"--outbox no", "there is no such folder", "mkdir -p"}},
    {"ONBOARD --index index.txt --camera \"64 48 55 55 31.5 23.5\" --store memory --link-udp 0.0.0.0:0",
     1,
     {"link 0.0.0.0:0", "other computers", "--key FILE", "127.0.0.1", "--without-authentication"}},
    {"ONBOARD --index index.txt --camera \"64 48 55 55 31.5 23.5\" --store memory --link-tcp 192.0.2.1:7",
     1,
     {"link 192.0.2.1:7", "other computers"}},
    {"ONBOARD --index index.txt --camera \"64 48 55 55 31.5 23.5\" --store memory --link-udp 127.0.0.1:0 --cfdp-udp "
     "0.0.0.0:0",
     1,
     {"link 0.0.0.0:0", "other computers"}},
    {"ONBOARD --index index.txt --camera \"64 48 55 55 31.5 23.5\" --store memory --link-udp 0.0.0.0:0 --key keys",
     1,
     {"link 0.0.0.0:0", "[link] authentication = telecommands"}},
    {"ONBOARD --index index.txt --camera \"64 48 55 55 31.5 23.5\" --store memory --link-tcp 192.0.2.1:7 "
     "--without-authentication",
     1,
     {"link 192.0.2.1:7: this machine has no such address"}},
    {"ONBOARD --index index.txt --camera \"64 48 55 55 31.5 23.5\" --store memory --link-tcp 192.0.2.1:7 --key keys "
     "--mission sealed.ini",
     1,
     {"link 192.0.2.1:7: this machine has no such address"}},
    {"ONBOARD --index index.txt --camera \"64 48 55 55 31.5 23.5\" --store memory --link-udp [::1]:10025",
     1,
     {"[::1]:10025", "written in numbers: 127.0.0.1:10025"}},
    {"ONBOARD --index index.txt --camera \"64 48 55 55 31.5 23.5\" --store memory --link-udp 127.0.0.1:0 --key "
     "open.keys",
     1,
     {"open.keys", "others than its owner may read", "chmod 600"}},
#endif
    // Not called as it has to be: always status 2.
    {"SIL --imagse images", 2, {"--imagse", "--help"}},
    {"SIL --seed x --out out", 2, {"--seed", "--help"}},
    {"SIL --out", 2, {"--out", "--help"}},
    {"GROUND", 2, {"outbox is required", "--help"}},
    {"GROUND console", 2, {"address is required", "--help"}},
    {"SCORE", 2, {"flight is required", "--help"}},
    {"LAB", 2, {"subcommand is required", "--help"}},
    {"SIL --images images", 2, {"--out DIR is needed"}},
    {"SIL --images images --frames 3 --out out",
     2,
     {"--frames is the number of frames of a simulated flight", "leave it out"}},
    {"SIL --images images --scenario mars-plains --out out", 2, {"--scenario mars-plains", "no --images"}},
    {"SIL --images images --set world.rocks=3 --out out", 2, {"the images are recorded", "faults.name=value"}},
    {"SIL --images images --y4m torn.y4m --out out", 2, {"--images and --y4m exclude each other"}},
    {"SIL --images images --render-only --out out", 2, {"--render-only", "no --images"}},
    {"GROUND flight/outbox --out flight/outbox/ground", 2, {"lies inside the downlink", "such as", "flight/ground"}},
    {"GROUND serve flight --out flight/outbox", 2, {"lies inside the downlink", "flight/ground"}},
};

std::string with_programs(std::string command) {
  const std::vector<std::pair<std::string, const char*>> programs = {
      {"SIL", ILP_SIL},         {"GROUND", ILP_GROUND}, {"SCORE", ILP_SCORE}, {"LAB", ILP_LAB},
#ifdef ILP_ONBOARD
      {"ONBOARD", ILP_ONBOARD},
#endif
  };
  for (const auto& [word, program] : programs) {
    if (command.starts_with(word)) command.replace(0, word.size(), program);
  }
  return command;
}

class Mistakes : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* folder : {"images", "flat", "broken", "empty", "full", "flight/outbox"})
      fs::create_directories(path(folder));
    for (const char* name : {"images/1.png", "images/2.png", "images/3.png"})
      host::write_png(path(name), host::Raster<std::uint8_t>(64, 48, 90).view());
    for (const char* name : {"flat/1.png", "flat/2.png", "flat/3.png"})
      host::write_png(path(name), host::Raster<std::uint8_t>(128, 128, 90).view());
    write("flat.txt", "1 PINHOLE 128 128 110 110 64 64\n");
    write("camera.txt", "1 PINHOLE 64 48 55 55 32 24\n");
    write("millimetres.txt", "1 PINHOLE 640 480 55 55 320 240\n");
    write("corner.txt", "1 PINHOLE 640 480 550 550 500 240\n");
    write("large-camera.txt", "1 PINHOLE 800 480 550 550 400 240\n");
    write("poses.txt", "other.png 64 48 55 55 32 24 1 0 0 0 1 0 0 0 1 0 0 0\n");
    write("index.txt", "0 images/1.png\n");
    write("words.txt", "these are words\n");
    write("broken/1.png", "\x89PNG and no more");
    write("wide.txt", "1 PINHOLE 4000 3000 3500 3500 2000 1500\n");
    write("film.mp4", "\0\0\0 ftypisom and so on");
    const std::string head = "YUV4MPEG2 W64 H64", frame = "FRAME\n" + std::string(64 * 64, 'x');
    write("deep.y4m", head + " F2:1 Cmono10\n");
    write("timeless.y4m", head + " F0:0 Cmono\n" + frame);
    write("torn.y4m", head + " F2:1 C420\n" + frame + frame + frame);
    write("short.y4m", head + " F2:1 It A16:11 Cmono\n" + frame + frame.substr(0, 100));
    write("mission.ini", "[overlap]\ntarget_overlap = 1.8\n");
    write("sealed.ini", "[link]\nauthentication = telecommands\n");
    for (const char* name : {"keys", "open.keys"}) write(name, "1 " + std::string(32, 'a') + "\n");
    fs::permissions(path("keys"), fs::perms::owner_read | fs::perms::owner_write);
    fs::permissions(path("open.keys"), fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read);
    write("typo.ini", "[overlap]\ntarget_overlop = 0.8\n");
    write("full/thesis.txt", "years of work");
    write("flight/flight.db", "");
    write("measurements.csv", "time_s,height_ft\n0,300\n");
  }
  [[nodiscard]] fs::path path(const char* name) const { return fs::path(folder_ / name); }
  void write(const char* name, const std::string& text) const { std::ofstream(path(name)) << text; }

  const test::TemporaryFolder folder_;
};

TEST_F(Mistakes, AreNamedWithWhatToDo) {
  EXPECT_GE(mistakes.size(), 30U);
  for (const Mistake& mistake : mistakes) {
    const test::ToolResult result = test::run_tool("cd " + test::quoted(folder_ / "") + " && " +
                                                   with_programs(mistake.command) + " </dev/null 2>&1");
    EXPECT_EQ(result.status, mistake.status) << mistake.command << "\n" << result.output;
    for (const char* word : mistake.reported)
      EXPECT_NE(result.output.find(word), std::string::npos) << mistake.command << "\ndoes not tell: " << word << "\n"
                                                             << result.output;
    EXPECT_EQ(result.output.find("%a"), std::string::npos) << mistake.command << "\n" << result.output;
    fs::remove_all(path("out"));
  }
}

TEST_F(Mistakes, AFullDiskIsNamed) {
  host::write_png(path("image.png"), host::Raster<std::uint8_t>(128, 128, 90).view());
  const test::ToolResult result =
      test::run_tool("cd " + test::quoted(folder_ / "") + " && " ILP_LAB " encode image.png --out /dev/full 2>&1");
  EXPECT_EQ(result.status, 1) << result.output;
  EXPECT_NE(result.output.find("/dev/full cannot be written: the disk is full: free space"), std::string::npos)
      << result.output;
}

}  // namespace
}  // namespace ilp
