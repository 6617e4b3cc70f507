// The nonvolatile memory outside the database: whatever is cut off or spoilt, a content that was written is read.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "hal/nonvolatile/file_nonvolatile.hpp"
#include "hal/nonvolatile/ram_nonvolatile.hpp"
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes content(std::uint8_t number, std::size_t size = 5000) {
  Bytes bytes(size, number);
  bytes[0] = static_cast<std::uint8_t>(size & 0xFFU);
  return bytes;
}

class FileNonvolatileTest : public testing::Test {
 protected:
  Status read(Bytes& bytes) const {
    FileNonvolatile memory;
    bytes.assign(max_nonvolatile_bytes, 0);
    std::size_t size = 0;
    Status status = memory.open(path_.c_str());
    if (status.ok()) status = memory.read(bytes, size);
    bytes.resize(size);
    return status;
  }
  void write(const Bytes& bytes) const {
    FileNonvolatile memory;
    ASSERT_TRUE(memory.open(path_.c_str()).ok());
    ASSERT_TRUE(memory.write(bytes).ok());
  }
  [[nodiscard]] std::string file(int number) const { return path_ + ".keep-" + std::to_string(number); }
  static std::string text_of(const std::string& name) {
    std::ifstream in(name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  static void overwrite(const std::string& name, std::streamoff at, const std::string& text) {
    std::fstream out(name, std::ios::in | std::ios::out | std::ios::binary);
    out.seekp(at);
    out << text;
  }

  test::TemporaryFolder folder_;
  std::string path_ = folder_ / "flight.db";
};

TEST_F(FileNonvolatileTest, TheLatestContentComesBackAfterEveryWrite) {
  Bytes bytes;
  EXPECT_STATUS(read(bytes), not_found);
  for (std::uint8_t i = 1; i < 10; ++i) {
    write(content(i, 100U * i));
    ASSERT_TRUE(read(bytes).ok());
    EXPECT_EQ(bytes, content(i, 100U * i));
  }
  FileNonvolatile memory;
  ASSERT_TRUE(memory.open(path_.c_str()).ok());
  EXPECT_STATUS(memory.write(Bytes(max_nonvolatile_bytes + 1)), capacity_exceeded);
  std::size_t size = 0;
  Bytes small(10);
  EXPECT_STATUS(memory.read(small, size), capacity_exceeded);
}

// The newer file is what a write was interrupted in: cut off anywhere, the content before it is read.
TEST_F(FileNonvolatileTest, AWriteThatWasCutOffAnywhereLeavesTheContentBefore) {
  write(content(1));
  write(content(2));
  const std::string before = text_of(file(1)), other = text_of(file(2));
  write(content(3));
  const std::string after = text_of(file(1));
  ASSERT_EQ(text_of(file(2)), other) << "the file of the content before was touched";
  ASSERT_EQ(before.size(), after.size());
  Bytes bytes;
  int old = 0, young = 0;
  for (std::size_t cut = 0; cut <= after.size(); cut += cut < 64 ? 1 : 509) {
    overwrite(file(1), 0, after.substr(0, cut) + before.substr(cut));
    ASSERT_TRUE(read(bytes).ok()) << cut;
    (bytes == content(3) ? young : old) += 1;
    EXPECT_TRUE(bytes == content(3) || bytes == content(2)) << cut;
  }
  EXPECT_GT(old, 10);
  EXPECT_GT(young, 10);
}

TEST_F(FileNonvolatileTest, NoSingleDamagedPlaceLosesTheLatestContent) {
  write(content(1));
  write(content(2));
  Bytes bytes;
  for (int number = 1; number <= 2; ++number) {
    const std::string whole = text_of(file(number));
    for (std::size_t at = 0; at < whole.size(); at += at % 8192 < 40 ? 1 : 397) {
      std::string flipped = whole.substr(at, 1);
      flipped[0] = static_cast<char>(flipped[0] ^ 0x10);
      overwrite(file(number), static_cast<std::streamoff>(at), flipped);
      ASSERT_TRUE(read(bytes).ok()) << number << " " << at;
      ASSERT_EQ(bytes, content(2)) << number << " " << at;
      overwrite(file(number), static_cast<std::streamoff>(at), whole.substr(at, 1));
    }
  }
}

TEST_F(FileNonvolatileTest, ADamagedFileIsWrittenAgainAndTheOtherNotTouched) {
  write(content(1));
  write(content(2));
  overwrite(file(2), 0, std::string(16384, 'x'));
  Bytes bytes;
  ASSERT_TRUE(read(bytes).ok());
  EXPECT_EQ(bytes, content(1));
  const std::string valid = text_of(file(1));
  write(content(3));
  EXPECT_EQ(text_of(file(1)), valid);
  ASSERT_TRUE(read(bytes).ok());
  EXPECT_EQ(bytes, content(3));
  for (const int number : {1, 2}) overwrite(file(number), 0, std::string(16384, 'x'));
  EXPECT_STATUS(read(bytes), record_damaged);
  write(content(4));
  ASSERT_TRUE(read(bytes).ok());
  EXPECT_EQ(bytes, content(4));
}

TEST_F(FileNonvolatileTest, AProcessKilledAtAnyMomentLeavesAWholeContent) {
  for (int round = 0; round < 10; ++round) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      FileNonvolatile memory;
      if (!memory.open(path_.c_str()).ok()) _exit(1);
      for (std::uint8_t i = 1;; i = static_cast<std::uint8_t>(i % 250 + 1)) {
        if (!memory.write(content(i)).ok()) _exit(1);
      }
    }
    usleep(3000 + 1700 * static_cast<useconds_t>(round));
    kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status));
    Bytes bytes;
    const Status found = read(bytes);
    if (found.is(StatusCode::not_found)) continue;
    ASSERT_TRUE(found.ok());
    EXPECT_EQ(bytes, content(bytes.at(1)));
  }
}

TEST_F(FileNonvolatileTest, ADiskWithoutRoomStopsNoWrite) {
  write(content(1));
  // No file of this process may grow any more: as on a disk that is full.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit none = before;
  none.rlim_cur = 16384;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &none), 0);
  for (std::uint8_t i = 2; i < 6; ++i) write(content(i));
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  static_cast<void>(std::signal(SIGXFSZ, handler));
  Bytes bytes;
  ASSERT_TRUE(read(bytes).ok());
  EXPECT_EQ(bytes, content(5));
}

TEST_F(FileNonvolatileTest, OneProcessHasItAndADiskThatIsNotThereIsAStatus) {
  FileNonvolatile first, second;
  ASSERT_TRUE(first.open(path_.c_str()).ok());
  EXPECT_STATUS(second.open(path_.c_str()), io_error);
  EXPECT_STATUS(second.write(content(1)), io_error);
  first.close();
  EXPECT_TRUE(second.open(path_.c_str()).ok());
  FileNonvolatile nowhere;
  EXPECT_STATUS(nowhere.open((folder_ / "none/flight.db").c_str()), io_error);
  Bytes bytes(100);
  std::size_t size = 0;
  EXPECT_STATUS(nowhere.read(bytes, size), io_error);
}

TEST(RamNonvolatile, GivesBackWhatWasWritten) {
  RamNonvolatile memory;
  Bytes bytes(max_nonvolatile_bytes);
  std::size_t size = 0;
  EXPECT_STATUS(memory.read(bytes, size), not_found);
  ASSERT_TRUE(memory.write(content(7, 300)).ok());
  ASSERT_TRUE(memory.read(bytes, size).ok());
  bytes.resize(size);
  EXPECT_EQ(bytes, content(7, 300));
  EXPECT_STATUS(memory.write(Bytes(max_nonvolatile_bytes + 1)), capacity_exceeded);
}

}  // namespace
}  // namespace ilp
