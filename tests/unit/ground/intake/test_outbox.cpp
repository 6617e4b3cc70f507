// Files that come down in any state: what is whole is used, what is not is named and left out.
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <sstream>

#include "cfg/limits.hpp"
#include "fsw/base/crc.hpp"
#include "sim/ground/ground_run.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/intake/ids.hpp"
#include "sim/ground/intake/move_keyframe.hpp"
#include "sim/host/files.hpp"
#include "tests/support/said.hpp"
#include "tests/unit/ground/synthetic_flight.hpp"

namespace ilp::intake {
namespace {
namespace fs = std::filesystem;
using test::TemporaryFolder;

std::vector<std::uint8_t> sample_file() {
  PoseRecord pose{.id = 7};
  pose.centre[2] = 12.5;
  StructureRecord structure{.id = 7};
  structure.points.bytes = 5;
  const std::vector<RecordEntry> entries{entry_of(pose), entry_of(structure, {{1, 2, 3, 4, 5}})};
  return write_record_file(entries);
}

void repair_crc(std::vector<std::uint8_t>& file) {
  const std::uint32_t crc = crc32(std::span(file).first(file.size() - 4));
  for (std::size_t i = 0; i < 4; ++i) file[file.size() - 4 + i] = static_cast<std::uint8_t>(crc >> (8 * i));
}

std::string fault_of(const std::vector<std::uint8_t>& file) {
  try {
    (void)parse_record_file(file);
    return "";
  } catch (const BadFile& fault) {
    return fault.what();
  }
}

const ReceivedFile& file_named(const Outbox& outbox, const std::string& name) {
  for (const ReceivedFile& file : outbox.files) {
    if (file.name == name) return file;
  }
  throw std::runtime_error("not listed: " + name);
}

TEST(RecordFile, GivesBackRecordsAndBlobs) {
  const auto entries = parse_record_file(sample_file());
  ASSERT_EQ(entries.size(), 2U);
  EXPECT_EQ(record_of<PoseRecord>(entries[0]).id, 7);
  EXPECT_EQ(record_of<PoseRecord>(entries[0]).centre[2], 12.5);
  EXPECT_EQ(entries[1].blobs[0].bytes(), (std::vector<std::uint8_t>{1, 2, 3, 4, 5}));
}

TEST(RecordFile, LayoutIsTheDocumentedOne) {
  const auto file = sample_file();
  EXPECT_EQ(std::string(file.begin(), file.begin() + 4), "ILPR");
  EXPECT_EQ(file[4], schema_version);
  EXPECT_EQ(file[8], static_cast<std::uint8_t>(RecordType::pose));
  EXPECT_EQ(file[9] + 256U * file[10], serial_bytes(record_info<PoseRecord>()));
  EXPECT_EQ(file[file.size() - 5], 255);
}

TEST(RecordFile, EveryTruncationAndEveryFlippedByteIsRefused) {
  const auto whole = sample_file();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_NE(fault_of({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)}), "") << size;
  }
  for (std::size_t at = 0; at < whole.size(); ++at) {
    auto damaged = whole;
    damaged[at] ^= 0x10U;
    EXPECT_NE(fault_of(damaged), "") << at;
  }
}

TEST(RecordFile, HostileContentWithAGoodChecksumIsRefused) {
  const auto whole = sample_file();
  auto version = whole;
  version[4] = 99;
  repair_crc(version);
  EXPECT_NE(fault_of(version).find("schema 99"), std::string::npos);
  auto type = whole;
  type[8] = 200;
  repair_crc(type);
  EXPECT_NE(fault_of(type).find("type 200"), std::string::npos);
  auto length = whole;
  length[9] ^= 1U;
  repair_crc(length);
  EXPECT_NE(fault_of(length).find("pose record"), std::string::npos);
  // The blob's size, the last field of the structure record, claims four gigabytes.
  auto blob = whole;
  for (std::size_t i = 0; i < 4; ++i) blob[blob.size() - 5 - 5 - 4 + i] = 0xFF;
  repair_crc(blob);
  EXPECT_NE(fault_of(blob).find("beyond the end"), std::string::npos);
}

TEST(RecordFile, NumbersThatNoFlightHasAreRefusedWithTheirField) {
  KeyframeRecord keyframe{.id = 5};
  const auto fault = [](const auto& record) { return fault_of(write_record_file(std::vector{entry_of(record)})); };
  EXPECT_EQ(fault(keyframe), "");
  keyframe.id = largest_id;
  EXPECT_EQ(fault(keyframe), "") << "whatever store epoch it is";
  for (const std::int64_t id : {largest_id + 1, std::numeric_limits<std::int64_t>::max(), std::int64_t{-1},
                                std::numeric_limits<std::int64_t>::min()}) {
    keyframe.id = id;
    EXPECT_NE(fault(keyframe).find("keyframe record whose id is " + std::to_string(id)), std::string::npos);
    KeyframeRecord other{.id = 5, .strip_id = id};
    EXPECT_NE(fault(other).find("strip_id"), std::string::npos);
  }
  KeyframeRecord late{.id = 5, .time_ns = std::numeric_limits<std::int64_t>::max()};
  EXPECT_NE(fault(late).find("time_ns"), std::string::npos);
  ProductRecord product{.id = product_id(5, ProductKind::image), .keyframe_id = 5, .kind = ProductKind::image};
  EXPECT_EQ(fault(product), "");
  product.id = product_id(6, ProductKind::image);
  EXPECT_NE(fault(product).find("not that of its keyframe"), std::string::npos);
  EventRecord event{.id = 1, .a = std::numeric_limits<std::int64_t>::min()};
  EXPECT_EQ(fault(event), "") << "a value of an event may be anything";
}

TEST(Outbox, ANameWithANumberThatNoFlightHasIsForeign) {
  EXPECT_EQ(product_named("product-000001-image.jp2")->keyframe_id, 1);
  EXPECT_EQ(product_named("product-1152921504606846976-depth.jp2")->keyframe_id, largest_id);
  for (const char* name : {"product-4611686018427387905-image.jp2", "product-1152921504606846977-image.jp2",
                           "product-0-image.jp2", "product--1-image.jp2", "product-99999999999999999999-image.jp2",
                           "product-image.jp2", "product-1-image.jp2x"}) {
    EXPECT_FALSE(product_named(name)) << name;
  }
  const TemporaryFolder folder;
  const fs::path box = folder.path() / "outbox";
  test::write_outbox(test::make_flight(false), box);
  // 4 times its number wraps to that of keyframe 1.
  fs::rename(box / "product-000001-image.jp2", box / "product-4611686018427387905-image.jp2");
  fs::remove(box / "records-000001.ilp");
  Outbox outbox = read_outbox(box);
  const Flight flight = build_flight(outbox);
  EXPECT_NE(file_named(outbox, "product-4611686018427387905-image.jp2").fault.find("foreign"), std::string::npos);
  EXPECT_EQ(flight.keyframes.count(1), 1U) << "its depth";
  EXPECT_FALSE(flight.keyframes.at(1).has_image());
}

TEST(Outbox, ARefinementOfANumberThatNoFlightHasIsRefused) {
  RefinementHeader header{.first_layer = 2, .last_layer = 2, .shorter_bytes = 100, .bytes = 200, .head_end = 200};
  const auto fault = [&](std::int64_t id) -> std::string {
    header.product_id = id;
    std::vector<std::uint8_t> file(refinement_header_bytes + 200 + refinement_tail_bytes);
    write_refinement_header(header, std::span(file).first<refinement_header_bytes>());
    repair_crc(file);
    try {
      check_file("product-000001-image-2.ilr", file);
      return "";
    } catch (const BadFile& bad) {
      return bad.what();
    }
  };
  EXPECT_EQ(fault(product_id(1, ProductKind::image)), "");
  for (const std::int64_t id : {std::int64_t{0}, std::int64_t{3}, std::int64_t{6}, std::int64_t{-3},
                                std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()}) {
    EXPECT_NE(fault(id).find("no flight"), std::string::npos) << id;
  }
}

/// A whole .ilr file for product 1 (image) without bytes of its own: it begins with the first `same_head` bytes of a
/// file of `shorter` and goes on with the bytes of that from `from`.
std::vector<std::uint8_t> copying_refinement(std::span<const std::uint8_t> shorter, int layer, std::uint32_t same_head,
                                             std::uint32_t from, std::vector<std::uint8_t>& refined) {
  refined.assign(shorter.begin(), shorter.begin() + same_head);
  refined.insert(refined.end(), shorter.begin() + from, shorter.end());
  RefinementHeader header{.product_id = product_id(1, ProductKind::image)};
  header.first_layer = header.last_layer = static_cast<std::uint8_t>(layer);
  header.shorter_bytes = static_cast<std::uint32_t>(shorter.size());
  header.bytes = static_cast<std::uint32_t>(refined.size());
  header.crc32 = crc32(refined);
  header.same_head = header.head_end = same_head;
  header.shorter_data = from;
  header.same_data = header.shorter_bytes - from;
  std::vector<std::uint8_t> file(refinement_header_bytes + refinement_tail_bytes);
  write_refinement_header(header, std::span(file).first<refinement_header_bytes>());
  repair_crc(file);
  return file;
}

std::uint64_t bytes_of(const Outbox& outbox, bool of_products) {
  std::uint64_t bytes = 0;
  for (const ReceivedFile& file : outbox.files) bytes += of_products ? 0 : file.bytes;
  for (const ReceivedProduct& product : outbox.products) bytes += of_products ? product.bytes.size() : 0;
  return bytes;
}

TEST(Outbox, RefinementsThatTakeBytesTwiceAreRefusedAndMultiplyNothing) {
  const TemporaryFolder folder;
  const fs::path box = folder.path() / "outbox";
  test::write_outbox(test::make_flight(false), box);
  std::vector<std::uint8_t> product = host::read_file(box / "product-000001-image.jp2"), refined;
  constexpr int many = 9;
  for (int n = 0; n < many; ++n) {
    const auto bytes = static_cast<std::uint32_t>(product.size());
    // All but the last double the product; that has one byte in its head and in its data.
    const bool last = n == many - 1;
    host::write_file(box / ("refine-000001-image-bomb-" + std::to_string(n) + ".ilr"),
                     copying_refinement(product, 2 + n % 7, last ? 9 : bytes, last ? 8 : 0, refined));
    product = refined;
  }
  Outbox outbox = read_outbox(box);
  EXPECT_LE(bytes_of(outbox, true), bytes_of(outbox, false));
  for (int n = 0; n < many; ++n) {
    const std::string fault = file_named(outbox, "refine-000001-image-bomb-" + std::to_string(n) + ".ilr").fault;
    EXPECT_NE(fault.find("not a whole refinement"), std::string::npos) << n;
  }
  const Flight flight = build_flight(outbox);
  EXPECT_EQ(flight.keyframes.size(), 5U);
  for (const auto& [id, keyframe] : flight.keyframes) EXPECT_TRUE(keyframe.has_image()) << id;
}

TEST(Outbox, AProductTakesEachLayerOnceHoweverManyRefinementsComeForIt) {
  const TemporaryFolder folder;
  const fs::path box = folder.path() / "outbox";
  test::write_outbox(test::make_flight(false), box);
  std::vector<std::uint8_t> product = host::read_file(box / "product-000001-image.jp2"), refined;
  const std::size_t received = product.size();
  // Each gives a file of the size that it refines, so that all of them fit again and again.
  constexpr int many = 500;
  for (int n = 0; n < many; ++n) {
    host::write_file(box / ("refine-000001-image-" + std::to_string(n) + ".ilr"),
                     copying_refinement(product, 2 + n % (limits::max_quality_layers - 1), 8, 8, refined));
  }
  host::write_file(box / "refine-beyond.ilr",
                   copying_refinement(product, limits::max_quality_layers + 1, 8, 8, refined));
  const auto spool = std::make_shared<Spool>(folder.path());
  OutboxBuilder builder(spool);
  for (const fs::path& path : files_of(box)) builder.add(path.filename().string(), host::read_file(path));
  Outbox outbox = builder.finish();
  EXPECT_NE(file_named(outbox, "refine-beyond.ilr").fault.find("not a whole refinement"), std::string::npos);
  EXPECT_LE(spool->size(), bytes_of(outbox, false) + received) << "what is refined is put away once more";
  EXPECT_EQ(build_flight(outbox).keyframes.size(), 5U);
}

TEST(Outbox, UsesWhatIsWholeAndNamesTheRest) {
  const TemporaryFolder folder;
  const fs::path box = folder.path() / "outbox";
  test::write_outbox(test::make_flight(false), box);
  fs::resize_file(box / "product-000002-depth.jp2", fs::file_size(box / "product-000002-depth.jp2") / 2);
  fs::resize_file(box / "records-000003.ilp", 40);
  fs::copy_file(box / "product-000001-image.jp2", box / "product-000009-image.jp2");
  host::write_file(box / "product-000004-image.jp2", std::string_view("not a picture"));
  host::write_file(box / "letter.txt", std::string_view("hello"));
  host::write_file(box / "records-000077.ilp", std::string_view(""));

  Outbox outbox = read_outbox(box);
  const Flight flight = build_flight(outbox);
  EXPECT_NE(file_named(outbox, "product-000002-depth.jp2").fault, "");
  EXPECT_NE(file_named(outbox, "records-000003.ilp").fault.find("truncated"), std::string::npos);
  EXPECT_NE(file_named(outbox, "product-000009-image.jp2").fault.find("another keyframe"), std::string::npos);
  EXPECT_NE(file_named(outbox, "product-000004-image.jp2").fault, "");
  EXPECT_NE(file_named(outbox, "letter.txt").fault.find("foreign"), std::string::npos);
  EXPECT_EQ(file_named(outbox, "records-000077.ilp").fault, "empty");
  EXPECT_EQ(file_named(outbox, "product-000001-image.jp2").fault, "");

  EXPECT_EQ(flight.keyframes.size(), 5U);
  EXPECT_FALSE(flight.keyframes.at(1).inverse_depth.empty());
  EXPECT_TRUE(flight.keyframes.at(2).inverse_depth.empty());
  EXPECT_TRUE(flight.keyframes.at(4).image.empty());
  // Keyframe 3 lost its records: its products still carry camera, pose and name.
  EXPECT_TRUE(flight.keyframes.at(3).posed());
  EXPECT_EQ(flight.keyframes.at(3).name, "frame-000020.png");
  EXPECT_EQ(flight.keyframes.at(3).strip_id, 1);
}

TEST(Outbox, AProductDamagedInsideItsSizeIsFoundByItsRecord) {
  const TemporaryFolder folder;
  test::write_outbox(test::make_flight(false), folder.path());
  const fs::path path = folder.path() / "product-000001-image.jp2";
  auto bytes = host::read_file(path);
  // The grant in the metadata: the picture itself decodes.
  const std::string text(bytes.begin(), bytes.end());
  const std::size_t at = text.find("grant_bytes=1");
  ASSERT_NE(at, std::string::npos);
  bytes[at + 12] = '9';
  host::write_file(path, bytes);
  Outbox outbox = read_outbox(folder.path());
  (void)build_flight(outbox);
  EXPECT_NE(file_named(outbox, "product-000001-image.jp2").fault.find("checksum"), std::string::npos);
}

TEST(Outbox, AcknowledgesWholeFilesOnly) {
  const TemporaryFolder folder;
  const fs::path box = folder.path() / "outbox", acks = folder.path() / "acks";
  test::write_outbox(test::make_flight(false), box);
  fs::resize_file(box / "records-000003.ilp", 40);
  Outbox outbox = read_outbox(box);
  (void)build_flight(outbox);
  write_acknowledgements(acknowledgements_of(outbox), acks);
  EXPECT_FALSE(fs::exists(acks / "records-000003.ilp.ack"));
  const auto bytes = host::read_file(box / "product-000005-depth.jp2");
  EXPECT_EQ(test::text_of(acks / "product-000005-depth.jp2.ack"),
            std::to_string(bytes.size()) + " " + std::to_string(crc32(bytes)) + "\n");
}

TEST(Outbox, PointsAndMasksThatArePutAwayAreTheSame) {
  const StructurePoint point{{1, 2, 3}, 0.5F, 1};
  const StructureObservation seen{4, 10.5F, 20.25F};
  std::vector<std::uint8_t> blob(sizeof(point) + sizeof(seen));
  std::memcpy(blob.data(), &point, sizeof(point));
  std::memcpy(blob.data() + sizeof(point), &seen, sizeof(seen));
  StructureRecord structure{.id = 4, .count = 1};
  structure.points.bytes = static_cast<std::uint32_t>(blob.size());
  const std::vector<std::uint8_t> file = write_record_file(std::vector<RecordEntry>{entry_of(structure, {blob})});
  const TemporaryFolder folder;
  Similarity by{.translation = Vec3(0, 0, 7), .scale = 2};
  for (const auto& spool : {std::shared_ptr<Spool>(), std::make_shared<Spool>(folder.path())}) {
    OutboxBuilder builder(spool);
    builder.add("points-000004.ilp", file);
    Outbox outbox = builder.finish();
    Flight flight = index_flight(outbox);
    Keyframe& keyframe = flight.keyframes.at(4);
    move(by, keyframe);
    const std::vector<StructureTrackPoint> points = points_of(keyframe);
    ASSERT_EQ(points.size(), 1U);
    EXPECT_EQ(points[0].point.position[0], 2);
    EXPECT_EQ(points[0].point.position[2], 13);
    ASSERT_EQ(points[0].observations.size(), 1U);
    EXPECT_EQ(points[0].observations[0].y, 20.25F);
  }
}

TEST(Outbox, HostileNumbersInRecordsAreNotPosesAndNotDepths) {
  const TemporaryFolder folder;
  PoseRecord pose{.id = 1, .strip_id = 1, .state = PoseState::final};
  pose.q_cam_from_world[0] = unknown;
  StructureRecord structure{.id = 1, .count = 0xFFFFFFFFU};
  structure.points.bytes = 40;
  MaskRecord mask{.id = 1, .width = 0x7FFFFFFF, .height = 0x7FFFFFFF};
  mask.code.bytes = 3;
  const std::vector<RecordEntry> entries{entry_of(pose), entry_of(structure, {std::vector<std::uint8_t>(40, 0xFF)}),
                                         entry_of(mask, {{1, 255, 255}})};
  host::write_file(folder.path() / "records-000001.ilp", write_record_file(entries));
  Outbox outbox = read_outbox(folder.path());
  const Flight flight = build_flight(outbox);
  EXPECT_FALSE(flight.keyframes.at(1).posed());
  EXPECT_TRUE(points_of(flight.keyframes.at(1)).empty());
  EXPECT_GE(flight.remarks.size(), 2U);
  ground::GroundOptions options{.outbox = folder.path(), .out = folder.path() / "result"};
  std::ostringstream messages;
  EXPECT_NO_THROW(ground::run_ground(options, messages));
}

TEST(GroundRun, SaysWhatIsWrongWithFoldersAndInputs) {
  const TemporaryFolder folder;
  const auto message = [&](const ground::GroundOptions& options) -> std::string {
    std::ostringstream messages;
    return test::error_of([&] { ground::run_ground(options, messages); });
  };
  ground::GroundOptions options{.outbox = folder.path() / "empty", .out = folder.path() / "out"};
  EXPECT_NE(message(options).find("no such folder"), std::string::npos);
  fs::create_directories(options.outbox);
  EXPECT_NE(message(options).find("the folder is empty"), std::string::npos);
  if (fs::exists(options.out)) {
    for (const auto& entry : fs::directory_iterator(options.out)) {
      EXPECT_EQ(entry.path().filename(), "viewer.html") << "nothing but the page that says so may be left behind";
    }
  }

  test::write_outbox(test::make_flight(false), folder.path() / "outbox");
  options.outbox = folder.path() / "outbox";
  host::write_file(folder.path() / "file", std::string_view("x"));
  options.out = folder.path() / "file" / "out";
  EXPECT_NE(message(options).find("output folder"), std::string::npos);
  options.out = folder.path() / "out";
  options.reference = folder.path() / "missing.txt";
  EXPECT_NE(message(options).find("missing.txt"), std::string::npos);
  host::write_file(folder.path() / "bad.txt", std::string_view("# x\na.png 1 2 3\n"));
  options.reference = folder.path() / "bad.txt";
  EXPECT_NE(message(options).find("line 2"), std::string::npos);
}

TEST(GroundProgram, ExitCodeTellsAnEmptyOutbox) {
  const TemporaryFolder folder;
  fs::create_directories(folder.path() / "empty");
  const std::string log = (folder.path() / "log").string();
  const std::string command = std::string(ILP_GROUND_PROGRAM) + " " + (folder.path() / "empty").string() + " --out " +
                              (folder.path() / "out").string() + " 2> " + log;
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1);
  const auto text = host::read_file(log);
  EXPECT_NE(std::string(text.begin(), text.end()).find("the folder is empty"), std::string::npos);
}

}  // namespace
}  // namespace ilp::intake
