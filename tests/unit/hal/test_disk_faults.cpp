#include <cstring>

#include "tests/unit/hal/disk_faults.hpp"

namespace ilp {
namespace {
using test::Call;
using test::CallFault;
using test::DiskFaults;
using test::FailingCalls;
using test::Files;
using test::Trouble;

TEST_F(DiskFaults, AfterAnyFaultOfWritingTheDatabaseOpensWithAllThatWasCommitted) {
  const Trouble troubles[] = {
      {"full for ever", {.calls = Call::write | Call::create, .reason = ENOSPC}},
      {"full within a write", {.calls = Call::write | Call::create, .reason = ENOSPC, .in_part = true}},
      {"full for a while", {.calls = Call::write | Call::create, .count = 4, .reason = ENOSPC}},
      {"one write", {.calls = static_cast<unsigned>(Call::write), .count = 1, .in_part = true}},
      {"writes", {.calls = test::changes, .count = 6, .in_part = true}},
      {"synchronisation", {.calls = static_cast<unsigned>(Call::synchronise), .count = 3}},
      {"interrupted synchronisation", {.calls = static_cast<unsigned>(Call::synchronise), .count = 1, .reason = EINTR}},
      {"cutting", {.calls = Call::synchronise | Call::truncate, .count = 4}},
  };
  const Files before = dead(3);
  for (const Trouble& trouble : troubles) {
    bool failed = true;
    int n = 1;
    for (; failed && n < test::most_calls; n += 1 + n / 12) {
      const std::string where = std::string(trouble.name) + ", call " + std::to_string(n);
      restore(before);
      std::set<std::int64_t> committed{1, 2, 3};
      Files killed;
      {
        SqliteStore store;
        ASSERT_OK(store.open(path_.c_str()));
        ASSERT_OK(put_frame(store, 4));
        committed.insert(4);
        const FailingCalls disk(path_, test::from_call(trouble.fault, n));
        // Commits of several lengths, each of which may fail.
        for (std::int64_t id = 5; id <= 10; ++id) {
          if (put_frame(store, id).ok()) committed.insert(id);
        }
        killed = files();
        store.close();
        failed = disk.failed();
      }
      expect_sound(committed, where + ", ended");
      restore(killed);
      expect_sound(committed, where + ", killed");
      if (HasFatalFailure()) return;
    }
    EXPECT_GT(n, 3) << trouble.name << " never happened";
    EXPECT_FALSE(failed) << trouble.name;
  }
}

TEST_F(DiskFaults, AReadThatFailsCondemnsNothingAndIsTriedAgain) {
  const Files before = dead(6);
  const std::set<std::int64_t> committed{1, 2, 3, 4, 5, 6};
  for (const int reason : {EIO, ENXIO, ERANGE, EINTR}) {
    // SQLite repeats a call that was interrupted for as long as that happens.
    for (const int count : {1, reason == EINTR ? 20 : 1 << 30}) {
      bool failed = true;
      for (int n = 1; failed; n += reason == EIO ? 1 + n / 12 : 7 + n / 3) {
        ASSERT_LT(n, test::most_calls);
        const std::string where =
            std::string(std::strerror(reason)) + " " + std::to_string(count) + " times, call " + std::to_string(n);
        restore(before);
        SqliteStore store;
        {
          const FailingCalls disk(path_, {.calls = static_cast<unsigned>(Call::read),
                                          .first = n,
                                          .count = count,
                                          .reason = reason,
                                          .in_part = n % 2 == 0});
          Status status = store.open(path_.c_str());
          if (status.ok()) status = store.check();
          for (const std::int64_t id : committed) {
            FrameRecord frame;
            if (status.ok()) status = get(store, id, frame);
          }
          failed = disk.failed();
          if (count == 1 || !failed) {
            ASSERT_TRUE(status.ok()) << where << ": " << status_name(status.code);
          } else {
            ASSERT_TRUE(status.ok() || status.is(StatusCode::store_error) || status.is(StatusCode::io_error))
                << where << ": " << status_name(status.code) << " " << status.a << " " << status.b;
          }
          ASSERT_FALSE(store.damaged()) << where;
        }
        store.close();
        expect_sound(committed, where);
        if (HasFatalFailure()) return;
      }
    }
  }
}

}  // namespace
}  // namespace ilp
