// The memory that the flight and the program of a compute device share: of fixed size, with a fixed layout. The flight
// makes it and seals its size, so that nobody can shrink it under the flight's feet. It trusts nothing that it reads
// there: it copies a result out and then checks the copy.
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
  std::uint32_t asked = 0;      ///< number of the newest job; the flight writes it after the input
  std::uint32_t answered = 0;   ///< number of the newest result; the device's program writes it after the output
  std::uint64_t input_sum = 0;  ///< compute_sum() of the input
  std::uint64_t output_sum = 0;
  std::uint64_t input_offset = 0, output_offset = 0;  ///< from the begin of the memory
  std::uint64_t input_bytes = 0, output_bytes = 0;
  std::uint64_t layout = 0;  ///< ComputeForm::layout
};

struct ComputeHeader {
  std::uint32_t magic = compute_memory_magic;
  std::uint32_t layout = 0;  ///< of this struct (layout_digest)
  std::uint64_t bytes = 0;   ///< of the whole memory
  ComputeMailbox boxes[compute_kinds];
};

/// The header of a memory for these jobs.
[[nodiscard]] ComputeHeader compute_header(const ComputeForms& forms);

/// Checksum of an input or output of job `number`.
[[nodiscard]] std::uint64_t compute_sum(std::span<const std::byte> bytes, ComputeKind kind, std::uint32_t number);

/// A mapped piece of shared memory.
class ComputeMemory {
 public:
  ComputeMemory() = default;
  ComputeMemory(const ComputeMemory&) = delete;
  ComputeMemory& operator=(const ComputeMemory&) = delete;
  ~ComputeMemory() { close(); }

  /// Makes it, zeroed and touched, and writes the header. `io_error` (a = errno).
  Status make(const ComputeHeader& header);
  /// Maps what another process has made: `file` stays open. `parse_error` where it has not this build's header.
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
  int file_ = -1;  ///< of what was made here
};

}  // namespace ilp
