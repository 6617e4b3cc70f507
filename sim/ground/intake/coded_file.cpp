#include "sim/ground/intake/coded_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>

namespace ilp::intake {
namespace {

[[noreturn]] void fail(const char* what) {
  throw std::runtime_error(std::string("the products of the flight cannot be ") + what +
                           " in the folder of the results: " + std::strerror(errno));
}

}  // namespace

Spool::Spool(const std::filesystem::path& folder) {
  std::string name = (folder / ".products-XXXXXX").string();
  file_ = ::mkostemp(name.data(), O_CLOEXEC);
  if (file_ < 0) fail("put away");
  ::unlink(name.c_str());
}

Spool::~Spool() {
  ::close(file_);
}

std::uint64_t Spool::append(std::span<const std::uint8_t> bytes) {
  const std::lock_guard lock(mutex_);
  const std::uint64_t begin = size_;
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(file_, bytes.data(), bytes.size(), static_cast<off_t>(size_));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail("put away");
    bytes = bytes.subspan(static_cast<std::size_t>(written));
    size_ += static_cast<std::uint64_t>(written);
  }
  return begin;
}

void Spool::read(std::uint64_t from, std::span<std::uint8_t> bytes) const {
  while (!bytes.empty()) {
    const ssize_t got = ::pread(file_, bytes.data(), bytes.size(), static_cast<off_t>(from));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) fail("read back");
    bytes = bytes.subspan(static_cast<std::size_t>(got));
    from += static_cast<std::uint64_t>(got);
  }
}

std::vector<std::uint8_t> CodedFile::bytes() const {
  if (held_) return *held_;
  std::vector<std::uint8_t> read(size_);
  if (spool_) spool_->read(from_, read);
  return read;
}

void CodedFile::put_away(const std::shared_ptr<Spool>& spool) {
  if (!held_) return;
  from_ = spool->append(*held_);
  spool_ = spool;
  held_.reset();
}

}  // namespace ilp::intake
