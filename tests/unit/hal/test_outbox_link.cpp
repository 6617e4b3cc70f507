// The outbox: files appear whole or not at all, confirmations are accepted only when they read as such.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "hal/link/outbox/outbox_link.hpp"
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace {

/// What was synchronised, in order: the outbox's files by their names at that time, folders by theirs.
struct Synchronised {
  std::vector<std::string> names;
  int fail_at = -1;  ///< which of the calls fails
  bool watched = false;
};
Synchronised synchronised;

}  // namespace

/// In the place of the C library's.
extern "C" int fsync(int file) {
  if (synchronised.watched) {
    char path[4096] = {};
    const std::string link = "/proc/self/fd/" + std::to_string(file);
    const auto size = readlink(link.c_str(), path, sizeof(path) - 1);
    synchronised.names.push_back(
        std::filesystem::path(std::string(path, static_cast<std::size_t>(size > 0 ? size : 0))).filename());
    if (static_cast<int>(synchronised.names.size()) - 1 == synchronised.fail_at) {
      errno = EIO;
      return -1;
    }
  }
  return static_cast<int>(syscall(SYS_fsync, file));
}

namespace ilp {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

class OutboxLinkTest : public testing::Test {
 protected:
  OutboxLinkTest() {
    fs::create_directory(out_);
    fs::create_directory(acknowledgements_);
    EXPECT_OK(link_.open(out_.c_str(), acknowledgements_.c_str()));
  }
  std::vector<std::string> outbox() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(out_)) names.push_back(entry.path().filename());
    return names;
  }
  Status acknowledge(const std::string& content) {
    std::ofstream(acknowledgements_ + "/a.jp2.ack", std::ios::binary) << content;
    return link_.acknowledged("a.jp2", bytes_, crc_);
  }

  test::TemporaryFolder folder_;
  std::string out_ = folder_ / "out";
  std::string acknowledgements_ = folder_ / "ack";
  OutboxLink link_;
  std::uint32_t bytes_ = 1;
  std::uint32_t crc_ = 1;
};

TEST_F(OutboxLinkTest, FileAppearsWholeAtItsEnd) {
  ASSERT_OK(link_.begin_file("a.jp2"));
  ASSERT_OK(link_.write(Bytes{1, 2, 3}));
  EXPECT_FALSE(fs::exists(out_ + "/a.jp2")) << "before its end";
  ASSERT_OK(link_.write({}));
  ASSERT_OK(link_.write(Bytes(100000, 4)));
  ASSERT_OK(link_.end_file());
  EXPECT_EQ(outbox(), std::vector<std::string>{"a.jp2"});
  std::ifstream in(out_ + "/a.jp2", std::ios::binary);
  const Bytes content{std::istreambuf_iterator<char>(in), {}};
  Bytes expected{1, 2, 3};
  expected.resize(100003, 4);
  EXPECT_EQ(content, expected);

  ASSERT_OK(link_.begin_file("a.jp2"));
  ASSERT_OK(link_.end_file());
  EXPECT_EQ(fs::file_size(out_ + "/a.jp2"), 0U) << "sent again, it replaces the earlier one";
}

TEST_F(OutboxLinkTest, AFileIsOnTheDiskBeforeItCountsAsSent) {
  using Names = std::vector<std::string>;
  const auto send = [&](int fail_at) {
    synchronised = {{}, fail_at, true};
    EXPECT_OK(link_.begin_file("a.jp2"));
    EXPECT_OK(link_.write(Bytes(10, 1)));
    const Status ended = link_.end_file();
    synchronised.watched = false;
    return ended;
  };
  // First its bytes under the temporary name, then the folder that has its name.
  EXPECT_OK(send(-1));
  EXPECT_EQ(synchronised.names, (Names{"a.jp2.part", "out"}));
  fs::remove(out_ + "/a.jp2");
  EXPECT_STATUS(send(0), io_error);
  EXPECT_TRUE(outbox().empty()) << "the disk does not have its bytes";
  EXPECT_STATUS(send(1), io_error);
  EXPECT_EQ(outbox(), Names{"a.jp2"}) << "whole, but it may be gone after a power cut: it goes again";
}

TEST_F(OutboxLinkTest, AbandonedFileLeavesNothing) {
  ASSERT_OK(link_.begin_file("a.jp2"));
  ASSERT_OK(link_.write(Bytes(10, 1)));
  ASSERT_OK(link_.begin_file("b.jp2"));
  ASSERT_OK(link_.write(Bytes(10, 1)));
  ASSERT_OK(link_.end_file());
  EXPECT_EQ(outbox(), std::vector<std::string>{"b.jp2"});
  {
    OutboxLink other;
    ASSERT_OK(other.open(out_.c_str(), acknowledgements_.c_str()));
    ASSERT_OK(other.begin_file("c.jp2"));
  }
  EXPECT_EQ(outbox(), std::vector<std::string>{"b.jp2"});
}

TEST_F(OutboxLinkTest, FailedWriteLeavesNothing) {
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = signal(SIGXFSZ, SIG_IGN);
  const rlimit small{1000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  ASSERT_OK(link_.begin_file("a.jp2"));
  const Status written = link_.write(Bytes(5000, 1));
  const Status ended = link_.end_file();
  setrlimit(RLIMIT_FSIZE, &before);
  signal(SIGXFSZ, handler);
  EXPECT_EQ(written.code, StatusCode::io_error);
  EXPECT_EQ(ended.code, StatusCode::invalid_argument) << "there is no file to end";
  EXPECT_TRUE(outbox().empty());
}

TEST_F(OutboxLinkTest, FailedRenamingLeavesNothing) {
  fs::create_directories(out_ + "/a.jp2/in_the_way");
  ASSERT_OK(link_.begin_file("a.jp2"));
  EXPECT_STATUS(link_.end_file(), io_error);
  EXPECT_EQ(outbox(), std::vector<std::string>{"a.jp2"});
  EXPECT_TRUE(fs::is_directory(out_ + "/a.jp2"));
}

TEST_F(OutboxLinkTest, NamesThatAreNoneAreRefused) {
  const std::string long_name(600, 'n');
  for (const char* name : {"", ".", "..", "../x", "a/b", "/etc/x", ".hidden"}) {
    EXPECT_STATUS(link_.begin_file(name), invalid_argument) << name;
    EXPECT_STATUS(link_.acknowledged(name, bytes_, crc_), invalid_argument) << name;
  }
  EXPECT_STATUS(link_.begin_file(nullptr), invalid_argument);
  EXPECT_STATUS(link_.begin_file(long_name.c_str()), capacity_exceeded);
  EXPECT_STATUS(link_.acknowledged(long_name.c_str(), bytes_, crc_), capacity_exceeded);
  EXPECT_STATUS(link_.write(Bytes(1)), invalid_argument);
  EXPECT_STATUS(link_.end_file(), invalid_argument);
  EXPECT_TRUE(outbox().empty());
}

TEST_F(OutboxLinkTest, FoldersMustExist) {
  OutboxLink link;
  EXPECT_STATUS(link.begin_file("a"), invalid_argument) << "never opened";
  EXPECT_STATUS(link.acknowledged("a", bytes_, crc_), invalid_argument);
  EXPECT_STATUS(link.open((folder_ / "none").c_str(), out_.c_str()), io_error);
  std::ofstream(folder_ / "file") << "x";
  EXPECT_STATUS(link.open(out_.c_str(), (folder_ / "file").c_str()), io_error);
  EXPECT_STATUS(link.open(out_.c_str(), std::string(5000, 'p').c_str()), capacity_exceeded);
}

TEST_F(OutboxLinkTest, BelievesACompleteAcknowledgementOnly) {
  EXPECT_STATUS(link_.acknowledged("a.jp2", bytes_, crc_), not_ready);
  ASSERT_OK(acknowledge("123456 4294967295\n"));
  EXPECT_EQ(bytes_, 123456U);
  EXPECT_EQ(crc_, 4294967295U);
  bytes_ = 7;
  crc_ = 7;
  const std::string whole = "123 456\n";
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_STATUS(acknowledge(whole.substr(0, size)), not_ready) << "after " << size << " bytes";
  }
  using namespace std::string_literals;
  for (const std::string& hostile :
       {"123 456 \n"s, "123 456\n\n"s, "123  456\n"s, " 123 456\n"s, "-1 5\n"s, "1 -5\n"s, "0x10 5\n"s,
        "1 4294967296\n"s, "99999999999999999999 1\n"s, "a\n"s, "123\n"s, "1 2 3\n"s, "123 456\r\n"s, "\0"s, "1 2\0\n"s,
        "1\0002\n"s, std::string(1000000, '1'), std::string(100, ' '), "123 456\n" + std::string(100, '\0')}) {
    EXPECT_STATUS(acknowledge(hostile), parse_error) << hostile.substr(0, 40);
  }
  EXPECT_EQ(bytes_, 7U) << "set by an acknowledgement that was refused";
  EXPECT_EQ(crc_, 7U);
}

}  // namespace
}  // namespace ilp
