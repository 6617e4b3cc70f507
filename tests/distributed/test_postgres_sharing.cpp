// What processes that share a store on a server see of each other: commits, changes, claims, and the end of others.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <thread>
#include <vector>

#include "fsw/records/records.hpp"
#include "tests/distributed/postgres_backend.hpp"

namespace ilp {
namespace {

using test::environment;
using test::sql;

using Bytes = std::vector<std::uint8_t>;
constexpr RecordMask all_tables = ~RecordMask{0};
constexpr int patience = 200;  ///< attempts of 100 ms

template <typename Record>
Record of_id(std::int64_t id) {
  Record record;
  record.id = id;
  return record;
}

template <typename Record>
Status put_now(Store& store, const Record& record) {
  Transaction transaction(store);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store, record));
  return transaction.commit();
}

class PostgresSharing : public testing::Test {
 protected:
  PostgresSharing() {
    test::empty_database();
    for (PostgresStore* store : {a_.get(), b_.get()}) {
      EXPECT_OK(store->open(environment("ILP_POSTGRES").c_str(), all_tables)) << store->message();
    }
  }

  RecordMask updates_of(PostgresStore& store) {
    RecordMask changed = 0;
    for (int i = 0; i < patience && changed == 0; ++i) {
      store.wait(100);
      EXPECT_OK(store.poll(changed));
    }
    return changed;
  }
  static void use_server(const char* what) {
    ASSERT_EQ(std::system((environment("ILP_POSTGRES_SERVER") + " " + what).c_str()), 0);
  }
  static Status reconnect(PostgresStore& store) {
    Status status = store.reconnect();
    for (int i = 0; i < patience && !status.ok(); ++i) {
      usleep(100'000);
      status = store.reconnect();
    }
    return status;
  }

  std::unique_ptr<PostgresStore> a_ = std::make_unique<PostgresStore>();
  std::unique_ptr<PostgresStore> b_ = std::make_unique<PostgresStore>();
};

TEST_F(PostgresSharing, ARollbackHidesNoNotification) {
  static_assert(postgres_poll_ms > 600, "within this time only a notification tells of the change");
  RecordMask changed = 0;
  b_->wait(1);
  ASSERT_OK(b_->begin());
  ASSERT_OK(put(*b_, of_id<PoseRecord>(1)));
  PoseRecord pose;
  ASSERT_OK(get(*b_, 1, pose));
  b_->rollback();
  ASSERT_OK(put_now(*a_, of_id<FrameRecord>(1)));
  b_->wait(500);
  ASSERT_OK(b_->poll(changed));
  EXPECT_EQ(changed, mask_of(RecordType::frame));
}

TEST_F(PostgresSharing, ACommitIsReportedToTheOthersWithItsTablesAndToItsOwnProcessOnce) {
  ASSERT_OK(put_now(*a_, of_id<FrameRecord>(1)));
  EXPECT_EQ(updates_of(*b_), mask_of(RecordType::frame));
  FrameRecord frame;
  EXPECT_OK(get(*b_, 1, frame));
  RecordMask changed = 0;
  ASSERT_OK(a_->poll(changed));
  EXPECT_EQ(changed, mask_of(RecordType::frame));
  a_->wait(100);
  ASSERT_OK(a_->poll(changed));
  EXPECT_EQ(changed, 0U) << "its own notification";
  ASSERT_OK(b_->begin());
  ASSERT_OK(put(*b_, of_id<PoseRecord>(1)));
  b_->rollback();
  a_->wait(100);
  ASSERT_OK(a_->poll(changed));
  EXPECT_EQ(changed, 0U) << "of a transaction that was rolled back";
}

TEST_F(PostgresSharing, WithoutNotificationsChangesAreFoundAllTheSame) {
  ASSERT_OK(a_->open(environment("ILP_POSTGRES").c_str(), all_tables, {.notify = false}));
  ASSERT_OK(put_now(*a_, of_id<PoseRecord>(1)));
  EXPECT_EQ(updates_of(*b_), mask_of(RecordType::pose));
  ASSERT_OK(put_now(*a_, of_id<PoseRecord>(2)));
  ASSERT_OK(put_now(*a_, of_id<StripRecord>(2)));
  EXPECT_EQ(updates_of(*b_), mask_of(RecordType::pose, RecordType::strip));
}

TEST_F(PostgresSharing, NotificationsOfStrangersDoNoHarm) {
  for (const char* text : {"", "rubbish", "9223372036854775807 -1", "-1 1", "5", "99999999999999999999 7"}) {
    sql(std::string("NOTIFY ilp, '") + text + "'");
    RecordMask changed = 0;
    b_->wait(100);
    EXPECT_OK(b_->poll(changed));
  }
  ASSERT_OK(put_now(*a_, of_id<FrameRecord>(1)));
  EXPECT_EQ(updates_of(*b_) & mask_of(RecordType::frame), mask_of(RecordType::frame));
}

// A role without any right announces the next commit before there is one. What is read then is as it was before.
TEST_F(PostgresSharing, ACommitThatAStrangerAnnouncedBeforeItWasIsSeenAllTheSame) {
  sql("DROP ROLE IF EXISTS stranger; CREATE ROLE stranger LOGIN");
  FrameRecord frame;
  for (std::int64_t id = 1; id <= 5; ++id) {
    const std::int64_t next_commit = std::stoll(sql("SELECT commits + 1 FROM ilp_store"));
    sql("SET ROLE stranger; NOTIFY ilp, '" + std::to_string(next_commit) + " " +
        std::to_string(mask_of(RecordType::frame)) + "'");
    RecordMask changed = 0;
    b_->wait(200);
    ASSERT_OK(b_->poll(changed));
    EXPECT_STATUS(get(*b_, id, frame), not_found);
    ASSERT_OK(put_now(*a_, of_id<FrameRecord>(id)));
    EXPECT_EQ(updates_of(*b_) & mask_of(RecordType::frame), mask_of(RecordType::frame));
    EXPECT_OK(get(*b_, id, frame)) << id;
  }
  sql("DROP ROLE stranger");
}

// Whoever owns the tables may lock them.
TEST_F(PostgresSharing, ATableThatAnotherClientLocksIsWaitedForAndThenGivenUpWithItsName) {
  ASSERT_OK(put_now(*a_, of_id<FrameRecord>(1)));
  const auto lock_for = [](const char* seconds) {
    return std::thread([seconds] {
      const std::string locking = "echo 'BEGIN; LOCK TABLE frame IN ACCESS EXCLUSIVE MODE; SELECT pg_sleep(";
      // Its session may be ended.
      const std::string end = "); COMMIT' | " + environment("ILP_POSTGRES_SERVER") + " sql > /dev/null 2>&1 || true";
      EXPECT_EQ(std::system((locking + seconds + end).c_str()), 0);
    });
  };
  const auto await_lock = [] {
    for (int i = 0; i < patience; ++i) {
      if (sql("SELECT count(*) FROM pg_locks WHERE mode='AccessExclusiveLock' AND granted AND "
              "relation='frame'::regclass") != "0") {
        return;
      }
      usleep(100'000);
    }
    FAIL() << "the table is not locked";
  };
  FrameRecord frame;
  PoseRecord pose;
  std::thread stranger = lock_for("1");
  await_lock();
  EXPECT_STATUS(get(*b_, 7, frame), not_found) << "it waits, and then has the answer";
  stranger.join();
  stranger = lock_for("60");
  await_lock();
  const Status reading = get(*b_, 8, frame);
  EXPECT_STATUS(reading, store_error);
  EXPECT_EQ(reading.b, static_cast<std::int64_t>(RecordType::frame));
  EXPECT_TRUE(b_->connected());
  EXPECT_STATUS(get(*b_, 1, pose), not_found) << "other tables are as before";
  EXPECT_OK(put_now(*b_, of_id<PoseRecord>(1)));
  sql("SELECT pg_terminate_backend(pid) FROM pg_locks WHERE mode='AccessExclusiveLock' AND relation='frame'::regclass");
  stranger.join();
  EXPECT_STATUS(get(*b_, 8, frame), not_found);
  EXPECT_OK(put_now(*b_, of_id<FrameRecord>(8)));
  EXPECT_OK(get(*a_, 8, frame));
}

TEST_F(PostgresSharing, ATransactionReadsTheNewestStateWithoutAPoll) {
  CommandRecord command;
  EXPECT_STATUS(last(*b_, command), not_found);
  EXPECT_STATUS(next(*b_, 0, command), not_found);
  ASSERT_OK(put_now(*a_, of_id<CommandRecord>(1)));
  ASSERT_OK(b_->begin());
  ASSERT_OK(last(*b_, command));
  EXPECT_EQ(command.id, 1);
  EXPECT_OK(next(*b_, 0, command));
  b_->rollback();
}

/// Both add to one record. An addition that is lost would be a read that was not true.
TEST_F(PostgresSharing, NoChangeIsLostThatDependsOnWhatWasRead) {
  constexpr int each = 80;
  ASSERT_OK(put_now(*a_, of_id<StripRecord>(1)));
  const auto add_to = [](PostgresStore& store) {
    for (int done = 0; done < each; ++done) {
      StripRecord strip;
      Transaction transaction(store);
      ASSERT_OK(transaction.begin());
      ASSERT_OK(get(store, 1, strip));
      ++strip.first_keyframe_id;
      ASSERT_OK(put(store, strip));
      ASSERT_OK(transaction.commit());
    }
  };
  std::thread other([&] { add_to(*b_); });
  add_to(*a_);
  other.join();
  StripRecord strip;
  ASSERT_OK(a_->begin());
  ASSERT_OK(last(*a_, strip));
  a_->rollback();
  EXPECT_EQ(strip.first_keyframe_id, of_id<StripRecord>(1).first_keyframe_id + 2 * each);
}

TEST_F(PostgresSharing, NoReadIsOlderThanAnEarlierOneOfAnotherTable) {
  StripRecord strip;
  EXPECT_STATUS(get(*b_, 1, strip), not_found);
  EXPECT_STATUS(last(*b_, strip), not_found);
  ASSERT_OK(a_->begin());
  ASSERT_OK(put(*a_, of_id<StripRecord>(1)));
  ASSERT_OK(put(*a_, of_id<KeyframeRecord>(1)));
  ASSERT_OK(a_->commit());
  KeyframeRecord keyframe;
  ASSERT_OK(get(*b_, 1, keyframe));
  EXPECT_OK(get(*b_, 1, strip)) << "the keyframe is there and its strip is not";
  EXPECT_OK(last(*b_, strip));
}

TEST_F(PostgresSharing, AProcessThatNeverPollsFindsWhatHasCome) {
  FrameRecord frame;
  EXPECT_STATUS(get(*b_, 1, frame), not_found);
  ASSERT_OK(put_now(*a_, of_id<FrameRecord>(1)));
  Status status = StatusCode::not_found;
  for (int i = 0; i < patience && status.is(StatusCode::not_found); ++i) {
    status = get(*b_, 1, frame);
    usleep(100'000);
  }
  EXPECT_OK(status);
}

TEST_F(PostgresSharing, OwnWritesAndTheirUndoingAreSeenByEveryKindOfRead) {
  for (const std::int64_t id : {2, 4, 6}) ASSERT_OK(put_now(*a_, of_id<FrameRecord>(id)));
  const auto ids = [&] {
    std::vector<std::int64_t> found;
    FrameRecord frame;
    for (std::int64_t after = 0; next(*a_, after, frame).ok(); after = frame.id) found.push_back(frame.id);
    if (last(*a_, frame).ok()) found.push_back(frame.id);
    for (std::int64_t id = 1; id <= 7; ++id) {
      if (get(*a_, id, frame).ok()) found.push_back(frame.id);
    }
    return found;
  };
  using Ids = std::vector<std::int64_t>;
  const Ids before = {2, 4, 6, 6, 2, 4, 6};
  EXPECT_EQ(ids(), before);
  ASSERT_OK(a_->begin());
  EXPECT_EQ(ids(), before);
  ASSERT_OK(put(*a_, of_id<FrameRecord>(7)));
  EXPECT_EQ(ids(), (Ids{2, 4, 6, 7, 7, 2, 4, 6, 7}));
  ASSERT_OK(put(*a_, of_id<FrameRecord>(3)));
  ASSERT_OK(a_->erase(record_info<FrameRecord>(), 7));
  ASSERT_OK(a_->erase(record_info<FrameRecord>(), 4));
  EXPECT_EQ(ids(), (Ids{2, 3, 6, 6, 2, 3, 6}));
  a_->rollback();
  EXPECT_EQ(ids(), before);
}

TEST_F(PostgresSharing, ATransactionOfThousandsOfWritesIsCarriedOutWhole) {
  constexpr std::int64_t records = 1500;
  ASSERT_OK(a_->begin());
  for (std::int64_t id = 1; id <= records; ++id) {
    DepthRecord depth = of_id<DepthRecord>(id);
    depth.cells.bytes = 10;
    ASSERT_OK(put(*a_, depth));
    ASSERT_OK(write_blob<DepthRecord>(*a_, "cells", id, 0, Bytes(10, 1)));
  }
  for (std::int64_t id = 1; id <= records; id += 2) ASSERT_OK(a_->erase(record_info<DepthRecord>(), id));
  ASSERT_OK(a_->commit());
  std::int64_t found = 0;
  ASSERT_OK(b_->count(record_info<DepthRecord>(), found));
  EXPECT_EQ(found, records / 2);
  Bytes mask(10);
  ASSERT_OK(read_blob<DepthRecord>(*b_, "cells", records, 0, mask));
  EXPECT_EQ(mask, Bytes(10, 1));
}

TEST_F(PostgresSharing, NumbersThatTwoProcessesGiveInTransactionsAreNeverTheSame) {
  constexpr int each = 60;
  const auto number_on = [](PostgresStore& store) {
    for (int i = 0; i < each; ++i) {
      CommandRecord newest;
      Transaction transaction(store);
      ASSERT_OK(transaction.begin());
      const Status found = last(store, newest);
      ASSERT_TRUE(found.ok() || found.is(StatusCode::not_found));
      ASSERT_OK(put(store, of_id<CommandRecord>(found.ok() ? newest.id + 1 : 1)));
      ASSERT_OK(transaction.commit());
    }
  };
  std::thread other([&] { number_on(*b_); });
  number_on(*a_);
  other.join();
  std::int64_t records = 0;
  ASSERT_OK(a_->count(record_info<CommandRecord>(), records));
  EXPECT_EQ(records, 2 * each);
}

TEST_F(PostgresSharing, PiecesOfABlobAreOfOneStateUntilItsChangeIsKnown) {
  FrameRecord frame = of_id<FrameRecord>(1);
  frame.image.bytes = 20'000;
  const auto fill = [&](std::uint8_t value) {
    ASSERT_OK(a_->begin());
    ASSERT_OK(put(*a_, frame));
    ASSERT_OK(write_blob<FrameRecord>(*a_, "image", 1, 0, Bytes(20'000, value)));
    ASSERT_OK(a_->commit());
  };
  fill(1);
  updates_of(*b_);
  Bytes patch(5000);
  for (const std::size_t offset : {0U, 5000U}) {
    ASSERT_OK(read_blob<FrameRecord>(*b_, "image", 1, offset, patch));
    EXPECT_EQ(patch, Bytes(5000, 1));
  }
  fill(2);
  updates_of(*b_);
  for (const std::size_t offset : {10'000U, 15'000U, 0U}) {
    ASSERT_OK(read_blob<FrameRecord>(*b_, "image", 1, offset, patch));
    EXPECT_EQ(patch, Bytes(5000, 2));
  }
}

TEST_F(PostgresSharing, AStageIsClaimedByOneProcess) {
  ASSERT_OK(a_->claim(0b0110));
  ASSERT_OK(a_->claim(0b0110)) << "again by the same process";
  const Status refused = b_->claim(0b1100);
  EXPECT_STATUS(refused, stage_claimed);
  EXPECT_EQ(refused.a, 3) << "the number of the stage, from 1";
  ASSERT_OK(a_->claim(0b1000)) << "the refused claim has kept a part";
  a_->release();
  EXPECT_OK(b_->claim(0b1100));
  EXPECT_STATUS(a_->claim(0b0100), stage_claimed);
  b_->close();
  Status status = a_->claim(0b0100);
  for (int i = 0; i < patience && !status.ok(); ++i) {
    usleep(100'000);
    status = a_->claim(0b0100);
  }
  EXPECT_OK(status) << "the process that had it is gone";
}

TEST_F(PostgresSharing, ARestartOfTheServerIsALostConnectionAndTheClaimIsTakenAgain) {
  ASSERT_OK(put_now(*a_, of_id<FrameRecord>(1)));
  ASSERT_OK(a_->claim(0b11));
  use_server("restart");
  FrameRecord frame;
  ASSERT_OK(a_->begin());
  EXPECT_STATUS(put_now(*b_, of_id<FrameRecord>(2)), store_lost);
  EXPECT_STATUS(get(*a_, 9, frame), store_lost);
  EXPECT_FALSE(a_->connected());
  EXPECT_STATUS(put(*a_, of_id<FrameRecord>(3)), store_lost);
  EXPECT_STATUS(a_->commit(), store_lost);
  EXPECT_STATUS(a_->begin(), store_lost);
  RecordMask changed = 0;
  EXPECT_STATUS(a_->poll(changed), store_lost);
  ASSERT_OK(reconnect(*a_));
  ASSERT_OK(a_->poll(changed));
  EXPECT_EQ(changed, all_tables);
  EXPECT_OK(get(*a_, 1, frame));
  EXPECT_STATUS(get(*a_, 2, frame), not_found);
  ASSERT_OK(reconnect(*b_));
  EXPECT_STATUS(b_->claim(0b10), stage_claimed);
}

TEST_F(PostgresSharing, AServerThatIsKilledInATransactionHasNothingOfIt) {
  ASSERT_OK(put_now(*a_, of_id<FrameRecord>(1)));
  ASSERT_OK(a_->begin());
  ASSERT_OK(put(*a_, of_id<FrameRecord>(2)));
  FrameRecord frame;
  ASSERT_OK(get(*a_, 2, frame));
  use_server("kill");
  static_cast<void>(put(*a_, of_id<FrameRecord>(3)));
  EXPECT_STATUS(a_->commit(), store_lost);
  use_server("start");
  ASSERT_OK(reconnect(*a_));
  std::int64_t records = 0;
  ASSERT_OK(a_->count(record_info<FrameRecord>(), records));
  EXPECT_EQ(records, 1);
  EXPECT_OK(put_now(*a_, of_id<FrameRecord>(2)));
}

TEST_F(PostgresSharing, ACommitThatWasReportedOutlastsTheServer) {
  for (std::int64_t id = 1; id <= 4; ++id) {
    ASSERT_OK(put_now(*a_, of_id<FrameRecord>(id)));
    use_server("kill");
    use_server("start");
    ASSERT_OK(reconnect(*a_));
    FrameRecord frame;
    EXPECT_OK(get(*a_, id, frame));
  }
}

// A process whose commits wait for no disk makes something; another one is to tell the ground of it.
TEST_F(PostgresSharing, WhatWasFlushedOutlastsTheServerAlsoFromWithinATransaction) {
  b_->close();
  ASSERT_OK(b_->open(environment("ILP_POSTGRES").c_str(), all_tables, {.synchronous = false}));
  FrameRecord frame;
  for (std::int64_t id = 1; id <= 6; ++id) {
    ASSERT_OK(put_now(*b_, of_id<FrameRecord>(id)));
    ASSERT_OK(a_->begin());
    ASSERT_OK(put(*a_, of_id<CaptureRecord>(id)));
    ASSERT_OK(get(*a_, id, frame));
    if (id % 2 == 0) {
      ASSERT_OK(a_->flush());
      a_->rollback();
    } else {
      a_->rollback();
      ASSERT_OK(a_->flush());
    }
    use_server("kill");
    use_server("start");
    ASSERT_OK(reconnect(*a_));
    ASSERT_OK(reconnect(*b_));
    EXPECT_OK(get(*a_, id, frame)) << "it was told, and is gone";
  }
}

// The process is stopped in a transaction. The server ends the transaction, and the others go on.
TEST_F(PostgresSharing, AProcessThatStandsStillInATransactionDoesNotHoldTheOthersForEver) {
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    auto store = std::make_unique<PostgresStore>();
    FrameRecord frame;
    bool began = store->open(environment("ILP_POSTGRES").c_str(), all_tables).ok() && store->begin().ok();
    began = began && put(*store, of_id<FrameRecord>(1)).ok() && get(*store, 2, frame).is(StatusCode::not_found);
    if (write(ready[1], began ? "y" : "n", 1) != 1) _exit(2);
    raise(SIGSTOP);
    _exit(store->commit().is(StatusCode::store_lost) ? 0 : 1);
  }
  char began = 'n';
  ASSERT_EQ(read(ready[0], &began, 1), 1);
  ASSERT_EQ(began, 'y');
  EXPECT_OK(put_now(*a_, of_id<FrameRecord>(2))) << "it waits until the server has ended the other one's transaction";
  kill(child, SIGCONT);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0) << "the commit of the process that stood still";
  FrameRecord frame;
  EXPECT_STATUS(get(*a_, 1, frame), not_found);
}

}  // namespace
}  // namespace ilp
