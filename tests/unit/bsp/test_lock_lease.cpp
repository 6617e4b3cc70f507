// The lease of the lock of the writers: who keeps it for longer is ended, or named.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "bsp/flight/lock_lease.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

constexpr int lease_s = 1;

bool report(int pipe) {
  return write(pipe, "!", 1) == 1;
}

/// A child process that says when it is ready.
class Child {
 public:
  template <typename Work>
  explicit Child(Work work) {
    int ready[2];
    EXPECT_EQ(pipe(ready), 0);
    process_ = fork();
    if (process_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      work(ready[1]);
      _exit(9);
    }
    char word = 0;
    close(ready[1]);
    EXPECT_EQ(read(ready[0], &word, 1), 1);
    close(ready[0]);
  }
  ~Child() {
    if (process_ > 0) kill(process_, SIGKILL);
    static_cast<void>(end());
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  [[nodiscard]] int process() const { return process_; }
  /// Waits for its end; the status as waitpid() gives it.
  int end() {
    int how = 0;
    if (process_ > 0) waitpid(process_, &how, 0);
    process_ = -1;
    return how;
  }

 private:
  int process_ = -1;
};

class LockLeaseTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_OK(store_.open(path_.c_str()));
    sqlite::wait_for_writers(store_.session(), 1);
  }
  /// The news of the watch until there are some, or the lock is free.
  Status updates() {
    Status updates;
    while (updates.ok() && store_.begin().is(StatusCode::store_locked)) {
      usleep(10'000);
      updates = watch_.look(store_, lease_s);
    }
    store_.rollback();
    return updates;
  }

  test::TemporaryFolder folder_;
  std::string path_ = folder_ / "flight.db";
  SqliteStore store_;
  LockWatch watch_;
};

TEST(LeasedStore, AProcessWhoseTransactionDoesNotEndIsEndedByItsAlarm) {
  Child hung([](int ready) {
    std::vector<std::byte> region(std::size_t{1} << 20U);
    RamStore ram(region);
    LeasedStore store(ram, lease_s);
    // Transactions that end in time cost nothing.
    for (int i = 0; i < 3; ++i) {
      if (!store.begin().ok() || (i == 0 ? !store.commit().ok() : (store.rollback(), false))) _exit(1);
    }
    usleep(1'500'000);
    if (!store.begin().ok() || !report(ready)) _exit(2);
    for (;;) pause();
  });
  const int how = hung.end();
  EXPECT_TRUE(WIFEXITED(how) && WEXITSTATUS(how) == 3) << how;
}

TEST_F(LockLeaseTest, AStoppedProcessOfTheFlightIsEnded) {
  Child node([&](int ready) {
    SqliteStore store;
    if (!store.open(path_.c_str()).ok() || !store.begin().ok() || !report(ready)) _exit(1);
    raise(SIGSTOP);
  });
  const Status reported = updates();
  EXPECT_TRUE(reported.is(StatusCode::lock_holder)) << status_name(reported.code);
  EXPECT_EQ(reported.a, node.process());
  EXPECT_EQ(reported.b, 1) << "ended";
  const int how = node.end();
  EXPECT_TRUE(WIFSIGNALED(how) && WTERMSIG(how) == SIGKILL) << how;
  EXPECT_OK(store_.begin());
  EXPECT_OK(watch_.look(store_, lease_s));
}

TEST_F(LockLeaseTest, AnotherProgramIsNamedOnceAndLeftAlone) {
  Child foreign([&](int ready) {
    // Another program with the lock: locks stay when a process becomes one, and end with any descriptor of the file.
    for (int inherited = 3; inherited < 256; ++inherited) {
      if (inherited != ready) close(inherited);
    }
    const int index = open((path_ + "-shm").c_str(), O_RDWR);
    struct flock range {};
    range.l_type = F_WRLCK;
    range.l_whence = SEEK_SET;
    range.l_start = 120;
    range.l_len = 1;
    if (index < 0 || fcntl(index, F_SETLK, &range) != 0 || !report(ready)) _exit(1);
    execl("/bin/sleep", "sleep", "600", nullptr);
  });
  const Status reported = updates();
  EXPECT_TRUE(reported.is(StatusCode::lock_holder)) << status_name(reported.code);
  EXPECT_EQ(reported.a, foreign.process());
  EXPECT_EQ(reported.b, 0);
  EXPECT_EQ(store_.begin().code, StatusCode::store_locked);
  EXPECT_OK(watch_.look(store_, 0)) << "once";
  EXPECT_EQ(kill(foreign.process(), 0), 0) << "it runs";
}

TEST_F(LockLeaseTest, ProcessesThatKeepTheLockInTurnAreNeitherNamedNorEnded) {
  for (int turn = 0; turn < 4; ++turn) {
    const Child node([&](int ready) {
      SqliteStore store;
      if (!store.open(path_.c_str()).ok() || !store.begin().ok() || !report(ready)) _exit(1);
      for (;;) pause();
    });
    ASSERT_EQ(store_.begin().code, StatusCode::store_locked);
    for (int look = 0; look < 3; ++look) {
      EXPECT_OK(watch_.look(store_, 600));
      usleep(1000);
    }
    EXPECT_EQ(kill(node.process(), 0), 0);
  }
  EXPECT_OK(store_.begin());
}

}  // namespace
}  // namespace ilp
