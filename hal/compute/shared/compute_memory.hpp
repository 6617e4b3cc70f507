// The memory of fixed size and layout that the flight shares with the program of a compute device. The flight makes the
// memory and seals its size, so that the program cannot shrink it. The flight trusts no content of the memory: it
// copies a result out and then checks the copy.
//
// All numbers have the byte order and the alignment of the board. Each kind of job has a mailbox, an input and an
// output.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/compute/cpu/cpu_compute.hpp"

namespace ilp {

inline constexpr std::uint32_t compute_memory_magic = 0x49504C43;  // "CLPI"

struct ComputeMailbox {
  std::uint32_t asked = 0;       ///< number of the newest job; the flight writes it after the input
  std::uint32_t answered = 0;    ///< number of the newest result; the device's program writes it after the output
  std::uint64_t input_sum = 0;   ///< compute_sum() of the input
  std::uint64_t output_sum = 0;  ///< compute_sum() of the output
  std::uint64_t input_offset = 0, output_offset = 0;  ///< bytes from the begin of the memory
  std::uint64_t input_bytes = 0, output_bytes = 0;
  std::uint64_t layout = 0;  ///< ComputeForm::layout
};

struct ComputeHeader {
  std::uint32_t magic = compute_memory_magic;
  std::uint32_t layout = 0;  ///< layout_digest() of this struct
  std::uint64_t bytes = 0;   ///< size of the memory with this header
  ComputeMailbox boxes[compute_kinds];
};

/// Returns the header of a memory for these kinds of job.
[[nodiscard]] ComputeHeader compute_header(const ComputeForms& forms);

/// Returns the checksum of an input or output of job `number`. It depends on kind and number, so that a result of
/// another job does not pass.
[[nodiscard]] std::uint64_t compute_sum(std::span<const std::byte> bytes, ComputeKind kind, std::uint32_t number);

/// Owns the mapping of the shared memory into one process.
class ComputeMemory {
 public:
  ComputeMemory() = default;
  ComputeMemory(const ComputeMemory&) = delete;
  ComputeMemory& operator=(const ComputeMemory&) = delete;
  ~ComputeMemory() { close(); }

  /// For the flight: makes and maps a memory of zeros and writes the header. Every page is touched. Returns `io_error`
  /// (first value: errno) if the kernel refuses.
  Status make(const ComputeHeader& header);
  /// For the program: maps the memory that the flight has passed as `file`, which stays open. Returns `parse_error` if
  /// size or header differ from `expected`, `io_error` (first value: errno) if the kernel refuses.
  Status map(int file, const ComputeHeader& expected);
  void close();

  [[nodiscard]] bool open() const { return begin_ != nullptr; }
  [[nodiscard]] int file() const { return file_; }
  [[nodiscard]] std::byte* at(std::size_t offset) const { return begin_ + offset; }
  [[nodiscard]] ComputeMailbox& box(ComputeKind kind) const {
    return reinterpret_cast<ComputeHeader*>(begin_)->boxes[static_cast<std::size_t>(kind)];
  }

 private:
  Status map_file(int file, std::size_t bytes);

  std::byte* begin_ = nullptr;
  std::size_t bytes_ = 0;
  int file_ = -1;  ///< descriptor of the memory that make() has made, else -1
};

}  // namespace ilp
