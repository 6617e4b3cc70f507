// The tools for the store of a flight: digests that do not depend on the backend, and roles that may do what their
// stages need and nothing else.
#include <map>
#include <random>
#include <vector>

#include "bsp/flight/stage_set.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/records/records.hpp"
#include "fsw/records/serial.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"
#include "sim/tools/store/keyframe_digest.hpp"
#include "sim/tools/store/role_grants.hpp"
#include "sim/tools/store/store_digest.hpp"
#include "tests/distributed/postgres_backend.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

using store_tool::digest_of;
using store_tool::TableDigest;
using test::environment;
using test::sql;

using Bytes = std::vector<std::uint8_t>;

/// The same content for every store.
void fill(Store& store) {
  std::mt19937 random(20050905);
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    const RecordInfo& info = record_info(static_cast<RecordType>(t));
    for (int n = 0; n < 3; ++n) {
      alignas(8) std::uint8_t record[limits::max_record_bytes] = {};
      Bytes serial(serial_bytes(info));
      for (std::uint8_t& octet : serial) octet = static_cast<std::uint8_t>(1 + random() % 100);
      ASSERT_OK(deserialize(info, serial, record));
      std::map<const FieldInfo*, std::uint32_t> sizes;
      for_each_blob(info, [&](const FieldInfo& field, std::size_t) {
        sizes[&field] = static_cast<std::uint32_t>(random() % 9000);
        std::memcpy(record + field.offset, &sizes[&field], sizeof(std::uint32_t));
      });
      ASSERT_OK(store.begin());
      ASSERT_OK(store.put(info, record)) << info.name;
      for (const auto& [field, size] : sizes) {
        Bytes bytes(size);
        for (std::uint8_t& octet : bytes) octet = static_cast<std::uint8_t>(random());
        if (size == 0) continue;
        ASSERT_OK(store.write_blob(info, field->name, id_of(record), 0, bytes));
      }
      ASSERT_OK(store.commit());
    }
  }
}

std::map<std::string, std::uint64_t> digests_of(Store& store) {
  std::map<std::string, std::uint64_t> digests;
  for (const TableDigest& table : digest_of(store)) {
    digests[table.table] = table.digest;
    EXPECT_EQ(table.damaged, 0) << table.table;
  }
  return digests;
}

template <typename Record>
void put_now(Store& store, const Record& record) {
  ASSERT_OK(store.begin());
  ASSERT_OK(put(store, record));
  ASSERT_OK(store.commit());
}

TEST(StoreDigest, IsTheSameInEveryBackendAndDiffersWithAnyBitOfAFieldOrABlob) {
  const test::TemporaryFolder folder;
  SqliteStore file;
  ASSERT_OK(file.open((folder / "flight.db").c_str()));
  test::PostgresBackend server;
  fill(file);
  fill(server.store);
  const auto digests = digests_of(file);
  EXPECT_EQ(digests, digests_of(server.store));
  EXPECT_GT(digests.size(), 15U);
  EXPECT_EQ(digests.count("event"), 0U) << "it depends on when a process ran";

  PoseRecord pose;
  ASSERT_OK(last(file, pose));
  pose.matches += 1;
  put_now(file, pose);
  FrameRecord frame;
  ASSERT_OK(last(file, frame));
  ASSERT_OK(file.begin());
  ASSERT_OK(write_blob<FrameRecord>(file, "image", frame.id, 5, Bytes(1, 0)));
  ASSERT_OK(file.commit());
  CaptureRecord capture;
  ASSERT_OK(last(file, capture));
  capture.issued_ns += 1;
  put_now(file, capture);
  for (const auto& [table, digest] : digests_of(file)) {
    const bool changed = table == "pose" || table == "frame";
    EXPECT_EQ(digest != digests.at(table), changed) << table;
  }
}

/// Two keyframes with their results.
void fill_keyframes(Store& store) {
  ASSERT_OK(store.begin());
  for (std::int64_t id = 1; id <= 2; ++id) {
    ASSERT_OK(put(store, KeyframeRecord{.id = id, .frame_id = 10 * id, .time_ns = 1000 * id}));
    ASSERT_OK(put(store, PoseRecord{.id = id, .matches = 50}));
    DepthRecord depth{.id = id};
    depth.values.bytes = 100;
    ASSERT_OK(put(store, depth));
    ASSERT_OK(write_blob<DepthRecord>(store, "values", id, 0, Bytes(100, 7)));
    const Bytes coded(40, static_cast<std::uint8_t>(id));
    ProductRecord product{.id = product_id(id, ProductKind::image), .bytes = 40, .crc32 = crc32(coded)};
    product.data.bytes = 40;
    ASSERT_OK(put(store, product));
    ASSERT_OK(write_blob<ProductRecord>(store, "data", product.id, 0, coded));
  }
  ASSERT_OK(store.commit());
}

TEST(KeyframeDigest, TheLineOfTheKeyframeThatDiffersDiffersAndThatIsAll) {
  const test::TemporaryFolder folder;
  SqliteStore file;
  ASSERT_OK(file.open((folder / "flight.db").c_str()));
  test::PostgresBackend server;
  fill_keyframes(file);
  fill_keyframes(server.store);
  const std::vector<std::string> lines = store_tool::keyframe_lines(file);
  EXPECT_EQ(lines, store_tool::keyframe_lines(server.store));
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[0].rfind("keyframe 1 frame 10 time_ns 1000 | ", 0), 0U) << lines[0];

  // Depth that the storage manager has released, and a product on its way.
  DepthRecord released{.id = 2};
  put_now(file, released);
  ProductRecord product;
  ASSERT_OK(get(file, product_id(2, ProductKind::image), product));
  product.layers_sent = 1;
  put_now(file, product);
  EXPECT_EQ(store_tool::keyframe_lines(file), lines);

  put_now(file, PoseRecord{.id = 2, .matches = 51});
  std::vector<std::string> changed = store_tool::keyframe_lines(file);
  EXPECT_EQ(changed[0], lines[0]);
  EXPECT_NE(changed[1], lines[1]);
  EXPECT_NE(changed[2], lines[2]) << "the line over all of them";
  put_now(file, PoseRecord{.id = 2, .matches = 50});

  ASSERT_OK(file.begin());
  ASSERT_OK(write_blob<ProductRecord>(file, "data", product.id, 3, Bytes(1, 0)));
  ASSERT_OK(file.commit());
  changed = store_tool::keyframe_lines(file);
  EXPECT_EQ(changed[0], lines[0]);
  EXPECT_NE(changed[1].find(" damaged"), std::string::npos) << changed[1];
}

TEST(StoreName, APasswordInItIsNoticed) {
  EXPECT_TRUE(holds_password("postgresql://ilp:secret@host/ilp"));
  EXPECT_TRUE(holds_password("postgresql://ilp@host/ilp?password=secret"));
  EXPECT_TRUE(holds_password("host=h password = 'se cret' user=ilp"));
  EXPECT_FALSE(holds_password("postgresql://ilp@host/ilp?passfile=/etc/ilp.pass&sslmode=verify-full"));
  EXPECT_FALSE(holds_password("rubbish"));
}

/// Whether the role gets the answer that its rights promise, for every table and every kind of access.
class Roles : public testing::Test {
 protected:
  Roles() { EXPECT_OK(owner_->open(environment("ILP_POSTGRES").c_str(), 0)); }
  ~Roles() override {
    role_->close();
    sql("DROP OWNED BY node; DROP ROLE node");
  }

  void expect_rights(StageMask stages) {
    sql(store_tool::role_sql("node", stages));
    sql(store_tool::role_sql("node", stages));
    ASSERT_OK(role_->open((environment("ILP_POSTGRES") + " user=node").c_str(), 0, {.create = false}))
        << role_->message();
    EXPECT_OK(role_->claim(stages));
    ASSERT_OK(change(*owner_, [&] { return ilp::put(*owner_, StripRecord{.id = 9}); }));
    EXPECT_GT(role_->usage().bytes, 0);
    const store_tool::TableRights rights = store_tool::rights_of(stages);
    for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
      expect_rights_to(record_info(static_cast<RecordType>(t)), rights);
    }
  }

  void expect_rights_to(const RecordInfo& info, const store_tool::TableRights& rights) {
    const RecordMask bit = mask_of(info.type);
    alignas(8) std::uint8_t record[limits::max_record_bytes] = {};
    const auto expect = [&](const Status& status, bool allowed, const char* what) {
      EXPECT_EQ(status.code, allowed ? StatusCode::ok : StatusCode::store_denied) << what << " " << info.name;
    };
    Status read = role_->get(info, 1, record);
    if (read.is(StatusCode::not_found)) read = {};
    expect(read, ((rights.reads | rights.puts | rights.erases) & bit) != 0, "read");
    record[0] = 1;
    for_each_blob(info, [&](const FieldInfo& field, std::size_t) { record[field.offset] = 10; });
    expect(change(*role_, [&] { return role_->put(info, record); }), (rights.puts & bit) != 0, "put");
    ASSERT_OK(change(*owner_, [&] { return owner_->put(info, record); }));
    expect(change(*role_, [&] { return role_->erase(info, 1); }), (rights.erases & bit) != 0, "erase");
  }

  template <typename Write>
  static Status change(PostgresStore& store, Write write) {
    Transaction transaction(store);
    ILP_TRY(transaction.begin());
    ILP_TRY(write());
    return transaction.commit();
  }

  test::PostgresBackend backend_;
  std::unique_ptr<PostgresStore> owner_ = std::make_unique<PostgresStore>();
  std::unique_ptr<PostgresStore> role_ = std::make_unique<PostgresStore>();
};

TEST_F(Roles, ThePrimaryMayDoWhatItsRowsSay) {
  expect_rights(primary_stages);
}

TEST_F(Roles, AProcessWithOneStageMayDoWhatItsRowSays) {
  expect_rights(stage_bit(ComponentId::dense_matcher));
}

TEST_F(Roles, TheStorageManagerMayEraseWhatItsRowSays) {
  expect_rights(stage_bit(ComponentId::storage_manager) | stage_bit(ComponentId::compressor));
}

TEST_F(Roles, ANameThatIsNoneIsRefused) {
  sql(store_tool::role_sql("node", 0));
  EXPECT_ANY_THROW(static_cast<void>(store_tool::role_sql("a\"; DROP TABLE frame; --", 0)));
  EXPECT_ANY_THROW(static_cast<void>(store_tool::role_sql("", 0)));
}

}  // namespace
}  // namespace ilp
