#include <sys/wait.h>
#include <unistd.h>

#include <cstring>

#include "hal/store/sqlite/page_checksum.hpp"
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
    for (; failed && n < test::most_calls; n += 1 + n / 8) {
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
      expect_valid(committed, where + ", ended");
      restore(killed);
      expect_valid(committed, where + ", killed");
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
        expect_valid(committed, where);
        if (HasFatalFailure()) return;
      }
    }
  }
}

TEST_F(DiskFaults, AFileThatSeemsToEndIsAskedAgain) {
  const Files before = dead(6);
  bool failed = true;
  for (int n = 1; failed; n += 1 + n / 8) {
    ASSERT_LT(n, test::most_calls);
    restore(before);
    const FailingCalls disk(path_,
                            {.calls = static_cast<unsigned>(Call::read), .first = n, .count = 1, .nothing = true});
    expect_valid({1, 2, 3, 4, 5, 6}, "call " + std::to_string(n));
    failed = disk.failed();
    if (HasFailure()) return;
  }
}

TEST_F(DiskFaults, WhatCommitsLeaveThatFailedInARowIsNotTakenForCommits) {
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  ASSERT_OK(put_frame(store, 1));
  {
    // Their frames are whole, each time fewer.
    const FailingCalls disk(path_, {.calls = static_cast<unsigned>(Call::synchronise)});
    for (const std::uint32_t bytes : {40'000U, 30'000U, 20'000U}) {
      ASSERT_OK(store.begin());
      FrameRecord frame{.id = 2};
      frame.image.bytes = bytes;
      ASSERT_OK(put(store, frame));
      EXPECT_STATUS(store.commit(), store_error);
    }
  }
  const Files after_faults = files();
  ASSERT_OK(put_frame(store, 3));
  const Files killed = files();
  store.close();
  restore(killed);
  expect_valid({1, 3}, "killed");
  // The same by a new process, which does not know of it.
  restore(after_faults);
  ASSERT_OK(store.open(path_.c_str()));
  ASSERT_OK(put_frame(store, 3));
  const Files killed_again = files();
  store.close();
  restore(killed_again);
  expect_valid({1, 3}, "killed again");
}

TEST_F(DiskFaults, APageThatIsTornWhileTheLogIsCopiedIsStillInTheLog) {
  const Files before = dead(6);
  std::set<std::string> torn;
  bool failed = true;
  for (int n = 2; failed; ++n) {
    ASSERT_LT(n, test::most_calls);
    restore(before);
    {
      SqliteStore store;
      ASSERT_OK(store.open(path_.c_str()));
      const FailingCalls disk(path_, {.calls = static_cast<unsigned>(Call::write), .first = n, .in_part = true});
      store.close();
      failed = disk.failed();
    }
    // Cut off in the middle of a page.
    torn.insert(files()["flight.db"].substr(0, page_bytes));
    expect_valid({1, 2, 3, 4, 5, 6}, "write " + std::to_string(n));
    if (HasFailure()) return;
  }
  EXPECT_GE(torn.size(), 2U) << "the first page was never torn";
}

TEST_F(DiskFaults, ALogThatIsBegunAnewInPartIsNoDamage) {
  std::int64_t id = 0;
  bool begun = false;
  for (int n = 2; n < 6; ++n) {
    restore({});
    SqliteStore store;
    ASSERT_OK(store.open(path_.c_str()));
    std::set<std::int64_t> committed;
    const auto log_bytes = [this] { return files()["flight.db-wal"].size(); };
    for (id = 1; log_bytes() < 250 * frame_bytes; ++id) {
      ASSERT_OK(put_frame(store, id));
      committed.insert(id);
    }
    const std::string header = files()["flight.db-wal"].substr(0, log_header_bytes);
    Files killed;
    {
      const FailingCalls disk(path_, {.calls = static_cast<unsigned>(Call::write), .first = n, .in_part = true});
      EXPECT_FALSE(put_frame(store, id).ok());
      killed = files();
    }
    const std::string torn = killed["flight.db-wal"].substr(0, log_header_bytes);
    begun = begun || (torn != header && torn.substr(16) == header.substr(16));
    store.close();
    restore(killed);
    expect_valid(committed, "call " + std::to_string(n));
  }
  EXPECT_TRUE(begun) << "no header was written in part";
}

TEST_F(DiskFaults, ACommitWhoseProcessIsKilledInItIsWrittenOverByTheOthers) {
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  ASSERT_OK(store.synchronise(Synchronise::later));
  ASSERT_OK(put_frame(store, 1));
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    SqliteStore other;
    if (!other.open(path_.c_str()).ok()) _exit(1);
    // All of it is in the log, and nobody has been told.
    const FailingCalls disk(path_, {.calls = static_cast<unsigned>(Call::synchronise), .ends = true});
    static_cast<void>(put_frame(other, 2));
    _exit(1);
  }
  int ended = 1;
  waitpid(child, &ended, 0);
  ASSERT_EQ(ended, 0);
  ASSERT_OK(store.flush());
  ASSERT_FALSE(has_frame(store, 2));
  ASSERT_OK(put_frame(store, 3));
  const Files killed = files();
  store.close();
  restore(killed);
  expect_valid({1, 3}, "killed");
}

TEST_F(DiskFaults, WhatTheDiskRefusedToSynchroniseIsNotTakenForWritten) {
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  ASSERT_OK(put_frame(store, 1));
  const std::size_t on_disk = files()["flight.db-wal"].size();
  {
    const FailingCalls disk(path_, {.calls = static_cast<unsigned>(Call::synchronise), .count = 1});
    EXPECT_STATUS(put_frame(store, 2), store_error);
  }
  {
    // The log cannot be copied, but it is synchronised.
    const FailingCalls disk(path_, {.calls = static_cast<unsigned>(Call::write), .reason = ENOSPC});
    store.close();
  }
  Files after_cut = files();
  std::string& log = after_cut["flight.db-wal"];
  ASSERT_GT(log.size(), on_disk + frame_bytes);
  std::fill(log.begin() + static_cast<std::ptrdiff_t>(on_disk), log.end(), '\0');
  restore(after_cut);
  expect_valid({1}, "power cut");
}

}  // namespace
}  // namespace ilp
