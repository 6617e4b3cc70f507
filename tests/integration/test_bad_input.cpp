#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>

#include "fsw/vision/overlap/overlap.hpp"
#include "hal/store/sqlite/page_checksum.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

const fs::path plain = test::prepared_flights() / "plain";
const std::string camera_file = (plain / "cameras.txt").string();

/// The program ends with status 1, or 2 after a wrong call, and its message names what is wrong.
void expect_refused(const std::vector<std::string>& command, const std::vector<std::string>& words, int status = 1) {
  const test::ProgramResult result = test::run_program(command);
  EXPECT_EQ(result.exit_status, status) << result.output;
  EXPECT_NE(result.output.find("ilp-sil: "), std::string::npos) << result.output;
  for (const std::string& word : words) {
    EXPECT_NE(result.output.find(word), std::string::npos) << "no word of '" << word << "' in: " << result.output;
  }
}

/// The mean over a square around each pixel.
host::Raster<std::uint8_t> out_of_focus(const host::Raster<std::uint8_t>& sharp, int reach) {
  host::Raster<std::uint8_t> result(sharp.width, sharp.height);
  for (int y = 0; y < sharp.height; ++y) {
    for (int x = 0; x < sharp.width; ++x) {
      int sum = 0;
      for (int dy = -reach; dy <= reach; ++dy) {
        for (int dx = -reach; dx <= reach; ++dx) {
          sum += sharp.at(std::clamp(x + dx, 0, sharp.width - 1), std::clamp(y + dy, 0, sharp.height - 1));
        }
      }
      result.at(x, y) = static_cast<std::uint8_t>(sum / ((2 * reach + 1) * (2 * reach + 1)));
    }
  }
  return result;
}

class BadInputTest : public testing::Test {
 protected:
  /// Flies over the spoilt images; the flight must end by itself.
  void fly(const test::OwnFlight& flight, int exit_status = 0) {
    const test::ProgramResult result = test::run_program(test::sil_command(flight.folder(), out));
    ASSERT_EQ(result.exit_status, exit_status) << result.output;
    said = result.output;
  }
  std::size_t final_poses() {
    const auto poses = test::records_of<PoseRecord>(out);
    return static_cast<std::size_t>(
        std::count_if(poses.begin(), poses.end(), [](const auto& pose) { return pose.state == PoseState::final; }));
  }

  test::TemporaryFolder folder;
  std::string said;
  fs::path out = folder / "out";
};

TEST_F(BadInputTest, AnEmptyFolder) {
  fs::create_directories(folder / "empty");
  expect_refused({ILP_SIL, "--images", folder / "empty", "--camera", camera_file, "--out", out.string()},
                 {"empty", "holds no image"});
}

TEST_F(BadInputTest, AFolderThatIsNotThere) {
  expect_refused({ILP_SIL, "--images", folder / "nowhere", "--camera", camera_file, "--out", out.string()},
                 {"nowhere"});
}

TEST_F(BadInputTest, AFolderWithoutAnyUsableImage) {
  fs::create_directories(folder / "broken");
  for (const char* name : {"a.png", "b.png"}) test::write_file(fs::path(folder / "broken") / name, "no image");
  expect_refused({ILP_SIL, "--images", folder / "broken", "--camera", camera_file, "--out", out.string()},
                 {"a.png", "b.png", "none of the images"});
}

TEST_F(BadInputTest, NoCameraFileAndNoImageThatCanBeRead) {
  const fs::path broken = folder / "broken";
  fs::create_directories(broken);
  test::write_file(broken / "0001.png", "no picture");
  expect_refused({ILP_SIL, "--images", folder / "broken", "--out", out.string()}, {"--camera"});
}

TEST_F(BadInputTest, ACameraFileThatIsNone) {
  test::write_file(folder / "camera.txt", "not a camera\n");
  expect_refused({ILP_SIL, "--images", plain.string(), "--camera", folder / "camera.txt", "--out", out.string()},
                 {"camera.txt"});
  expect_refused({ILP_SIL, "--images", plain.string(), "--camera", folder / "no.txt", "--out", folder / "out2"},
                 {"no.txt"});
}

TEST_F(BadInputTest, ACameraFileForAnotherShape) {
  test::write_file(folder / "camera.txt", "1 PINHOLE 640 400 554 554 320 200\n");
  expect_refused({ILP_SIL, "--images", plain.string(), "--camera", folder / "camera.txt", "--out", out.string()},
                 {"320x240", "640x400", "camera file"});
}

TEST_F(BadInputTest, AnIndexThatIsMalformed) {
  const test::OwnFlight flight(folder / "flight");
  test::write_file(flight.folder() / "index.txt", "0 images/0001.pgm\nlater images/0002.pgm\n");
  expect_refused(test::sil_command(flight.folder(), out), {"index.txt", "line 2"});
}

TEST_F(BadInputTest, ATruncatedPngInTheMiddleOfAStripIsReportedAndPassedOver) {
  const test::OwnFlight flight(folder / "flight");
  std::string index;
  for (int number = 1; number <= 12; ++number) {
    const std::string name = "images/" + std::to_string(100 + number) + ".png";
    host::write_png(flight.folder() / name, flight.frame(number).view());
    index += std::to_string(4'000'000'000LL * (number - 1)) + " " + name + "\n";
  }
  test::write_file(flight.folder() / "index.txt", index);
  fs::resize_file(flight.folder() / "images/106.png", fs::file_size(flight.folder() / "images/106.png") / 2);
  fly(flight);
  EXPECT_NE(said.find("106.png is left out"), std::string::npos) << said;
  EXPECT_EQ(test::records_of<FrameRecord>(out).size(), 11U);
  EXPECT_EQ(test::events_of(out, StatusCode::parse_error) + test::events_of(out, StatusCode::truncated), 1U);
  EXPECT_EQ(test::events_of(out, StatusCode::frame_gap), 1U);
  EXPECT_EQ(test::records_of<StripRecord>(out).size(), 1U) << "its neighbours overlap well enough";
  EXPECT_EQ(final_poses(), test::records_of<KeyframeRecord>(out).size());
}

TEST_F(BadInputTest, ImagesOfAnotherSizeAreCountedAndLeftOut) {
  const test::OwnFlight flight(folder / "flight");
  flight.keep({1, 2, 3, 4, 5, 6, 7, 8, 9, 10});
  for (const int number : {4, 5}) {
    const host::Raster<std::uint8_t> whole = flight.frame(number);
    host::Raster<std::uint8_t> part(200, 150);
    for (int y = 0; y < part.height; ++y) {
      for (int x = 0; x < part.width; ++x) part.at(x, y) = whole.at(x, y);
    }
    flight.replace(number, part);
  }
  fly(flight);
  EXPECT_EQ(test::records_of<FrameRecord>(out).size(), 8U);
  EXPECT_NE(said.find("left out: 2 photographs of 10 with another size"), std::string::npos) << said;
  EXPECT_EQ(final_poses(), test::records_of<KeyframeRecord>(out).size());
  EXPECT_GE(final_poses(), 4U);
}

TEST_F(BadInputTest, AGapEndsTheStripAndBothPiecesAreReconstructed) {
  const test::OwnFlight flight(folder / "flight");
  flight.keep({1, 2, 3, 4, 5, 6, 7, 17, 18, 19, 20});
  fly(flight);
  const auto strips = test::records_of<StripRecord>(out);
  ASSERT_EQ(strips.size(), 2U);
  EXPECT_TRUE(strips[0].end == StripEnd::overlap_lost || strips[0].end == StripEnd::overlap_unknown);
  EXPECT_EQ(strips[1].end, StripEnd::end_of_flight);
  EXPECT_EQ(test::events_of(out, StatusCode::strip_broken), 1U);
  const auto keyframes = test::records_of<KeyframeRecord>(out);
  ASSERT_GE(keyframes.size(), 5U);
  EXPECT_EQ(final_poses(), keyframes.size());
  for (const KeyframeRecord& keyframe : keyframes) {
    // The eighth image is the first after the gap.
    EXPECT_EQ(keyframe.strip_id, keyframe.frame_id < 8 ? 1 : 2) << "frame " << keyframe.frame_id;
  }
}

TEST_F(BadInputTest, BlackAndBlurredFramesGetTheirVerdictsAndTheStripGoesOn) {
  const test::OwnFlight flight(folder / "flight");
  flight.keep({1, 2, 3, 4, 5, 6, 7, 8, 9, 10});
  flight.replace(4, host::Raster<std::uint8_t>(320, 240, 0));
  host::Raster<std::uint8_t> blurred = flight.frame(7);
  for (int pass = 0; pass < 3; ++pass) blurred = out_of_focus(blurred, 5);
  flight.replace(7, blurred);
  fly(flight);
  const auto overlaps = test::records_of<OverlapRecord>(out);
  ASSERT_EQ(overlaps.size(), 10U);
  EXPECT_EQ(overlaps[3].verdict, OverlapVerdict::too_dark);
  EXPECT_EQ(overlaps[6].verdict, OverlapVerdict::blurred);
  for (const std::size_t i : {std::size_t{3}, std::size_t{6}}) {
    EXPECT_EQ(overlaps[i].decision, OverlapDecision::rejected);
  }
  EXPECT_EQ(test::events_of(out, StatusCode::overlap_unknown), 2U);
  EXPECT_EQ(test::records_of<StripRecord>(out).size(), 1U);
  EXPECT_EQ(final_poses(), test::records_of<KeyframeRecord>(out).size());
}

constexpr int without_poses = 3;  // exit status

TEST_F(BadInputTest, OnlyBlackFrames) {
  const test::OwnFlight flight(folder / "flight");
  flight.keep({1, 2, 3});
  for (int number = 1; number <= 3; ++number) flight.replace(number, host::Raster<std::uint8_t>(320, 240, 0));
  fly(flight, without_poses);
  EXPECT_EQ(test::records_of<KeyframeRecord>(out).size(), 0U);
  EXPECT_EQ(test::events_of(out, StatusCode::overlap_unknown), 3U);
}

TEST_F(BadInputTest, ASingleFrame) {
  const test::OwnFlight flight(folder / "flight");
  flight.keep({1});
  fly(flight, without_poses);
  EXPECT_EQ(test::records_of<KeyframeRecord>(out).size(), 1U);
  for (const auto& depth : test::records_of<DepthRecord>(out)) EXPECT_NE(depth.verdict, DepthVerdict::ok);
}

TEST_F(BadInputTest, AnOutputFolderThatCannotBeMade) {
  test::write_file(folder / "file", "a regular file");
  expect_refused(test::sil_command(plain, folder / "file/out"), {"file/out"});
  expect_refused(test::sil_command(plain, folder / "file"), {"file is not a folder"});
  EXPECT_EQ(test::read_file(folder / "file").size(), std::string("a regular file").size());
}

TEST_F(BadInputTest, AnOutputFolderThatIsInUse) {
  fs::create_directories(out);
  test::write_file(out / "thesis.txt", "years of work");
  expect_refused(test::sil_command(plain, out), {"not empty"});
  EXPECT_EQ(test::files_of(out, {""}).size(), 1U) << "and nothing was added to it";
}

TEST_F(BadInputTest, ADatabaseOfAnotherVersionIsRefusedAndLeftUntouched) {
  ASSERT_EQ(test::run_program(test::sil_command(plain, out, {"--power-cut-after", "100"})).exit_status, 9);
  for (const char* suffix : {"-wal", "-shm", "-sync"}) fs::remove((out / "flight.db").string() + suffix);
  // The user version of a database: 4 octets, most significant first, at offset 60 (sqlite.org/fileformat2.html).
  test::Bytes database = test::read_file(out / "flight.db");
  ASSERT_GT(database.size(), 100U);
  database[60] = 0;
  database[61] = 0;
  database[62] = 3;
  database[63] = 231;
  ASSERT_GE(database.size(), page_bytes);
  seal_page(1, Page(database.data(), page_bytes));
  test::write_file(out / "flight.db", std::string(database.begin(), database.end()));
  expect_refused(test::sil_command(plain, out, {"--resume"}), {"flight.db", "schema version 999"});
  EXPECT_EQ(test::read_file(out / "flight.db"), database);
}

TEST_F(BadInputTest, ADatabaseThatAnotherProcessFlies) {
  ASSERT_EQ(test::run_program(test::sil_command(plain, out, {"--power-cut-after", "100"})).exit_status, 9);
  const test::Bytes database = test::read_file(out / "flight.db");
  const int guard = ::open((out / "flight.db-guard").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  ASSERT_GE(guard, 0);
  ASSERT_EQ(::flock(guard, LOCK_EX), 0);
  expect_refused(test::sil_command(plain, out, {"--resume"}), {"flight.db", "another process has the database open"});
  EXPECT_EQ(test::read_file(out / "flight.db"), database);
  ::close(guard);
  EXPECT_EQ(test::run_program(test::sil_command(plain, out, {"--resume"})).exit_status, 0);
}

TEST_F(BadInputTest, ADatabaseThatIsNone) {
  fs::create_directories(out / "outbox");
  fs::create_directories(out / "acknowledged");
  test::write_file(out / "flight.db", std::string(8192, 'x'));
  expect_refused(test::sil_command(plain, out, {"--resume"}), {"flight.db"});
  EXPECT_EQ(test::read_file(out / "flight.db"), test::Bytes(8192, 'x'));
}

TEST_F(BadInputTest, MissionFiles) {
  const auto refused = [&](const std::string& text, const std::vector<std::string>& words) {
    test::write_file(folder / "mission.ini", text);
    expect_refused(test::sil_command(plain, out, {"--mission", folder / "mission.ini"}), words);
    fs::remove_all(out);
  };
  refused("[overlap]\ntarget_overlop = 0.8\n", {"mission.ini", "[overlap] target_overlop", "no such parameter"});
  refused("[overlap]\ntarget_overlap = 1.8\n", {"target_overlap = 1.8", "not a number from 0.5 to 0.98"});
  refused("[overlap]\ntarget_overlap = much\n", {"target_overlap = much", "not a number"});
  refused("[acquisition]\ncapture_mode = regulr\n", {"capture_mode = regulr", "expected", "did you mean regular?"});
  refused("[overlap]\ntarget_overlap = nan\n", {"target_overlap = nan"});
  refused("[overlap\ntarget_overlap = 0.8\n", {"mission.ini", "line 1"});
  refused("[overlap]\ntarget_overlap = 0.8\nmin overlap\n", {"mission.ini", "line 3"});
  refused("[overlap]\ntarget_overlap = 0.6\nmin_overlap = 0.7\n", {"mission.ini"});
  expect_refused(test::sil_command(plain, out, {"--mission", folder / "none.ini"}), {"none.ini"});
}

TEST_F(BadInputTest, TwoSourcesAtOnce) {
  expect_refused(test::sil_command(plain, out, {"--y4m", "-"}), {"--images", "--y4m"}, 2);
}

TEST_F(BadInputTest, VideosThatAreNone) {
  test::write_file(folder / "video.y4m", "GIF89a");
  expect_refused({ILP_SIL, "--y4m", folder / "video.y4m", "--camera", camera_file, "--out", out.string()},
                 {"video.y4m"});
  expect_refused({ILP_SIL, "--y4m", folder / "none.y4m", "--camera", camera_file, "--out", folder / "out2"},
                 {"none.y4m"});
  test::write_file(folder / "small.y4m", "YUV4MPEG2 W64 H64 F1:1 Cmono\n");
  expect_refused({ILP_SIL, "--y4m", folder / "small.y4m", "--camera", camera_file, "--out", folder / "out3"},
                 {"64x64", "320x240"});
}

}  // namespace
}  // namespace ilp
