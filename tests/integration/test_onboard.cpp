#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <sstream>
#include <thread>

#include "cfg/limits.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"
#include "sim/ground/intake/catalogue.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/host/colmap.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/integration/running_program.hpp"
#include "tests/support/store_records.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

const fs::path plain = test::prepared_flights() / "plain";

TEST(OnboardTest, TheFlightBinaryAllocatesNothingInFlightAndMakesTheSameProducts) {
  const test::TemporaryFolder folder;
  fs::create_directories(folder / "outbox");
  fs::create_directories(folder / "acknowledged");
  const test::ProgramResult result =
      test::run_well({ILP_ONBOARD, "--virtual-time", "--trap-heap", "--index", (plain / "index.txt").string(),
                      "--camera", test::camera_numbers(plain), "--database", folder / "flight.db", "--outbox",
                      folder / "outbox", "--acknowledgements", folder / "acknowledged"});
  EXPECT_NE(result.output.find("heap requests after sealing: 0\n"), std::string::npos) << result.output;
  // In virtual time no frame is late or takes mission time.
  EXPECT_NE(
      result.output.find(" 0 overran, the longest took 0 ms, the latest began 0 us late; work level 0, 0 changes\n"),
      std::string::npos)
      << result.output;
  test::expect_same_files(test::files_of(test::prepared_flights() / "uninterrupted" / "outbox", {"product-"}),
                          test::files_of(folder / "outbox", {"product-"}));
}

class OnboardFlight : public testing::Test {
 protected:
  OnboardFlight() {
    fs::create_directories(folder_ / "outbox");
    fs::create_directories(folder_ / "acknowledged");
  }
  std::vector<std::string> command(const std::string& database, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {ILP_ONBOARD,
                                      "--virtual-time",
                                      "--index",
                                      (plain / "index.txt").string(),
                                      "--camera",
                                      test::camera_numbers(plain),
                                      "--database",
                                      database,
                                      "--outbox",
                                      folder_ / "outbox",
                                      "--acknowledgements",
                                      folder_ / "acknowledged"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  static std::vector<StartRecord> boots(const std::string& database) {
    SqliteStore store;
    EXPECT_TRUE(store.open_read_only(database.c_str()).ok());
    return test::records_of<StartRecord>(store);
  }
  void expect_products() const {
    test::expect_same_files(test::files_of(test::prepared_flights() / "uninterrupted" / "outbox", {"product-"}),
                            test::files_of(folder_ / "outbox", {"product-"}));
  }

  test::TemporaryFolder folder_;
};

TEST_F(OnboardFlight, KilledAgainAndAgainItsBootsAreOnRecordAndTheProductsAreTheSame) {
  const std::string database = folder_ / "flight.db";
  bool ended = false;
  int kills = 0;
  for (int boot = 0; boot < 8 && !ended; ++boot) {
    ended = test::run_and_kill(command(database), 200 + 41 * boot);
    kills += ended ? 0 : 1;
  }
  if (!ended) {
    test::run_well(command(database));
  }
  expect_products();
  const std::vector<StartRecord> all = boots(database);
  ASSERT_GT(kills, 0);
  // A boot that was killed while it still opened its store has no record.
  ASSERT_LE(all.size(), static_cast<std::size_t>(kills) + 1);
  for (std::size_t i = 0; i < all.size(); ++i) {
    // The kill may have come after an ordered end.
    const bool ended_before = i > 0 && all[i - 1].end_ns != 0;
    const StartReason after = ended_before ? StartReason::stopped : StartReason::process_died;
    EXPECT_EQ(all[i].reason, i == 0 ? StartReason::first : after) << "boot " << i + 1;
    EXPECT_EQ(all[i].failed, 0U) << "self-tests of boot " << i + 1;
  }
  EXPECT_NE(all.back().end_ns, 0);
  EXPECT_GT(all.back().stack_bytes, 0U);
  EXPECT_LT(all.back().stack_bytes, limits::flight_stack_bytes / 4 * 3);
  EXPECT_EQ(all.back().heap_traps, 0U);
}

TEST_F(OnboardFlight, WithAWorkerTheFilesAreTheSame) {
  const auto files = [&] { return test::files_of(folder_ / "outbox", {"product-", "records-", "points-"}); };
  ASSERT_EQ(test::run_program(command(folder_ / "inline.db", {"--worker", "inline"})).exit_status, 0);
  const auto without = files();
  ASSERT_FALSE(without.empty());
  for (const char* name : {"outbox", "acknowledged"}) {
    fs::remove_all(folder_ / name);
    fs::create_directories(folder_ / name);
  }
  const test::ProgramResult flown =
      test::run_well(command(folder_ / "thread.db", {"--worker", "thread", "--trap-heap"}));
  EXPECT_NE(flown.output.find("heap requests after sealing: 0\n"), std::string::npos) << flown.output;
  test::expect_same_files(without, files());
  std::size_t products = 0;
  for (const auto& file : without) products += file.first.starts_with("product-") ? 1 : 0;
  EXPECT_NE(flown.output.find("worker: " + std::to_string(products) + " jobs"), std::string::npos) << flown.output;
}

TEST_F(OnboardFlight, KilledAgainAndAgainWithAWorkerTheFilesAreTheSame) {
  const std::vector<std::string> words = command(folder_ / "flight.db", {"--worker", "thread"});
  int kills = 0;
  bool ended = false;
  for (int boot = 0; boot < 8 && !ended; ++boot) {
    ended = test::run_and_kill(words, 170 + 43 * boot);
    kills += ended ? 0 : 1;
  }
  if (!ended) {
    test::run_well(words);
  }
  EXPECT_GT(kills, 0);
  expect_products();
}

TEST_F(OnboardFlight, ADamagedDatabaseIsRefusedOrSetAsideAndTheFlightBeginsAnew) {
  const std::string database = folder_ / "flight.db";
  test::write_file(database, std::string(20'000, 'x'));
  const test::ProgramResult refused = test::run_program(command(database));
  EXPECT_EQ(refused.exit_status, 1);
  EXPECT_NE(refused.output.find("database is damaged"), std::string::npos) << refused.output;
  test::run_well(command(database, {"--fly-on"}));
  EXPECT_EQ(fs::file_size(database + ".aside-1"), 20'000U);
  expect_products();
}

/// The strip once more, taken so much later.
std::string later_strip(const std::string& to, TimeNs later) {
  const auto octets = test::read_file(plain / "index.txt");
  std::istringstream index(std::string(octets.begin(), octets.end()));
  std::string text;
  for (std::string line; std::getline(index, line);) {
    std::istringstream words(line);
    TimeNs time = 0;
    std::string name, rest;
    if (!(words >> time >> name)) continue;
    std::getline(words, rest);
    text += std::to_string(time + later) + " " + (plain / name).string() + rest + "\n";
  }
  test::write_file(to, text);
  return to;
}

// The ground's tools need not know: ids and names of files are others, times go on.
TEST_F(OnboardFlight, TheGroundTellsTheStoreEpochsOfAFlightApartAndMixesNothing) {
  const std::string database = folder_ / "flight.db";
  ASSERT_EQ(test::run_program(command(database)).exit_status, 0);
  const auto first = test::files_of(folder_ / "outbox", {"product-", "records-", "points-", "refine-"});
  ASSERT_GT(first.size(), 2U);
  test::write_file(database, std::string(20'000, 'x'));
  std::vector<std::string> again = command(database, {"--fly-on"});
  *std::find(again.begin(), again.end(), (plain / "index.txt").string()) =
      later_strip(folder_ / "later.txt", 3600 * ns_per_s);
  test::run_well(again);
  const auto all = test::files_of(folder_ / "outbox", {"product-", "records-", "points-", "refine-"});
  EXPECT_EQ(all.size(), 2 * first.size());
  for (const auto& [name, bytes] : first) {
    EXPECT_EQ(all.count(name), 1U) << name;
    EXPECT_TRUE(all.at(name) == bytes) << name << " of the first boot was replaced";
  }
  intake::Catalogue catalogue(folder_ / "catalogue.db");
  catalogue.take_in(folder_ / "outbox");
  intake::Outbox outbox = catalogue.outbox();
  const intake::Flight flight = intake::build_flight(outbox);
  for (const intake::ReceivedFile& file : outbox.files) EXPECT_EQ(file.fault, "") << file.name;
  std::size_t of_boot[2] = {};
  for (const auto& [id, keyframe] : flight.keyframes) {
    const bool second = id > 100'000'000;
    ++of_boot[second ? 1 : 0];
    ASSERT_TRUE(keyframe.record.has_value()) << "keyframe " << id;
    EXPECT_EQ(keyframe.record->strip_id > 100'000'000, second) << "keyframe " << id;
    EXPECT_EQ(keyframe.record->time_ns >= 3600 * ns_per_s, second) << "keyframe " << id;
  }
  EXPECT_GT(of_boot[0], 2U);
  EXPECT_EQ(of_boot[0], of_boot[1]);
  EXPECT_EQ(flight.strips.size() % 2, 0U);
}

/// The strip as a YUV4MPEG2 stream of one frame every four seconds.
std::string stream_of_strip(const std::string& to) {
  std::string stream = "YUV4MPEG2 W320 H240 F1:4 Ip A1:1 Cmono\n";
  for (int number = 1; number <= 20; ++number) {
    char name[32];
    std::snprintf(name, sizeof(name), "%04d.pgm", number);
    const test::Bytes image = test::read_file(plain / "images" / name);
    stream += "FRAME\n";
    stream.append(image.end() - 320 * 240, image.end());
  }
  test::write_file(to, stream);
  return to;
}

/// The strip under the names that a stream gives its frames: products hold them.
std::string strip_named_as_stream(const std::string& folder) {
  fs::create_directories(folder);
  std::string index;
  for (int number = 1; number <= 20; ++number) {
    char name[64];
    std::snprintf(name, sizeof(name), "%04d.pgm", number);
    const fs::path image = plain / "images" / name;
    std::snprintf(name, sizeof(name), "frame-%06d", number);
    fs::copy_file(image, fs::path(folder) / name);
    index += std::to_string((number - 1) * 4 * ns_per_s) + " " + name + "\n";
  }
  test::write_file(folder + "/index.txt", index);
  return folder + "/index.txt";
}

TEST_F(OnboardFlight, AVideoStreamMakesTheSameProductsAlsoAfterAKill) {
  std::vector<std::string> words = command(folder_ / "images.db");
  const auto source = std::find(words.begin(), words.end(), (plain / "index.txt").string());
  *source = strip_named_as_stream(folder_ / "images");
  ASSERT_EQ(test::run_program(words).exit_status, 0);
  const auto expected = test::files_of(folder_ / "outbox", {"product-"});
  ASSERT_GT(expected.size(), 10U);

  for (const char* name : {"outbox", "acknowledged"}) {
    fs::remove_all(folder_ / name);
    fs::create_directories(folder_ / name);
  }
  *std::find(words.begin(), words.end(), "--index") = "--y4m";
  *source = stream_of_strip(folder_ / "strip.y4m");
  *std::find(words.begin(), words.end(), folder_ / "images.db") = folder_ / "stream.db";
  static_cast<void>(test::run_and_kill(words, 400));
  test::run_well(words);
  test::expect_same_files(expected, test::files_of(folder_ / "outbox", {"product-"}));
}

TEST_F(OnboardFlight, AVideoStreamOfAnotherSizeOrOfNoneIsRefused) {
  std::vector<std::string> words = command(folder_ / "flight.db");
  *std::find(words.begin(), words.end(), "--index") = "--y4m";
  const auto source = std::find(words.begin(), words.end(), (plain / "index.txt").string());
  const auto expect_refused = [&](const std::string& stream, const std::string& why) {
    *source = folder_ / "strip.y4m";
    test::write_file(*source, stream);
    const test::ProgramResult flown = test::run_program(words);
    EXPECT_EQ(flown.exit_status, 1) << flown.output;
    EXPECT_NE(flown.output.find("strip.y4m"), std::string::npos) << flown.output;
    EXPECT_NE(flown.output.find(why), std::string::npos) << flown.output;
  };
  expect_refused("YUV4MPEG2 W64 H48 F1:4 Cmono\n", "image of 64 px x 48 px");
  expect_refused("RIFF....AVI \n", "malformed");
  words.push_back("--index");
  words.push_back((plain / "index.txt").string());
  EXPECT_EQ(test::run_program(words).exit_status, 2) << "one source of images";
}

/// A picture of the strip in which each pixel is `times` x `times` pixels.
std::string enlarged(int number, int times) {
  char name[32];
  std::snprintf(name, sizeof(name), "%04d.pgm", number);
  const test::Bytes file = test::read_file(plain / "images" / name);
  const auto* const pixels = file.data() + file.size() - 320 * 240;
  std::string picture;
  for (int y = 0; y < 240 * times; ++y) {
    for (int x = 0; x < 320 * times; ++x) picture += static_cast<char>(pixels[y / times * 320 + x / times]);
  }
  return picture;
}

std::string enlarged_camera(int times) {
  std::istringstream numbers(test::camera_numbers(plain));
  double width = 0, height = 0, fx = 0, fy = 0, cx = 0, cy = 0;
  numbers >> width >> height >> fx >> fy >> cx >> cy;
  std::ostringstream text;
  text.precision(17);
  text << width * times << " " << height * times << " " << fx * times << " " << fy * times << " "
       << (cx + 0.5) * times - 0.5 << " " << (cy + 0.5) * times - 0.5;
  return text.str();
}

// The pictures of 1280 x 960 are the images of 640 x 480 with doubled pixels: their means are these images.
TEST_F(OnboardFlight, PicturesLargerThanTheImagesMakeTheProductsOfTheirImages) {
  constexpr int frames = 6;
  fs::create_directories(folder_ / "images");
  std::string index, stream = "YUV4MPEG2 W1280 H960 F1:4 Cmono\n";
  for (int number = 1; number <= frames; ++number) {
    char name[32];
    std::snprintf(name, sizeof(name), "frame-%06d", number);
    test::write_file(folder_ / "images/" + name, "P5\n640 480\n255\n" + enlarged(number, 2));
    index += std::to_string((number - 1) * 4 * ns_per_s) + " " + name + "\n";
    stream += "FRAME\n" + enlarged(number, 4);
  }
  test::write_file(folder_ / "images/index.txt", index);
  test::write_file(folder_ / "strip.y4m", stream);
  std::vector<std::string> words = command(folder_ / "images.db", {"--trap-heap"});
  const auto source = std::find(words.begin(), words.end(), (plain / "index.txt").string());
  const auto camera = std::find(words.begin(), words.end(), test::camera_numbers(plain));
  *source = folder_ / "images/index.txt";
  *camera = enlarged_camera(2);
  test::run_well(words);
  const auto expected = test::files_of(folder_ / "outbox", {"product-"});
  ASSERT_GT(expected.size(), 1U);

  for (const char* name : {"outbox", "acknowledged"}) {
    fs::remove_all(folder_ / name);
    fs::create_directories(folder_ / name);
  }
  *std::find(words.begin(), words.end(), "--index") = "--y4m";
  *source = folder_ / "strip.y4m";
  *camera = enlarged_camera(4);
  *std::find(words.begin(), words.end(), folder_ / "images.db") = folder_ / "stream.db";
  const test::ProgramResult large = test::run_well(words);
  EXPECT_NE(large.output.find("pictures of 1280 x 960 become images of 640 x 480"), std::string::npos) << large.output;
  test::expect_same_files(expected, test::files_of(folder_ / "outbox", {"product-"}));

  // Without --camera it goes on with the camera on record, which is that of the images.
  words.erase(camera - 1, camera + 1);
  test::run_well(words);
}

TEST_F(OnboardFlight, WithoutADiskItFliesFromMemory) {
  const test::ProgramResult flown = test::run_well(command(folder_ / "none/flight.db", {"--fly-on", "--trap-heap"}));
  EXPECT_NE(flown.output.find("store in memory"), std::string::npos) << flown.output;
  // Not the same bytes: they name the parameters, of which the storage budget is smaller.
  const auto expected = test::files_of(test::prepared_flights() / "uninterrupted" / "outbox", {"product-"});
  const auto sent = test::files_of(folder_ / "outbox", {"product-"});
  EXPECT_EQ(sent.size(), expected.size());
  for (const auto& product : expected) EXPECT_EQ(sent.count(product.first), 1U) << product.first;
}

TEST_F(OnboardFlight, TheMemoryMapSumsToTheStaticSizeOfTheBinary) {
  const test::ProgramResult map = test::run_well({ILP_ONBOARD, "--memory-map"});
  const test::ProgramResult headers = test::run_well({"/usr/bin/readelf", "-lW", ILP_ONBOARD});
  std::size_t writable = 0;
  std::istringstream segments(headers.output);
  for (std::string line; std::getline(segments, line);) {
    std::istringstream words(line);
    std::string type;
    std::string offset;
    std::string address;
    std::string physical;
    std::string file_bytes;
    std::string bytes;
    words >> type >> offset >> address >> physical >> file_bytes >> bytes;
    if (type == "LOAD" && line.find(" RW ") != std::string::npos) writable += std::stoul(bytes, nullptr, 16);
  }
  ASSERT_GT(writable, 0U) << headers.output;
  std::size_t sum = 0;
  std::istringstream rows(map.output);
  std::string line;
  std::getline(rows, line);
  while (std::getline(rows, line)) {
    const std::size_t bytes = std::stoul(line);
    if (line.find(" total (") != std::string::npos) {
      EXPECT_EQ(bytes, sum);
      break;
    }
    sum += bytes;
    if (line.find("libraries, tables and the rest") != std::string::npos) {
      EXPECT_LT(bytes, std::size_t{1} << 20U) << "static memory that no row of the map names";
    }
  }
  EXPECT_EQ(sum, writable);
}

class WithoutCamera : public testing::Test {
 protected:
  WithoutCamera() {
    for (const char* name : {"outbox", "acknowledged"}) fs::create_directories(folder_ / name);
    test::write_file(folder_ / "mission.ini", "[calibration]\ncamera_known = false\nfield_of_view_rad = 0.9\n");
  }
  [[nodiscard]] test::ProgramResult fly(std::vector<std::string> more) const {
    std::vector<std::string> words = {ILP_ONBOARD,        "--virtual-time",      "--trap-heap",
                                      "--database",       folder_ / "flight.db", "--outbox",
                                      folder_ / "outbox", "--acknowledgements",  folder_ / "acknowledged"};
    words.insert(words.end(), more.begin(), more.end());
    return test::run_program(words);
  }
  void expect_refused(const std::vector<std::string>& more, const std::string& named) const {
    const test::ProgramResult refused = fly(more);
    EXPECT_NE(refused.exit_status, 0);
    EXPECT_NE(refused.output.find(named), std::string::npos) << refused.output;
  }
  const std::string index = (test::prepared_flights() / "rugged" / "index.txt").string();
  test::TemporaryFolder folder_;
};

TEST_F(WithoutCamera, TheFlightBeginsWithTheStatedFieldOfViewAndFindsItsCamera) {
  const test::ProgramResult flown = fly({"--index", index, "--mission", folder_ / "mission.ini"});
  ASSERT_EQ(flown.exit_status, 0) << flown.output;
  EXPECT_NE(flown.output.find("nominal camera: 320 x 240"), std::string::npos) << flown.output;
  const auto cameras = test::records_of<CameraRecord>(fs::path(folder_ / ""));
  ASSERT_EQ(cameras.size(), 3U);
  EXPECT_NEAR(2 * std::atan2(160, cameras[1].fx), 0.9, 1e-9);
  EXPECT_EQ(cameras[0].source, CameraSource::calibrated);
  const double truth = host::read_colmap_camera(test::prepared_flights() / "rugged" / "cameras.txt").fx;
  EXPECT_NEAR(cameras[0].fx, truth, 0.01 * truth);
  const auto posed = test::records_of<PoseRecord>(fs::path(folder_ / ""));
  // It goes on with the camera on record, whatever field of view the mission names now.
  test::write_file(folder_ / "mission.ini", "[calibration]\ncamera_known = false\nfield_of_view_rad = 1.5\n");
  const test::ProgramResult again = fly({"--index", index, "--mission", folder_ / "mission.ini"});
  EXPECT_EQ(again.exit_status, 0) << again.output;
  EXPECT_EQ(test::records_of<CameraRecord>(fs::path(folder_ / ""))[1].fx, cameras[1].fx);
  EXPECT_EQ(test::records_of<PoseRecord>(fs::path(folder_ / "")).size(), posed.size());
}

TEST_F(WithoutCamera, AFlightThatEndsBeforeItsCameraIsFoundSaysWhyItHasNoProducts) {
  test::RunningProgram flight(
      {ILP_ONBOARD, "--index", index, "--mission", folder_ / "mission.ini", "--database", folder_ / "flight.db",
       "--outbox", folder_ / "outbox", "--acknowledgements", folder_ / "acknowledged"},
      folder_ / "flight.log");
  ASSERT_TRUE(flight.says("nominal camera")) << flight.output();
  const auto keyframes = [&] {
    return fs::exists(folder_ / "flight.db") ? test::records_of<KeyframeRecord>(fs::path(folder_ / "")).size() : 0;
  };
  for (int i = 0; i < 600 && keyframes() == 0; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(flight.stop(), 0) << flight.output();
  EXPECT_NE(flight.output().find("the camera is not known yet after"), std::string::npos) << flight.output();
  EXPECT_NE(flight.output().find("or begin a flight with --camera"), std::string::npos);
}

TEST_F(WithoutCamera, TheSizeComesFromTheVideo) {
  const test::ProgramResult flown =
      fly({"--y4m", stream_of_strip(folder_ / "strip.y4m"), "--mission", folder_ / "mission.ini"});
  ASSERT_EQ(flown.exit_status, 0) << flown.output;
  const auto cameras = test::records_of<CameraRecord>(fs::path(folder_ / ""));
  ASSERT_EQ(cameras.size(), 3U);
  EXPECT_EQ(cameras[1].width, 320);
  EXPECT_EQ(cameras[1].height, 240);
}

TEST_F(WithoutCamera, WhatIsMissingIsNamed) {
  expect_refused({"--index", index}, "camera_known");
  test::write_file(folder_ / "empty.txt", "1000 none.pgm\n");
  const std::string mission = folder_ / "mission.ini";
  expect_refused({"--index", folder_ / "empty.txt", "--mission", mission}, "--size");
  expect_refused({"--index", index, "--size", "640", "--mission", mission}, "--size");
  expect_refused({"--index", index, "--size", "640x480", "--camera", test::camera_numbers(plain), "--mission", mission},
                 "--size does not go with --camera");
  expect_refused({"--y4m", stream_of_strip(folder_ / "strip.y4m"), "--size", "64x48", "--mission", mission},
                 "strip.y4m");
}

TEST(OnboardTest, MissingFilesAndFoldersAreNamed) {
  const test::TemporaryFolder folder;
  fs::create_directories(folder / "outbox");
  fs::create_directories(folder / "acknowledged");
  const auto fly = [&](const std::string& index, const std::string& database, const std::string& outbox) {
    return test::run_program({ILP_ONBOARD, "--virtual-time", "--index", index, "--camera", test::camera_numbers(plain),
                              "--database", database, "--outbox", outbox, "--acknowledgements",
                              folder / "acknowledged"});
  };
  const std::string index = (plain / "index.txt").string();
  const test::ProgramResult no_index = fly(folder / "none.txt", folder / "a.db", folder / "outbox");
  EXPECT_EQ(no_index.exit_status, 1);
  EXPECT_NE(no_index.output.find("none.txt"), std::string::npos) << no_index.output;
  const test::ProgramResult no_database = fly(index, folder / "none/a.db", folder / "outbox");
  EXPECT_EQ(no_database.exit_status, 1);
  EXPECT_NE(no_database.output.find("none/a.db"), std::string::npos) << no_database.output;
  const test::ProgramResult no_outbox = fly(index, folder / "b.db", folder / "none");
  EXPECT_EQ(no_outbox.exit_status, 1);
  EXPECT_NE(no_outbox.output.find("outbox"), std::string::npos) << no_outbox.output;
}

TEST(OnboardTest, ATerminalThatClosesEndsNeitherAFlightNorANode) {
  const test::TemporaryFolder folder;
  const std::string database = folder / "flight.db";
  test::RunningProgram flight({ILP_ONBOARD, "--index", (plain / "index.txt").string(), "--camera",
                               test::camera_numbers(plain), "--store", "memory", "--link-udp", "127.0.0.1:0"},
                              folder / "flight.log");
  EXPECT_NE(flight.address("packets over UDP").port, 0) << flight.output();
  test::RunningProgram node({ILP_ONBOARD, "--stages", "dense_matcher", "--store", database}, folder / "node.log");
  EXPECT_TRUE(node.says("waiting for the primary of the flight")) << node.output();
  for (test::RunningProgram* program : {&flight, &node}) {
    program->send(SIGHUP);
    program->send(SIGTERM);
    // A flight that has not taken an image yet ends with 1; what a signal has killed has no status.
    EXPECT_GE(program->wait(), 0) << program->output();
  }
}

TEST(OnboardTest, AWrongOptionIsNamedWithTheNearestOne) {
  const auto expect = [](std::vector<std::string> words, const std::string& message) {
    words.insert(words.begin(), ILP_ONBOARD);
    const test::ProgramResult result = test::run_program(words);
    EXPECT_EQ(result.exit_status, 2) << message;
    EXPECT_EQ(result.output, "ilp-onboard: " + message + "; ilp-onboard --help lists all options\n");
  };
  expect({"--stroe", "memory"}, "--stroe is no option, the nearest is --store");
  expect({"--link-upd", "127.0.0.1:1"}, "--link-upd is no option, the nearest is --link-udp");
  expect({"--frobnicate-everything"}, "--frobnicate-everything is no option");
  expect({std::string(100, 'x')}, std::string(100, 'x') + " is no option");
  expect({"--virtual-time", "--store"}, "--store needs a value");
  expect({"--index", "a", "--outbox", "b", "--acknowledgements", "c"}, "--store is missing");
  expect({"--store", "memory", "--index", "a"}, "--outbox is missing, and no link is stated");
  expect({"--store", "memory", "--outbox", "b", "--acknowledgements", "c"},
         "--index, --v4l2, --y4m are the sources of images: one is needed");
  expect({"--store", "memory", "--index", "a", "--y4m", "b"}, "--y4m does not go with another source of images");
  expect({"--store", "memory", "--virtual-time", "--outbox", "b", "--acknowledgements", "c", "--v4l2", "d"},
         "--v4l2 does not go with --virtual-time");
  const test::ProgramResult help = test::run_program({ILP_ONBOARD, "--help"});
  EXPECT_EQ(help.exit_status, 0);
  EXPECT_NE(help.output.find("(--index FILE | --v4l2 DEVICE[,SETTING...] | --y4m FILE|-)"), std::string::npos);
  EXPECT_NE(help.output.find("--acknowledgements DIR"), std::string::npos);
}

}  // namespace
}  // namespace ilp
