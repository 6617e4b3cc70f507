// Holds the bytes of a received product or of a record's blob in memory or in a temporary file. A run needs these bytes
// only once or twice, and the file lets a long flight take little memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace ilp::intake {

/// A temporary file without a name, which ends with the process. All functions may be called from several threads at
/// once, and throw std::runtime_error.
class Spool {
 public:
  /// Creates the file in `folder`. The system's folder for temporary files is not used, because it may be in memory.
  explicit Spool(const std::filesystem::path& folder);
  ~Spool();
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;

  /// Appends bytes, and returns their offset in the file.
  std::uint64_t append(std::span<const std::uint8_t> bytes);
  /// Fills `bytes` from offset `from`.
  void read(std::uint64_t from, std::span<std::uint8_t> bytes) const;
  /// Size of the file, bytes.
  [[nodiscard]] std::uint64_t size() const { return size_; }

 private:
  int file_ = -1;
  std::mutex mutex_;
  std::uint64_t size_ = 0;
};

/// The bytes of one product or blob. Copies of the object share them.
class CodedFile {
 public:
  CodedFile() = default;
  CodedFile(std::vector<std::uint8_t> bytes)
      : size_(bytes.size()), held_(std::make_shared<const std::vector<std::uint8_t>>(std::move(bytes))) {}
  CodedFile(std::initializer_list<std::uint8_t> bytes) : CodedFile(std::vector<std::uint8_t>(bytes)) {}

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] std::vector<std::uint8_t> bytes() const;
  /// Moves the bytes from memory to the file. Does nothing if they are there already.
  void put_away(const std::shared_ptr<Spool>& spool);
  void clear() { *this = {}; }

 private:
  std::size_t size_ = 0;
  std::shared_ptr<const std::vector<std::uint8_t>> held_;
  std::shared_ptr<Spool> spool_;
  std::uint64_t from_ = 0;
};

}  // namespace ilp::intake
