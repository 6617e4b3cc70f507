// The bytes of a received product or of a record's blob, which a run needs once or twice: in memory, or put away in a
// file, so that a long flight takes little memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace ilp::intake {

/// A file without a name, which is gone with the process. All functions may be called from several threads at once and
/// throw std::runtime_error.
class Spool {
 public:
  /// In this folder, because memory may be all that the usual one for such files has.
  explicit Spool(const std::filesystem::path& folder);
  ~Spool();
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;

  /// Where the bytes are from now on.
  std::uint64_t append(std::span<const std::uint8_t> bytes);
  void read(std::uint64_t from, std::span<std::uint8_t> bytes) const;
  /// Of the file.
  [[nodiscard]] std::uint64_t size() const { return size_; }

 private:
  int file_ = -1;
  std::mutex mutex_;
  std::uint64_t size_ = 0;
};

/// Copies share the bytes.
class CodedFile {
 public:
  CodedFile() = default;
  CodedFile(std::vector<std::uint8_t> bytes)
      : size_(bytes.size()), held_(std::make_shared<const std::vector<std::uint8_t>>(std::move(bytes))) {}
  CodedFile(std::initializer_list<std::uint8_t> bytes) : CodedFile(std::vector<std::uint8_t>(bytes)) {}

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] std::vector<std::uint8_t> bytes() const;
  void put_away(const std::shared_ptr<Spool>& spool);
  void clear() { *this = {}; }

 private:
  std::size_t size_ = 0;
  std::shared_ptr<const std::vector<std::uint8_t>> held_;
  std::shared_ptr<Spool> spool_;
  std::uint64_t from_ = 0;
};

}  // namespace ilp::intake
