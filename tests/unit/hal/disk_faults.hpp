// A database whose disk fails below SQLite: each call of the system in turn.
#pragma once

#include <gtest/gtest.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "hal/store/sqlite/sqlite_store.hpp"
#include "tests/support/failing_calls.hpp"
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::test {

using Bytes = std::vector<std::uint8_t>;
/// Contents by name.
using Files = std::map<std::string, std::string>;

constexpr int most_calls = 2000;

class DiskFaults : public testing::Test {
 protected:
  [[nodiscard]] Files files() const {
    Files found;
    for (const std::filesystem::directory_entry& entry : std::filesystem::directory_iterator(folder_.path())) {
      const std::string name = entry.path().filename().string();
      if (name.ends_with("-shm") || name.ends_with("-guard") || name.ends_with("-reserve")) continue;
      std::ifstream in(entry.path(), std::ios::binary);
      found[name] = {std::istreambuf_iterator<char>(in), {}};
    }
    return found;
  }
  void restore(const Files& wanted) const {
    for (const std::filesystem::directory_entry& entry : std::filesystem::directory_iterator(folder_.path()))
      std::filesystem::remove_all(entry.path());
    for (const auto& [name, content] : wanted) std::ofstream(folder_ / name, std::ios::binary) << content;
  }
  [[nodiscard]] static std::set<std::string> names(const Files& of) {
    std::set<std::string> result;
    for (const auto& [name, content] : of) result.insert(name);
    return result;
  }

  static std::uint32_t size_of(std::int64_t id) { return static_cast<std::uint32_t>(3000 + 9000 * (id % 3)); }
  static Status put_frame(Store& store, std::int64_t id) {
    Transaction transaction(store);
    ILP_TRY(transaction.begin());
    FrameRecord frame{.id = id};
    frame.image.bytes = size_of(id);
    ILP_TRY(put(store, frame));
    ILP_TRY(write_blob<FrameRecord>(store, "image", id, 0, Bytes(size_of(id), static_cast<std::uint8_t>(id))));
    return transaction.commit();
  }
  static bool has_frame(Store& store, std::int64_t id) {
    Bytes image(size_of(id));
    return read_blob<FrameRecord>(store, "image", id, 0, image).ok() &&
           image == Bytes(size_of(id), static_cast<std::uint8_t>(id));
  }
  /// A database with frames 1 to `frames` whose process died.
  Files dead(std::int64_t frames) {
    SqliteStore store;
    EXPECT_OK(store.open(path_.c_str()));
    for (std::int64_t id = 1; id <= frames; ++id) EXPECT_OK(put_frame(store, id));
    return files();
  }
  /// A valid database, of which a flight has committed these frames.
  void expect_valid(const std::set<std::int64_t>& committed, const std::string& where) {
    SqliteStore store;
    const Status opened = store.open(path_.c_str());
    ASSERT_TRUE(opened.ok()) << where << ": " << status_name(opened.code) << " " << opened.a << " " << opened.b;
    for (const std::int64_t id : committed) EXPECT_TRUE(has_frame(store, id)) << where << " frame " << id;
    EXPECT_OK(store.check()) << where;
  }

  TemporaryFolder folder_;
  std::string path_ = folder_ / "flight.db";
};

struct Trouble {
  const char* name;
  CallFault fault;
};

/// The same fault from its n-th call on.
inline CallFault from_call(CallFault fault, int n) {
  fault.first = n;
  return fault;
}

}  // namespace ilp::test
